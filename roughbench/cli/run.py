"""``roughbench run``: compute what a spec asks for."""

from __future__ import annotations

import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roughbench.cli.options import debug_option, example
from roughbench.cli.progress import duration, progress_shown

if TYPE_CHECKING:
    from roughbench.results import Results


@click.command(
    "run",
    epilog=example(
        "roughbench run configs/quick.yaml",
        "roughbench run spec.yaml -j 2 -o h08.h5 --set surface.H=0.8",
    ),
)
@click.argument("spec", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Results file; default NAME.h5 in the current folder. Replaced if it exists.",
)
@click.option(
    "-j", "--jobs", type=click.IntRange(min=1), default=1, help="Tasks at once; default 1."
)
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    help="FFT and loop threads of each task; default: cores / jobs. At equal threads the "
    "results file is the same to the byte for every number of jobs.",
)
@click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change one value of the spec, as surface.H=0.8 or models.bem.grid=256; repeatable.",
)
@click.option("-q", "--quiet", is_flag=True, help="Only errors and warnings on stderr.")
@click.option("-v", "--verbose", is_flag=True, help="A line for everything that is computed.")
@debug_option
def command(
    spec: Path,
    output: Path | None,
    jobs: int,
    threads: int | None,
    overrides: tuple[str, ...],
    quiet: bool,  # noqa: FBT001
    verbose: bool,  # noqa: FBT001
) -> None:
    """Compute what SPEC asks for.

    Writes the results file and prints its path. States that do not converge are left out of the
    averages, counted in the file and reported here.
    """
    from roughbench.runner import run
    from roughbench.spec import load_spec

    start = time.monotonic()
    loaded = load_spec(spec, overrides)
    target = output or Path(f"{loaded.name}.h5")
    with progress_shown(quiet=quiet, verbose=verbose) as progress:
        results = run(loaded, output=target, jobs=jobs, threads=threads, progress=progress)
    for line in _unconverged(results):
        click.echo(line, err=True)
    if not quiet:
        click.echo(_summary(results, target, time.monotonic() - start), err=True)
    click.echo(target)


def _unconverged(results: Results) -> list[str]:
    return [
        f"warning: {experiment}/{result.label}: {result.n_unconverged} of {result.n_states} "
        "states did not converge; they are left out of the averages"
        for experiment, result in results.models()
        if result.n_unconverged
    ]


def _summary(results: Results, target: Path, elapsed: float) -> str:
    counts = [
        f"  {experiment}/{result.label}: {result.n_realizations} × {len(result['pressure'])}"
        for experiment, result in results.models()
    ]
    path = shlex.quote(str(target))
    return "\n".join(
        [
            f"done in {duration(elapsed)}; realizations × pressures:",
            *counts,
            f"show it: roughbench show {path}",
            f"draw it: roughbench plot {path}",
        ]
    )
