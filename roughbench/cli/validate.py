"""``roughbench validate``: check specs without computing anything."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from roughbench.cli.options import debug_option, example

if TYPE_CHECKING:
    from roughbench.planning.cells import Cell


@click.command(
    "validate",
    epilog=example("roughbench validate spec.yaml", "roughbench validate configs/*.yaml"),
)
@click.argument(
    "specs", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="SPEC..."
)
@debug_option
@click.pass_context
def command(ctx: click.Context, specs: tuple[Path, ...]) -> None:
    """Check each SPEC without computing anything.

    Says what it would compute, or all that is wrong with it. Every fault comes with
    file, line, column and key. The exit code is 2 if any spec has one.
    """
    from roughbench.cli import EXIT_INVALID
    from roughbench.errors import SpecError, SurfaceError
    from roughbench.runner import check, plan, warnings
    from roughbench.spec import load_spec

    valid = True
    for spec in specs:
        try:
            cells = plan(load_spec(spec))
            check(cells)
        except SpecError as error:
            click.echo(str(error), err=True)
            valid = False
        except SurfaceError as error:
            for line in str(error).splitlines():
                click.echo(f"{spec}: error: {line}", err=True)
            valid = False
        else:
            for text in warnings(cells):
                click.echo(f"{spec}: warning: {text}", err=True)
            click.echo(f"{spec}: valid; {_content(cells)}")
    ctx.exit(0 if valid else EXIT_INVALID)


def _content(cells: list[Cell]) -> str:
    experiments = dict.fromkeys(cell.experiment for cell in cells)
    states = sum(cell.n_states for cell in cells)
    models = ", ".join(dict.fromkeys(cell.model.name for cell in cells))
    many = "s" * (len(experiments) > 1)
    return f"{len(experiments)} experiment{many}, {models}, {states} states{_units(cells)}"


def _units(cells: list[Cell]) -> str:
    """Return contact moduli and pressures of specs with units."""
    from roughbench.units import in_words

    moduli = sorted({cell.modulus for cell in cells if cell.modulus is not None})
    if not moduli:
        return ""
    pressures = [p * (cell.modulus or 1.0) for cell in cells for p in cell.pressures]
    ends = " … ".join(in_words(p, "Pa") for p in (min(pressures), max(pressures)))
    return f"; E* = {', '.join(in_words(value, 'Pa') for value in moduli)}, p = {ends}"
