"""Options and arguments that several commands share."""

from __future__ import annotations

import sys
from pathlib import Path

import click

DEBUG = "roughbench.debug"
"""Key of the context's meta data: whether errors show their traceback."""


def _remember_debug(ctx: click.Context, _parameter: click.Parameter, value: bool) -> None:  # noqa: FBT001
    ctx.meta[DEBUG] = value


debug_option = click.option(
    "--debug",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_remember_debug,
    help="Show the traceback of an error.",
)

json_option = click.option("--json", "as_json", is_flag=True, help="Everything, as JSON.")
results_argument = click.argument("results", type=click.Path(path_type=Path))
run_argument = click.argument("path", type=click.Path(path_type=Path), metavar="RESULTS")
reference_option = click.option(
    "--reference",
    metavar="LABEL",
    help="Model that the others are held against; default: the exact solver.",
)
resamples_option = click.option(
    "--resamples",
    type=click.IntRange(min=2),
    default=1000,
    show_default=True,
    help="Draws of the realizations for the errors.",
)


def spec_source(path: Path) -> Path | str:
    """Return a spec's path, or its text where it comes on standard input, as ``-``.

    Raises
    ------
    SpecError
        If what comes is not UTF-8.
    """
    if str(path) != "-":
        return path
    from roughbench.errors import Fault, SpecError

    try:
        text = sys.stdin.buffer.read().decode("utf-8-sig")
    except UnicodeDecodeError:
        message = "is not UTF-8 text; send it as UTF-8"
        raise SpecError([Fault(message, source="standard input")]) from None
    return text + "\n"  # a text has lines, a path has not


def example(*lines: str) -> str:
    """Return the end of a help text that shows how to use a command."""
    return "\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)
