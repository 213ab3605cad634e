"""``roughbench plot``: the figures of a results file."""

from __future__ import annotations

from pathlib import Path

import click

from roughbench.cli.options import debug_option, example, results_argument


@click.command(
    "plot",
    epilog=example(
        "roughbench plot quick.h5", "roughbench plot quick.h5 -o figures --figure stiffness"
    ),
)
@results_argument
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("figures"),
    show_default=True,
    metavar="DIR",
    help="Folder for the figures; made if missing.",
)
@click.option(
    "--figure",
    "wanted",
    multiple=True,
    metavar="NAME",
    help="Draw this figure only, as area, separation, stiffness, spectrum, pressure_pdf or "
    "contact; repeatable.",
)
@debug_option
def command(results: Path, folder: Path, wanted: tuple[str, ...]) -> None:
    """Draw the figures of RESULTS as PDF and PNG.

    All that it has the data for, if no --figure is given. Prints the paths of the files.
    """
    from roughbench import figures
    from roughbench.store import load

    for name in wanted:
        if name not in figures.FIGURES:
            raise click.BadParameter(
                f"there is no figure {name!r}; choose among {', '.join(figures.FIGURES)}",
                param_hint="--figure",
            )
    loaded = load(results)
    for name in wanted or figures.available(loaded):
        for path in figures.render(loaded, name, folder):
            click.echo(path)
