"""``roughbench report``: one page on what results files say."""

from __future__ import annotations

import os
from pathlib import Path

import click

from roughbench.cli.options import (
    debug_option,
    example,
    reference_option,
    resamples_option,
)


@click.command(
    "report",
    epilog=example(
        "roughbench report quick.h5",
        "roughbench report rolloff.h5 cutoff.h5 -o cutoffs.html --resamples 200",
    ),
)
@click.argument(
    "results", type=click.Path(path_type=Path), nargs=-1, required=True, metavar="RESULTS..."
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("report.html"),
    show_default=True,
    metavar="FILE",
    help="The page; one that is there is replaced. The folder is made if missing.",
)
@reference_option
@resamples_option
@debug_option
def command(
    results: tuple[Path, ...], output: Path, reference: str | None, resamples: int
) -> None:
    """Write a page on RESULTS: figures, verdicts, fits.

    One HTML file that a browser opens without a network: interactive figures of all
    curves; which of the paper's claims hold, by which rule and with which numbers; the fits
    with errors; what to know before trusting them; and how to compute it all again.
    """
    from roughbench.outputs import check_output, write_output
    from roughbench.publish import make_folder
    from roughbench.report import PAGE, make_report

    if os.path.realpath(output) in [os.path.realpath(path) for path in results]:
        raise click.BadParameter(
            f"{output} is one of the results files; choose another name", param_hint="-o"
        )
    check_output(output, PAGE)
    page = make_report(results, reference=reference, resamples=resamples)
    make_folder(output.parent)
    click.echo(write_output(page.encode(), output, PAGE))
