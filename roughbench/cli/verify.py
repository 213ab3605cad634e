"""``roughbench verify``: read all that a run has written, and check it."""

from __future__ import annotations

from pathlib import Path

import click

from roughbench.cli.options import debug_option, example, run_argument


@click.command("verify", epilog=example("roughbench verify quick.h5"))
@run_argument
@debug_option
@click.pass_context
def command(ctx: click.Context, path: Path) -> None:
    """Check the files that the run of RESULTS has written.

    Reads every shard and the results file. Changes nothing; the next run sets damaged shards
    aside and computes them again. The exit code is 1 if anything is damaged.
    """
    from roughbench.cli import EXIT_FAILED
    from roughbench.runner import verify
    from roughbench.text import on_one_line

    sound, faults = verify(path)
    for fault in faults:
        click.echo(f"damaged: {on_one_line(fault)}", err=True)
    click.echo(f"{sound} files are sound, {len(faults)} damaged")
    ctx.exit(EXIT_FAILED if faults else 0)
