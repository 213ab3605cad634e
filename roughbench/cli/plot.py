"""``roughbench plot``: the figures of a results file."""

from __future__ import annotations

from pathlib import Path

import click
from click.core import ParameterSource

from roughbench.cli.options import debug_option, example, partial_option, results_read
from roughbench.errors import StoreError
from roughbench.program import command as command_line
from roughbench.text import on_one_line


@click.command(
    "plot",
    epilog=example(
        "roughbench plot quick.h5",
        "roughbench plot quick.h5 -o figures --figure stiffness",
        "roughbench plot h07.h5 h08.h5 -o hurst",
        "roughbench plot paper-fig3.h5 --with paper-bem.h5 --figure printed_fig3",
        "roughbench plot quick.h5 --figure area --overlay measured.csv --format svg",
    ),
)
@click.argument(
    "results", type=click.Path(path_type=Path), nargs=-1, required=True, metavar="RESULTS..."
)
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("figures"),
    show_default=True,
    metavar="DIR",
    help="Folder for the figures; made if missing. Several RESULTS have a folder each in it.",
)
@click.option(
    "--figure",
    "wanted",
    multiple=True,
    metavar="NAME",
    help="Draw this figure only, as area, separation, stiffness, spectrum, pressure_pdf or "
    "contact, or that of a Python file: FILE.py:CLASS; repeatable.",
)
@click.option(
    "--with",
    "others",
    type=click.Path(path_type=Path),
    multiple=True,
    metavar="OTHER",
    help="Draw the models of these results too, where they are of the same surfaces: exact "
    "points that were computed apart; repeatable.",
)
@click.option(
    "--overlay",
    "points",
    type=click.Path(path_type=Path),
    multiple=True,
    metavar="POINTS.csv",
    help="Draw the points of a CSV file over the curves, with an entry in the legend: columns "
    "pressure, area, area_error, separation, … each with its unit in brackets; repeatable.",
)
@click.option(
    "--format",
    "formats",
    type=click.Choice(["pdf", "png", "svg"]),
    multiple=True,
    help="Format of the files; repeatable. Default: pdf and png.",
)
@click.option(
    "--style",
    default="",
    metavar="STYLE",
    help="Style of Matplotlib, by name or as a file, over that of roughbench.",
)
@partial_option
@debug_option
@click.pass_context
def command(
    ctx: click.Context,
    results: tuple[Path, ...],
    folder: Path,
    wanted: tuple[str, ...],
    others: tuple[Path, ...],
    points: tuple[Path, ...],
    formats: tuple[str, ...],
    style: str,
    partial: bool,  # noqa: FBT001
) -> None:
    """Draw the figures of RESULTS as PDF, PNG or SVG.

    All that they have the data for, if no --figure is given. Prints the paths of the files.
    """
    from roughbench import figures
    from roughbench.runner import partial_results
    from roughbench.source_files import names_file
    from roughbench.store import load

    for name in wanted:
        if names_file(name) or name in figures.FIGURES:
            continue
        known = list(figures.FIGURES)
        for path in results:
            with results_read(path, partial=partial) as content:
                known += [own for own in figures.recipes_of(content) if own not in known]
        if name not in known:
            raise click.BadParameter(
                f"there is no figure {name!r}; choose among {', '.join(known)}",
                param_hint="--figure",
            )
    folders = [folder]
    if len(results) > 1:
        from roughbench.report.sources import names_of

        folders = [folder / Path(name).with_suffix("") for name in names_of(results)]
    if ctx.get_parameter_source("folder") is ParameterSource.DEFAULT:
        for path, its_folder in zip(results, folders, strict=True):
            _refuse_to_mix(path, its_folder, figures.drawn_of(its_folder))
    for path, its_folder in zip(results, folders, strict=True):
        loaded = partial_results(path) if partial else load(path)
        for other in others:
            loaded = figures.join(loaded, load(other))
        for file_of_points in points:
            loaded = figures.overlaid(loaded, file_of_points)
        names = list(wanted or figures.available(loaded))
        if points:
            _tell_without_points(names, [n for n in names if figures.shows_points(loaded, n)])
        for name in names:
            for file in figures.render(
                loaded,
                name,
                its_folder,
                path.name,
                formats=formats or figures.USUAL,
                style=style,
            ):
                click.echo(file)


def _tell_without_points(names: list[str], with_points: list[str]) -> None:
    """Say which figures have no place for the points that were laid over; refuse if none."""
    without = [name for name in names if name not in with_points]
    if not with_points:
        raise StoreError(
            f"none of the figures shows the points of --overlay: {', '.join(without)}; choose "
            "--figure area, separation, stiffness or fig3, as their columns say"
        )
    if without:
        click.echo(f"note: without the points of --overlay: {', '.join(without)}", err=True)


def _refuse_to_mix(path: Path, folder: Path, drawn: set[str]) -> None:
    """Two results in one folder look like one; only who names the folder wants that."""
    others = sorted(drawn - {path.name})
    if others:
        other = folder / path.stem
        raise StoreError(
            f"{folder} has the figures of {on_one_line(others[0])}; draw these elsewhere: "
            f"{command_line('plot', path, '-o', other)}, or over those: -o {folder}"
        )
