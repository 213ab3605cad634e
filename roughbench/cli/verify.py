"""``roughbench verify``: read all that a run has written, and check it."""

from __future__ import annotations

import json
from pathlib import Path

import click

from roughbench.cli.options import debug_option, example, json_option, run_argument


@click.command("verify", epilog=example("roughbench verify quick.h5"))
@run_argument
@json_option
@debug_option
@click.pass_context
def command(ctx: click.Context, path: Path, as_json: bool) -> None:  # noqa: FBT001
    """Check the files that the run of RESULTS has written.

    Reads every shard and the results file; where the run directory is not there, the results
    file alone. Changes nothing; the next run sets damaged shards
    aside and computes them again. The exit code is 1 if anything is damaged.
    """
    from roughbench.cli import EXIT_FAILED
    from roughbench.runner import verify
    from roughbench.text import on_one_line

    sound, faults = verify(path)
    if as_json:
        click.echo(json.dumps({"sound": sound, "damaged": faults}, indent=1))
        ctx.exit(EXIT_FAILED if faults else 0)
    for fault in faults:
        click.echo(f"damaged: {on_one_line(fault)}", err=True)
    click.echo(f"{sound} files are sound, {len(faults)} damaged")
    ctx.exit(EXIT_FAILED if faults else 0)
