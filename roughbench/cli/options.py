"""Options and arguments that several commands share."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from roughbench.results import Results

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
folder_option = click.option(
    "--folder",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    help="Where relative paths in the spec start; default: where the run was, else the folder "
    "of RESULTS.",
)
partial_option = click.option(
    "--partial",
    is_flag=True,
    help="What a run that is not finished has so far: RESULTS as of status, from its run "
    "directory.",
)
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
    return text if "\n" in text else f"{text}\n"  # a text has lines, a path has not


@contextlib.contextmanager
def results_read(path: Path, *, partial: bool) -> Iterator[Results]:
    """Give the content of a results file, or what its run has so far.

    Raises
    ------
    RoughbenchError
        If there is none; says so where a run has something.
    """
    from roughbench.errors import StoreError
    from roughbench.program import command as command_line
    from roughbench.runner import folder_of, partial_results
    from roughbench.store import opened

    if partial:
        yield partial_results(path)
        return
    with contextlib.ExitStack() as stack:
        try:
            results = stack.enter_context(opened(path))
        except StoreError as error:
            if not path.exists() and folder_of(path).is_dir():
                status = command_line("status", path)
                error.add_note(
                    f"its run is not finished: {status}; or see what is there: --partial"
                )
            raise
        yield results


def example(*lines: str) -> str:
    """Return the end of a help text that shows how to use a command."""
    return "\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)
