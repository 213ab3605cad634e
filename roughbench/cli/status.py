"""``roughbench status``: how far a run is."""

from __future__ import annotations

from pathlib import Path

import click

from roughbench.cli.options import debug_option, example, run_argument

_MOST_SHARES = 10


@click.command(
    "status",
    epilog=example(
        "roughbench status quick.h5", "roughbench status quick.h5 --json | jq '.done / .states'"
    ),
)
@run_argument
@click.option("--json", "as_json", is_flag=True, help="Everything, as JSON.")
@debug_option
def command(path: Path, as_json: bool) -> None:  # noqa: FBT001
    """Say how far the run of RESULTS is.

    Whether it is running, complete or incomplete, and how the realizations of each model
    stand. RESULTS may be the results file, there or still to come, its run directory, or the
    spec.
    """
    import json

    from roughbench.runner import status
    from roughbench.text import on_one_line

    state = status(path)
    if as_json:
        click.echo(json.dumps(state.as_dict(), indent=1))
        return
    lines = [str(part) for part in state.parts]
    lines.append(
        f"{state.results}: {state.state}, {state.done} of {state.states} states are done"
    )
    if state.note:
        click.echo(state.note)
    if state.holder:
        host, process = state.holder.get("host"), state.holder.get("process")
        lines.append(f"process {process} on {host} since {state.holder.get('since')}")
    elif state.shares:
        many = len(state.shares)
        shown = ", ".join(state.shares[:_MOST_SHARES]) + ", …" * (many > _MOST_SHARES)
        lines.append(f"{many} share{'s' * (many > 1)} being computed: {shown}")
    elif state.state == "incomplete" and state.command:
        lines.append(f"resume: {state.command}")
    click.echo("\n".join(on_one_line(line) for line in lines))
