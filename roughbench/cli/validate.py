"""``roughbench validate``: check specs without computing anything."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roughbench.cli.options import debug_option, example, json_option, spec_source

if TYPE_CHECKING:
    from roughbench.errors import Fault
    from roughbench.planning.cells import Cell


@click.command(
    "validate",
    epilog=example("roughbench validate spec.yaml", "roughbench validate configs/*.yaml"),
)
@click.argument(
    "specs",
    nargs=-1,
    required=True,
    type=click.Path(path_type=Path, allow_dash=True),
    metavar="SPEC...",
)
@json_option
@debug_option
@click.pass_context
def command(ctx: click.Context, specs: tuple[Path, ...], as_json: bool) -> None:  # noqa: FBT001
    """Check each SPEC without computing anything.

    SPEC is a file, or - for standard input. Says what it would compute, or all that is
    wrong with it. Every fault comes with file, line, column and key. The exit code is 2 if
    any spec has one.
    """
    from roughbench.cli import EXIT_INVALID

    found = [_checked(spec) for spec in specs]
    if as_json:
        click.echo(json.dumps([one.as_dict() for one in found], indent=1))
    for one in () if as_json else found:
        for fault in one.faults:
            click.echo(str(fault), err=True)
        for text in one.warnings:
            click.echo(f"{one.spec}: warning: {text}", err=True)
        if not one.faults:
            click.echo(f"{one.spec}: valid; {_content(one.cells)}")
    ctx.exit(EXIT_INVALID if any(one.faults for one in found) else 0)


@dataclass(frozen=True, slots=True)
class _Checked:
    """A spec that was checked: what is wrong with it, or what it asks for."""

    spec: str
    faults: Sequence[Fault] = ()
    warnings: Sequence[str] = ()
    cells: Sequence[Cell] = ()

    def as_dict(self) -> dict[str, Any]:
        return {
            "spec": self.spec,
            "valid": not self.faults,
            "faults": [asdict(fault) for fault in self.faults],
            "warnings": [*self.warnings],
            "models": [
                {
                    "model": str(cell),
                    "realizations": cell.n_realizations,
                    "pressures": len(cell.pressures),
                    "states": cell.n_states,
                }
                for cell in self.cells
            ],
        }


def _checked(spec: Path) -> _Checked:
    from roughbench.errors import Fault, SpecError, SurfaceError
    from roughbench.runner import check, plan, warnings
    from roughbench.spec import load_spec

    name = str(spec)
    try:
        cells = plan(load_spec(spec_source(spec)))
        check(cells)
    except SpecError as error:
        return _Checked(name, faults=error.faults)
    except SurfaceError as error:
        return _Checked(name, [Fault(line, source=name) for line in str(error).splitlines()])
    return _Checked(name, warnings=warnings(cells), cells=cells)


def _content(cells: Sequence[Cell]) -> str:
    experiments = dict.fromkeys(cell.experiment for cell in cells)
    states = sum(cell.n_states for cell in cells)
    models = ", ".join(dict.fromkeys(cell.model.name for cell in cells))
    many = "s" * (len(experiments) > 1)
    return f"{len(experiments)} experiment{many}, {models}, {states} states{_units(cells)}"


def _units(cells: Sequence[Cell]) -> str:
    """Return contact moduli and pressures of specs with units."""
    from roughbench.units import in_words

    moduli = sorted({cell.modulus for cell in cells if cell.modulus is not None})
    if not moduli:
        return ""
    pressures = [p * (cell.modulus or 1.0) for cell in cells for p in cell.pressures]
    ends = " … ".join(in_words(p, "Pa") for p in (min(pressures), max(pressures)))
    return f"; E* = {', '.join(in_words(value, 'Pa') for value in moduli)}, p = {ends}"
