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
    bin. The header has the units: 1 is none, length the spec's length unit. Fields that are
    kept are not exported. Prints the paths of the files.
    """
    from roughbench.cli.tables import observables_csv, states_csv, summary_csv
    from roughbench.publish import commit
    from roughbench.store import load

    loaded = load(results)
    folder.mkdir(parents=True, exist_ok=True)
    for experiment, result in loaded.models():
        texts = {"": summary_csv(result)}
        if states:
            texts["-states"] = states_csv(result)
        texts |= {f"-{name}": text for name, text in observables_csv(result).items()}
        for suffix, text in texts.items():
            path = folder / f"{experiment}-{result.label}{suffix}.csv"
            click.echo(commit(text.encode(), path))
