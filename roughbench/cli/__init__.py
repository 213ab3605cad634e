"""The command ``roughbench``: one thin file per command, imported when it is called.

Exit codes: 0 done, 1 failed, 2 usage or invalid spec, 3 incomplete but resumable, 75
another run has the lock, 130 interrupted. What a program may read (results, JSON, paths of
written files) goes to stdout, all else to stderr.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
import traceback
from collections.abc import Sequence
from typing import Any

import click

from roughbench.cli.interrupts import Terminated, interrupts_get_through
from roughbench.cli.options import DEBUG
from roughbench.errors import (
    IncompleteError,
    LockedError,
    RoughbenchError,
    SpecError,
    SurfaceError,
    explained,
)
from roughbench.program import command as command_line
from roughbench.program import program
from roughbench.system import write_any_text
from roughbench.text import on_one_line, printable, suggestion

COMMANDS = (
    "init",
    "doctor",
    "characterize",
    "run",
    "submit",
    "status",
    "verify",
    "clean",
    "show",
    "fit",
    "report",
    "plot",
    "export",
    "reproduce",
    "bundle",
    "validate",
    "schema",
)

EXIT_FAILED = 1
EXIT_INVALID = 2
EXIT_INCOMPLETE = 3
EXIT_LOCKED = 75
EXIT_INTERRUPTED = 130

_CODES: tuple[tuple[type[BaseException], int], ...] = (
    (SpecError, EXIT_INVALID),
    (SurfaceError, EXIT_INVALID),
    (IncompleteError, EXIT_INCOMPLETE),
    (LockedError, EXIT_LOCKED),
    (Terminated, EXIT_INCOMPLETE),
    (KeyboardInterrupt, EXIT_INTERRUPTED),
    (Exception, EXIT_FAILED),
)


class LazyGroup(click.Group):
    """A group that imports its commands on demand and ends errors in one clean message."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands, in the order of their use."""
        del ctx
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import one command."""
        del ctx
        if cmd_name not in COMMANDS:
            return None
        command = importlib.import_module(f"roughbench.cli.{cmd_name}").command
        return command if isinstance(command, click.Command) else None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Say what was probably meant where there is no such command."""
        word = args[0]
        if word in COMMANDS or word.startswith("-"):
            return super().resolve_command(ctx, args)
        if word.endswith((".yaml", ".yml")):
            hint = f"To compute a spec: {command_line('run', *args)}"
        else:
            near = suggestion(word, COMMANDS)
            hint = f"Did you mean {near!r}?" if near else f"There are {', '.join(COMMANDS)}."
        raise click.UsageError(f"No such command {on_one_line(word)!r}. {hint}", ctx)

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; errors become a message on stderr and a documented exit code."""
        try:
            with interrupts_get_through():
                return super().invoke(ctx)
        except (click.ClickException, click.Abort, click.exceptions.Exit, BrokenPipeError):
            raise  # click knows what to do with them
        except (Exception, KeyboardInterrupt) as error:  # noqa: BLE001, RUF100  (the last resort)
            with contextlib.suppress(OSError):  # of a terminal that has been closed
                if ctx.meta.get(DEBUG):
                    click.echo("".join(traceback.format_exception(error)), err=True, nl=False)
                message = "\n".join([_message(error), *getattr(error, "__notes__", ())])
                click.echo(printable(message), err=True)
            ctx.exit(next(code for kind, code in _CODES if isinstance(error, kind)))

    def main(self, args: Sequence[str] | None = None, *rest: Any, **options: Any) -> Any:
        """Remember the command line, to say how a run is resumed."""
        write_any_text(sys.stdout, sys.stderr)
        given = list(sys.argv[1:] if args is None else args)
        options["obj"] = command_line(*given)
        options.setdefault("prog_name", program())
        return super().main(given, *rest, **options)


def _message(error: BaseException) -> str:
    if isinstance(error, Terminated):
        return f"stopped by {error.name}"
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, SpecError):
        return str(error)  # "file:line:column: error: …", as compilers say it
    if isinstance(error, RoughbenchError):
        return f"error: {error}"
    if isinstance(error, MemoryError):
        return f"error: out of memory ({error}); take a smaller grid or fewer jobs (-j)"
    if (
        isinstance(error, OSError) and error.errno is not None
    ):  # the system's, and no fault here
        places = [on_one_line(os.fsdecode(p)) for p in _places(error)]
        return f"error: {': '.join([*places, explained(error)])}"
    return (
        f"error: {type(error).__name__}: {error}\n"
        "This is a fault of roughbench; --debug shows where. Please report it."
    )


def _places(error: OSError) -> list[str | bytes]:
    """Return the files that an error of the system names; a number is a descriptor."""
    given = (error.filename, error.filename2)
    return [place for place in given if isinstance(place, str | bytes)]


def _print_version(ctx: click.Context, _parameter: click.Parameter, value: bool) -> None:  # noqa: FBT001
    if value and not ctx.resilient_parsing:
        import roughbench

        click.echo(f"roughbench {roughbench.__version__}")
        ctx.exit()


@click.group(
    cls=LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 96},
    epilog="\b\nExample:\n  roughbench run configs/quick.yaml\n  roughbench plot quick.h5",
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Show the version and exit.",
)
def main() -> None:
    """Rough contact on one bench: the exact solver, Popov's foundation, Persson's theory."""
