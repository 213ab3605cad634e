"""``roughbench status``: how far a run is."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roughbench.cli.options import debug_option, example, json_option, run_argument

if TYPE_CHECKING:
    from roughbench.runner import RunState

SECONDS_BETWEEN = 2.0
_SHARE_OF_TIME = 20.0
"""To look takes time where there are many shards: no more than a twentieth of it."""
_MOST_SHARES = 10


@click.command(
    "status",
    epilog=example(
        "roughbench status quick.h5", "roughbench status quick.h5 --json | jq '.done / .states'"
    ),
)
@run_argument
@json_option
@click.option(
    "--watch", is_flag=True, help="Again and again, until everything is computed and written."
)
@debug_option
def command(path: Path, as_json: bool, watch: bool) -> None:  # noqa: FBT001
    """Say how far the run of RESULTS is.

    Whether it is running, complete or incomplete, and how the realizations of each model
    stand. RESULTS may be the results file, there or still to come, its run directory, or the
    spec.
    """
    import json

    from roughbench.runner import status

    if watch and as_json:
        raise click.UsageError("--watch and --json do not go together; leave one out")
    if watch:
        _watch(path)
        return
    state = status(path)
    if as_json:
        click.echo(json.dumps(state.as_dict(), indent=1))
        return
    click.echo("\n".join(_lines(state)))


def _watch(path: Path) -> None:
    """Print how far a run is, again and again, until it is complete."""
    from roughbench.runner import status

    shown = ""
    while True:
        start = time.monotonic()
        state = status(path)
        text = "\n".join(_lines(state))
        if sys.stdout.isatty():
            click.clear()
            click.echo(text)
        elif text != shown:
            click.echo(f"{time.strftime('%H:%M:%S')} {_summary(state)}")
        shown = text
        if state.state == "complete":
            return
        time.sleep(max(SECONDS_BETWEEN, _SHARE_OF_TIME * (time.monotonic() - start)))


def _summary(state: RunState) -> str:
    return f"{state.results}: {state.state}, {state.done} of {state.states} states are done"


def _lines(state: RunState) -> list[str]:
    from roughbench.text import on_one_line

    lines = [str(part) for part in state.parts]
    lines.append(_summary(state))
    if state.note:
        lines.insert(0, state.note)
    if state.holder:
        host, process = state.holder.get("host"), state.holder.get("process")
        lines.append(f"process {process} on {host} since {state.holder.get('since')}")
    elif state.shares:
        many = len(state.shares)
        shown = ", ".join(state.shares[:_MOST_SHARES]) + ", …" * (many > _MOST_SHARES)
        lines.append(f"{many} share{'s' * (many > 1)} being computed: {shown}")
    elif state.state == "incomplete" and state.command:
        lines.append(f"resume: {state.command}")
    return [on_one_line(line) for line in lines]
