"""``roughbench clean``: remove the run directory of a results file."""

from __future__ import annotations

import json
from pathlib import Path

import click

from roughbench.cli.options import debug_option, example, json_option, run_argument


@click.command(
    "clean", epilog=example("roughbench clean quick.h5", "roughbench clean quick.h5 --unused")
)
@run_argument
@click.option(
    "--unused", is_flag=True, help="Remove only shards that the last run did not need."
)
@json_option
@debug_option
def command(path: Path, unused: bool, as_json: bool) -> None:  # noqa: FBT001
    """Remove the run directory of RESULTS.

    The results file stays. Without its run directory it cannot be extended: the next run
    computes everything again.
    """
    from roughbench.runner import clean

    freed = clean(path, unused=unused)
    if as_json:
        click.echo(json.dumps({"freed": freed}))
        return
    click.echo(f"freed {freed / 1e6:.1f} MB")
