"""``roughbench export``: a results file as CSV, and its fields as NPZ or VTK."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from roughbench.cli.options import debug_option, example, results_argument

if TYPE_CHECKING:
    from roughbench.results import Results


@click.command(
    "export",
    epilog=example(
        "roughbench export quick.h5 --csv tables",
        "roughbench export quick.h5 --csv tables --states",
        "roughbench export fields.h5 --vtk fields",
    ),
)
@results_argument
@click.option(
    "--csv",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder for tables of the curves; made if missing.",
)
@click.option(
    "--states",
    is_flag=True,
    help="Also EXPERIMENT-MODEL-states.csv with every realization at every pressure.",
)
@click.option(
    "--npz",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder for the fields that the run kept, as NumPy's .npz.",
)
@click.option(
    "--vtk",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder for these fields as .vti, which ParaView and VisIt open.",
)
@debug_option
def command(
    results: Path,
    folder: Path | None,
    states: bool,  # noqa: FBT001
    npz: Path | None,
    vtk: Path | None,
) -> None:
    """Write curves and fields of RESULTS as CSV, NPZ, VTK.

    DIR/EXPERIMENT-MODEL.csv holds the averages over the realizations, one row a pressure,
    and DIR/EXPERIMENT-MODEL-OBSERVABLE.csv those of an observable, one row a pressure and
    bin. The header has the units: 1 is none, length the spec's length unit; of a spec
    with units they are those of SI. Fields are files of their own,
    EXPERIMENT-MODEL-REALIZATION-PRESSURE. Prints the paths of the files. Letters that file
    names should not have are written as %XX, long names are shortened, and equal ones
    numbered.
    """
    from roughbench.store import load

    if folder is None and npz is None and vtk is None:
        raise click.UsageError("say what to export and where to: --csv, --npz or --vtk DIR")
    if states and folder is None:
        raise click.UsageError("--states adds to the tables of --csv DIR, which is not given")
    loaded = load(results)
    if folder is not None:
        _write_tables(loaded, folder, states=states)
    for its_folder, suffix in ((npz, ".npz"), (vtk, ".vti")):
        if its_folder is not None:
            _write_fields(loaded, its_folder, suffix)


def _write_tables(results: Results, folder: Path, *, states: bool) -> None:
    from roughbench.cli.results_csv import TABLE, observables_csv, states_csv, summary_csv
    from roughbench.outputs import check_output, write_output
    from roughbench.publish import make_folder

    names = _Names()
    texts: dict[Path, str] = {}
    for experiment, result in results.models():
        parts = {"": summary_csv(result)}
        if states:
            parts["-states"] = states_csv(result)
        parts |= {f"-{name}": text for name, text in observables_csv(result).items()}
        for suffix, text in parts.items():
            texts[folder / names.give(experiment, f"{result.label}{suffix}")] = text
    for path in texts:
        check_output(path, TABLE)  # all of them before the first is written
    make_folder(folder)
    for path, text in texts.items():
        click.echo(write_output(text.encode(), path, TABLE))


def _write_fields(results: Results, folder: Path, suffix: str) -> None:
    from roughbench.errors import StoreError
    from roughbench.field_files import FIELD_FILES, saved_fields, write_fields
    from roughbench.outputs import check_output
    from roughbench.publish import make_folder

    names = _Names(suffix)
    paths = [
        folder / names.give(experiment, f"{result.label}-{called}")
        for experiment, result in results.models()
        for called, _, _ in saved_fields(result)
    ]
    if not paths:
        raise StoreError(
            "the results have no fields; ask for them in the spec, "
            "save_fields: {pressures: [...], realizations: [0]}, and run it again"
        )
    for path in paths:
        check_output(path, FIELD_FILES[suffix])
    make_folder(folder)
    remaining = iter(paths)
    for _, result in results.models():
        for _, fields, more in saved_fields(result):
            click.echo(write_fields(fields, next(remaining), more))


class _Names:
    """Names of files that lead out of no folder, fit every disk, and differ on all of them."""

    longest = 200

    def __init__(self, suffix: str = ".csv") -> None:
        self._suffix = suffix
        self._given: set[str] = set()

    def give(self, experiment: str, table: str) -> str:
        import hashlib
        import urllib.parse

        whole = f"{experiment}-{table}"
        text = urllib.parse.quote(whole, safe="=,+[]")
        if text.startswith("."):  # hidden
            text = f"%2E{text[1:]}"
        if len(text) > self.longest:
            digest = hashlib.sha256(whole.encode()).hexdigest()[:8]
            text = f"{text[: self.longest - 9]}~{digest}"
        name, number = text, 1
        while name.casefold() in self._given:
            number += 1
            name = f"{text}~{number}"
        self._given.add(name.casefold())
        return f"{name}{self._suffix}"
