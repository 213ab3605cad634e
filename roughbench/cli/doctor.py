"""``roughbench doctor``: what this machine offers, and what a run would miss."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roughbench.cli.options import debug_option, example, json_option, spec_source
from roughbench.text import on_one_line

if TYPE_CHECKING:
    from roughbench.runner import Diagnosis


@click.command(
    "doctor",
    epilog=example(
        "roughbench doctor",
        "roughbench doctor spec.yaml",
        "roughbench doctor --json | jq '.faults'",
    ),
)
@click.argument(
    "spec", required=False, type=click.Path(path_type=Path, allow_dash=True), metavar="[SPEC]"
)
@json_option
@debug_option
@click.pass_context
def command(ctx: click.Context, spec: Path | None, as_json: bool) -> None:  # noqa: FBT001
    """Say what this machine offers, and how long SPEC takes.

    Versions, cores, memory and the largest grid that the exact solver has room for; the time
    of Fourier transforms; whether the cache folder and the current folder can be written and
    know locks. With SPEC how long its run takes, by what each of its models was measured to
    take here, on cores that do nothing else.

    The exit code is 1 if the current folder cannot be written.
    """
    from roughbench.cli import EXIT_FAILED
    from roughbench.runner import diagnose

    found = diagnose(
        None if spec is None else spec_source(spec),
        measuring=lambda text: click.echo(text, err=True),
    )
    if as_json:
        click.echo(json.dumps(found.as_dict(), indent=1))
    else:
        click.echo("\n".join(on_one_line(line) for line in _lines(found)))
    ctx.exit(0 if found.working.writable else EXIT_FAILED)


def _lines(found: Diagnosis) -> list[str]:
    from roughbench.cli.progress import duration
    from roughbench.memory import gigabytes

    lines = [f"{name:12} {value}" for name, value in found.machine.items() if name != "cores"]
    lines.append(f"{'cores':12} {found.cores} for this process")
    if found.memory is None:
        lines.append(f"{'memory':12} the system does not say")
    else:
        lines.append(f"{'memory':12} {gigabytes(found.memory)} for a run: {found.memory_limit}")
    lines.append(f"{'exact solver':12} up to {found.largest_grid}\u00b2 points")
    times = ", ".join(
        f"{1e3 * seconds:.1f} ms with {threads} thread{'s' * (threads > 1)}"
        for threads, seconds in found.transform_seconds.items()
    )
    lines.append(
        f"{'FFT':12} {found.transforms}: {times}, for a pair at 1024\u00b2 points in single "
        "precision"
    )
    for name, state in (("cache", found.cache), ("folder", found.working)):
        can = "can be written" if state.writable else "cannot be written"
        locks = {True: ", knows locks", False: ", knows no locks", None: ""}[state.locks]
        lines.append(f"{name:12} {state.path}: {can}{locks}, {gigabytes(state.free)} free")
    if found.estimate is not None:
        lines.append(
            f"{'spec':12} {found.estimate.tasks} tasks, about "
            f"{duration(found.estimate.seconds)} here ({duration(found.estimate.core_seconds)} "
            f"of one core), {gigabytes(found.estimate.memory)} for the largest"
        )
    lines += [f"warning: {fault}" for fault in found.faults]
    return lines
