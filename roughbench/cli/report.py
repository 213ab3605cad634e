"""``roughbench report``: one page on what results files say."""

from __future__ import annotations

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
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("report.html"),
    show_default=True,
    metavar="FILE",
    help="The page; replaced if it exists.",
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
    from roughbench.publish import check_writable, commit
    from roughbench.report import make_report

    if output.resolve() in [path.resolve() for path in results]:
        raise click.BadParameter(
            f"{output} is one of the results files; choose another name", param_hint="-o"
        )
    check_writable(output)
    page = make_report(results, reference=reference, resamples=resamples)
    click.echo(commit(page.encode(), output))
