"""``roughbench reproduce``: a results file computed anew, and what differs."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roughbench.cli.options import (
    debug_option,
    example,
    folder_option,
    json_option,
    results_argument,
)
from roughbench.text import on_one_line

if TYPE_CHECKING:
    from roughbench.runner import Reproduction


@click.command(
    "reproduce",
    epilog=example(
        "roughbench reproduce quick.h5",
        "roughbench reproduce published.h5 -o check/published.h5 --figure area",
        "roughbench reproduce quick.h5 --json | jq '.agrees'",
    ),
)
@results_argument
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Results file to write; default NAME-reproduced.h5 in the current folder.",
)
@click.option(
    "--figure",
    "wanted",
    multiple=True,
    metavar="NAME",
    help="Compute only what this figure needs, as area or fig3; repeatable.",
)
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="SHARE",
    help="Relative deviation that passes for agreement; default: the root of the solver's "
    "tolerance, 1e-9 for models without one.",
)
@folder_option
@click.option("-j", "--jobs", type=click.IntRange(min=1), help="Tasks at once, as of run.")
@click.option("--threads", type=click.IntRange(min=1), help="Of each task, as of run.")
@click.option("--max-memory", metavar="SIZE", help="Of all tasks together, as of run.")
@click.option("-f", "--force", is_flag=True, help="Compute what an earlier call has, too.")
@json_option
@click.option("-q", "--quiet", is_flag=True, help="Only errors and warnings on stderr.")
@debug_option
@click.pass_context
def command(
    ctx: click.Context,
    /,
    results: Path,
    output: Path | None,
    wanted: tuple[str, ...],
    as_json: bool,  # noqa: FBT001
    quiet: bool,  # noqa: FBT001
    **options: Any,
) -> None:
    """Compute RESULTS anew, and say how far the two are apart.

    RESULTS may be of an earlier version of roughbench, and needs no other file beside it than
    heights and models that its spec names. It stays as it is. For every quantity of every
    model the largest deviation of a state is printed, what would pass for agreement, and the
    largest deviation of the mean over its standard error; then in what versions, code and
    options differ, as far as RESULTS or its run directory tell.

    The exit code is 0 if all deviations are within what is allowed, else 1.
    """
    from roughbench.cli import EXIT_FAILED
    from roughbench.cli.progress import progress_shown
    from roughbench.runner import reproduce
    from roughbench.store import opened

    target = output or Path(f"{results.stem}-reproduced.h5")
    lacks = []
    if wanted:
        from roughbench.figures import NOT_COMPUTED, needed

        if idle := sorted(NOT_COMPUTED.intersection(wanted)):
            raise click.BadParameter(
                f"{idle[0]!r} shows what the spec says, and nothing is computed for it",
                param_hint="--figure",
            )
        with opened(results) as content:
            lacks = [needed(content, name) for name in wanted]
    with progress_shown(quiet=quiet, verbose=False) as progress:
        found = reproduce(
            results, target, lacks=lacks, progress=progress, command=ctx.obj or "", **options
        )
    if as_json:
        click.echo(json.dumps(found.as_dict(), indent=1, allow_nan=False))
    else:
        click.echo("\n".join(on_one_line(line) for line in _lines(found)))
    ctx.exit(0 if found.agrees else EXIT_FAILED)


def _lines(found: Reproduction) -> list[str]:
    width = max([len("model"), *(len(one.model) for one in found.deviations)])
    heading = (
        f"{'model':{width}}  {'quantity':16}  {'states':>7}  {'deviation':>9}  {'allowed':>7}  "
        f"{'/error':>7}"
    )
    lines = [heading]
    for one in found.deviations:
        error = f"{'-':>7}" if math.isnan(one.of_error) else f"{one.of_error:7.1g}"
        line = (
            f"{one.model:{width}}  {one.quantity:16}  {one.states:7d}  {one.deviation:9.1e}  "
            f"{one.allowed:7.0e}  {error}"
        )
        if not one.agrees:
            line += f"  DIFFERS, most at realization {one.realization}"
            line += f", pressure {one.pressure}" * (one.pressure > 0)
        lines.append(line)
    lines += [f"not compared: {fault}" for fault in found.faults]
    if not found.origin_is_known:
        lines.append(f"{found.results} does not say by which versions it was made")
    lines += [f"since then: {line}" for line in found.origins]
    if found.origin_is_known and not found.origins:
        lines.append("versions, code and options are the same")
    verdict = "agrees with" if found.agrees else "DIFFERS from"
    lines.append(f"{found.reproduced} {verdict} {found.results}")
    return lines
