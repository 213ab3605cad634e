"""``roughbench export``: a results file as CSV."""

from __future__ import annotations

from pathlib import Path

import click

from roughbench.cli.options import debug_option, example, results_argument


@click.command(
    "export",
    epilog=example(
        "roughbench export quick.h5 --csv tables",
        "roughbench export quick.h5 --csv tables --states",
    ),
)
@results_argument
@click.option(
    "--csv",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    metavar="DIR",
    help="Folder for the files; made if missing.",
)
@click.option(
    "--states",
    is_flag=True,
    help="Also EXPERIMENT-MODEL-states.csv with every realization at every pressure.",
)
@debug_option
def command(results: Path, folder: Path, states: bool) -> None:  # noqa: FBT001
    """Write the curves of RESULTS as CSV.

    DIR/EXPERIMENT-MODEL.csv holds the averages over the realizations, one row a pressure,
    and DIR/EXPERIMENT-MODEL-OBSERVABLE.csv those of an observable, one row a pressure and
    bin. The header has the units: 1 is none, length the spec's length unit; of a spec
    with units they are those of SI. Fields that are
    kept are not exported. Prints the paths of the files. Letters that file names should not
    have are written as %XX, long names are shortened, and equal ones numbered.
    """
    from roughbench.cli.results_csv import TABLE, observables_csv, states_csv, summary_csv
    from roughbench.outputs import check_output, write_output
    from roughbench.publish import make_folder
    from roughbench.store import load

    loaded = load(results)
    names = _Names()
    texts: dict[Path, str] = {}
    for experiment, result in loaded.models():
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


class _Names:
    """Names of files that lead out of no folder, fit every disk, and differ on all of them."""

    longest = 200

    def __init__(self) -> None:
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
        return f"{name}.csv"
