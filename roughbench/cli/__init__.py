"""The command ``roughbench``: one thin file per command, imported when it is called.

Exit codes: 0 done, 1 failed, 2 usage or invalid spec, 130 interrupted. What a program
may read (results, JSON, paths of written files) goes to stdout, all else to stderr.
"""

from __future__ import annotations

import importlib
import traceback
from typing import Any

import click

from roughbench.cli.interrupts import interrupts_get_through
from roughbench.cli.options import DEBUG
from roughbench.errors import RoughbenchError, SpecError, SurfaceError

COMMANDS = ("run", "show", "plot", "export", "validate", "schema")

EXIT_FAILED = 1
EXIT_INVALID = 2
EXIT_INTERRUPTED = 130


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

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; errors become a message on stderr and a documented exit code."""
        try:
            with interrupts_get_through():
                return super().invoke(ctx)
        except (click.ClickException, click.Abort, click.exceptions.Exit, BrokenPipeError):
            raise  # click knows what to do with them
        except KeyboardInterrupt:
            click.echo("interrupted", err=True)
            ctx.exit(EXIT_INTERRUPTED)
        except Exception as error:  # noqa: BLE001, RUF100  (the last resort of a command)
            if ctx.meta.get(DEBUG):
                click.echo("".join(traceback.format_exception(error)), err=True, nl=False)
            click.echo(_message(error), err=True)
            invalid = isinstance(error, SpecError | SurfaceError)
            ctx.exit(EXIT_INVALID if invalid else EXIT_FAILED)


def _message(error: Exception) -> str:
    if isinstance(error, SpecError):
        return str(error)  # "file:line:column: error: …", as compilers say it
    if isinstance(error, RoughbenchError):
        return f"error: {error}"
    if isinstance(error, MemoryError):
        return f"error: out of memory ({error}); take a smaller grid or fewer jobs (-j)"
    return (
        f"error: {type(error).__name__}: {error}\n"
        "This is a fault of roughbench; --debug shows where. Please report it."
    )


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
