"""``roughbench submit``: a run as jobs of Slurm, each of which computes a share."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from roughbench.cli.options import debug_option, example, json_option, spec_source


@click.command(
    "submit",
    epilog=example(
        "roughbench submit spec.yaml --array 40 --profile short",
        "roughbench submit spec.yaml --array 40 --walltime 04:00:00 --cpus 4 -n",
    ),
)
@click.argument("spec", type=click.Path(path_type=Path, allow_dash=True))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Results file, as of run; default NAME.h5 in the current folder.",
)
@click.option(
    "--array",
    "shares",
    type=click.IntRange(min=1, max=100_000),
    required=True,
    metavar="N",
    help="How many jobs, each with one share.",
)
@click.option("--profile", "name", metavar="NAME", help="Of the configuration file.")
@click.option("--partition", help="Of Slurm; more than the profile's, as all that follow.")
@click.option("--account", help="Of Slurm.")
@click.option("--walltime", metavar="TIME", help="Of each job; default 01:00:00.")
@click.option(
    "--cpus", type=click.IntRange(min=1), help="Cores of each job, threads of each task; 1."
)
@click.option(
    "--memory",
    metavar="SIZE",
    help="Of each job, as 16G; default: what the largest task needs.",
)
@click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change one value of the spec, as of run; repeatable.",
)
@click.option("-f", "--force", is_flag=True, help="Replace the results of another spec.")
@click.option("-n", "--dry-run", is_flag=True, help="Only show the scripts of the jobs.")
@json_option
@debug_option
def command(
    spec: Path,
    output: Path | None,
    shares: int,
    name: str | None,
    overrides: tuple[str, ...],
    force: bool,  # noqa: FBT001
    dry_run: bool,  # noqa: FBT001
    as_json: bool,  # noqa: FBT001
    **given: Any,
) -> None:
    """Submit SPEC to Slurm, as an array of jobs.

    Each job computes one share (run --share), and says what it does in RESULTS.rbrun/jobs.
    When all have ended, however they have, the last job computes what is missing and writes
    the results file. The spec is kept as it is now. Prints the numbers of the jobs.
    """
    from roughbench.runner import JobProfile, load_profile, share_jobs, submit_shares
    from roughbench.spec import load_spec

    loaded = load_spec(spec_source(spec), overrides)
    profile = (load_profile(name) if name is not None else JobProfile()).changed(**given)
    target = output or Path(f"{loaded.name}.h5")
    jobs, text = share_jobs(loaded, target, shares, profile, force=force)
    if dry_run:
        scripts = {"array": jobs.array_script(), "assembling": jobs.assembling_script()}
        click.echo(json.dumps(scripts, indent=1) if as_json else "\n".join(scripts.values()))
        return
    made = submit_shares(jobs, text)
    if as_json:
        found = {
            "results": str(made.results),
            "array": {"job": made.jobs[0], "script": str(made.array)},
            "assembling": {"job": made.jobs[1], "script": str(made.assembling)},
        }
        click.echo(json.dumps(found, indent=1))
        return
    click.echo(f"{made.jobs[0]}: {shares} shares of {target}")
    click.echo(f"{made.jobs[1]}: writes {target} when they have ended")
