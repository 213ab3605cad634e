"""``roughbench run``: compute what a spec asks for."""

from __future__ import annotations

import json
import re
import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roughbench.cli.options import debug_option, example, json_option, spec_source
from roughbench.program import command as command_line
from roughbench.text import on_one_line

if TYPE_CHECKING:
    from roughbench.runner import Account, Progress
    from roughbench.spec import Spec


@click.command(
    "run",
    epilog=example(
        "roughbench run configs/quick.yaml",
        "roughbench run spec.yaml -j 2 -o h08.h5 --set surface.H=0.8",
        "roughbench run spec.yaml -n",
        "roughbench run - -o rough.h5",
    ),
)
@click.argument("spec", type=click.Path(path_type=Path, allow_dash=True))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Results file; default NAME.h5 in the current folder. Results that are there are "
    "replaced, other files never. The folder is made if missing.",
)
@click.option(
    "-j",
    "--jobs",
    type=click.IntRange(min=1),
    help="Tasks at once; default: as many as cores and memory allow.",
)
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    help="FFT and loop threads of each task; default: cores / jobs, or without -j, all cores "
    "for large grids and one for small ones. At equal threads the results file is the same "
    "to the byte for every number of jobs.",
)
@click.option(
    "--max-memory",
    metavar="SIZE",
    help="Memory that all tasks together may take by estimate, as 12G; default: 80 % of what "
    "is available.",
)
@click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change one value of the spec, as surface.H=0.8 or models.bem.grid=256; repeatable.",
)
@click.option("-n", "--dry-run", is_flag=True, help="Only say what would be computed, and why.")
@click.option(
    "-f",
    "--force",
    is_flag=True,
    help="Compute everything again; replace results of another spec.",
)
@click.option(
    "-k", "--keep-going", is_flag=True, help="After a task that fails, finish all others first."
)
@click.option(
    "--only",
    multiple=True,
    metavar="TASK",
    help="Compute only this: main/bem; main/bem:4, its fourth realization; or bem, that of "
    "every experiment; repeatable.",
)
@click.option(
    "--share",
    default="",
    metavar="K/N",
    help="Compute the K-th of N shares only, beside other processes that compute others; in "
    "the end a run without it writes the results.",
)
@click.option(
    "--engine",
    "kind",
    type=click.Choice(["local", "dask", "slurm"]),
    default="local",
    help="Where: on this machine, on a Dask cluster that is running, or in jobs of Slurm.",
)
@click.option(
    "--scheduler", default="", metavar="ADDRESS", help="Of the Dask cluster: tls://host:8786."
)
@click.option(
    "--scheduler-file", default="", metavar="FILE", help="Of the Dask cluster, instead."
)
@click.option(
    "--insecure-scheduler",
    is_flag=True,
    help="Take a scheduler of another machine although it has no TLS: everybody who reaches "
    "its port can run programs as you.",
)
@click.option(
    "--patience",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="MINUTES",
    help="How long a cluster may be unable to compute anything before the run ends, "
    "resumable; default: 10, or for Slurm a day.",
)
@click.option(
    "--dashboard", is_flag=True, help="With Slurm: open Dask's dashboard on this machine."
)
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    default=4,
    show_default=True,
    help="Most jobs of Slurm at a time.",
)
@click.option("--walltime", default="01:00:00", show_default=True, help="Of each job of Slurm.")
@click.option("--partition", default="", help="Of Slurm.")
@click.option("--account", default="", help="Of Slurm.")
@click.option(
    "--log-file",
    type=click.Path(path_type=Path),
    help="A second log, as RESULTS.rbrun/run.log.",
)
@click.option("-q", "--quiet", is_flag=True, help="Only errors and warnings on stderr.")
@click.option(
    "-v", "--verbose", is_flag=True, help="Show the log on stderr: a line for every task."
)
@json_option
@debug_option
@click.pass_obj
def command(
    line: str | None,
    /,
    spec: Path,
    output: Path | None,
    dry_run: bool,  # noqa: FBT001
    quiet: bool,  # noqa: FBT001
    verbose: bool,  # noqa: FBT001
    as_json: bool,  # noqa: FBT001
    share: str,
    **options: Any,
) -> None:
    """Compute what SPEC asks for, and is not there already.

    SPEC is a file, or - for standard input. Writes the results file and prints its path.
    Finished tasks are kept in its run directory, RESULTS.rbrun; after an interruption, a
    crash or a change of the spec the same command computes what is missing. States that do
    not converge are left out of the averages, counted in the file and reported here.
    Observables and fields that SPEC asks for are taken from the states as they are solved.
    """
    from roughbench.cli.progress import duration, first_kept, progress_shown
    from roughbench.runner import Cluster, accounts, preview, run_to_file
    from roughbench.spec import load_spec

    start = time.monotonic()
    loaded = load_spec(spec_source(spec), options.pop("overrides"))
    target = output or Path(f"{loaded.name}.h5")
    if share:
        _run_share(share, loaded, target, line or "", as_json, quiet, verbose, dry_run, options)
        return
    engine = {name: options.pop(name) for name in _CLUSTER}
    cluster = None if engine["kind"] == "local" else Cluster(**engine)
    if dry_run:
        for name in ("keep_going", "log_file"):
            options.pop(name)
        parts = preview(
            loaded,
            output=target,
            cluster=cluster,
            measuring=lambda text: None if quiet else click.echo(text, err=True),
            **options,
        )
        if as_json:
            click.echo(json.dumps([part.as_dict() for part in parts], indent=1))
            return
        for part in parts:
            click.echo(on_one_line(str(part)))
        click.echo(_total([part.tasks for part in parts], sum(part.seconds for part in parts)))
        return
    begun: list[Progress] = []
    with progress_shown(quiet=quiet, verbose=verbose) as progress:
        run_to_file(
            loaded,
            target,
            progress=progress and first_kept(progress, begun),
            cluster=cluster,
            command=line or "",
            **options,
        )
    models = accounts(target)
    for text in _unconverged(models):
        click.echo(text, err=True)
    if not quiet:
        took = f"done in {duration(time.monotonic() - start)}"
        click.echo(_summary(models, target, took + _found(begun)), err=True)
        for text in _without_fields(loaded):
            click.echo(text, err=True)
    if as_json:
        made = {"results": str(target), "models": [asdict(model) for model in models]}
        click.echo(json.dumps(made, indent=1))
        return
    click.echo(target)


def _run_share(
    text: str,
    spec: Spec,
    target: Path,
    line: str,
    as_json: bool,  # noqa: FBT001
    quiet: bool,  # noqa: FBT001
    verbose: bool,  # noqa: FBT001
    dry_run: bool,  # noqa: FBT001
    options: dict[str, Any],
) -> None:
    """Compute a share, and say what is left."""
    from roughbench.cli.progress import progress_shown
    from roughbench.errors import RoughbenchError
    from roughbench.runner import parse_share, run_share

    try:
        share = parse_share(text)
    except RoughbenchError as error:
        raise click.BadParameter(str(error), param_hint="--share") from None
    given = {"--force": options.pop("force"), "--only": options.pop("only")}
    given |= {"--engine": options["kind"] != "local", "--dry-run": dry_run}
    for name, value in given.items():
        if value:
            raise click.UsageError(f"--share and {name} do not go together; leave one out")
    for name in _CLUSTER:
        options.pop(name)
    assembling = re.sub(r" --share[ =]\S+", "", line)
    with progress_shown(quiet=quiet, verbose=verbose) as progress:
        found = run_share(
            spec,
            target,
            share,
            progress=progress,
            command=line,
            assembling=assembling,
            **options,
        )
    if as_json:
        found_all = {"results": str(target), **asdict(found), "left": found.left}
        click.echo(json.dumps(found_all, indent=1))
        return
    many = "s" * (found.tasks != 1)
    left = f"{found.left} of {found.states} states are left to others"
    left = left if found.left else "all is done"
    click.echo(f"share {share}: {found.tasks} task{many} computed; {left}")
    if not found.left and not quiet:
        click.echo(f"write the results: {assembling}", err=True)


_CLUSTER = (
    "kind",
    "scheduler",
    "scheduler_file",
    "workers",
    "walltime",
    "partition",
    "account",
    "insecure_scheduler",
    "dashboard",
    "patience",
)


def _total(tasks: list[int], seconds: float) -> str:
    from roughbench.cli.progress import duration

    if not sum(tasks):
        return "nothing to compute"
    return f"{sum(tasks)} tasks to compute, about {duration(seconds)} of one core"


def _unconverged(models: list[Account]) -> list[str]:
    return [
        f"warning: {model.name}: {model.unconverged} of {model.states} "
        "states did not converge; they are left out of the averages"
        for model in models
        if model.unconverged
    ]


def _without_fields(spec: Spec) -> list[str]:
    if spec.observables is None and spec.save_fields is None:
        return []
    names = [
        f"{experiment}/{model.name}"
        for experiment, variant in spec.experiments()
        for model in variant.models
        if not model.has_fields
    ]
    return [f"note: no observables, as without fields: {', '.join(names)}"] if names else []


def _found(begun: list[Progress]) -> str:
    """Return what of a run was there when it began."""
    if not begun or not begun[0].done:
        return ""
    if begun[0].done == begun[0].total:
        return ", nothing was computed, as all states are there (--force computes them again)"
    return f", {begun[0].done} of {begun[0].total} states were there already"


def _summary(models: list[Account], target: Path, done: str) -> str:
    from roughbench.cli.progress import duration

    lines = [
        f"  {model.name}: {model.realizations} × {model.pressures}, {duration(model.seconds)} "
        f"of tasks, {model.memory / 1e9:.2f} GB at most"
        for model in models
    ]
    return "\n".join(
        [
            f"{done}; realizations × pressures:",
            *lines,
            f"show it: {command_line('show', target)}",
            f"draw it: {command_line('plot', target)}",
        ]
    )
