"""``roughbench bundle``: results and all that belongs to them in one archive."""

from __future__ import annotations

from pathlib import Path

import click

from roughbench.cli.options import (
    debug_option,
    example,
    folder_option,
    reference_option,
    resamples_option,
    results_argument,
)


@click.command(
    "bundle",
    epilog=example(
        "roughbench bundle quick.h5",
        "roughbench bundle quick.h5 -o supplement.zip --figure area --figure stiffness",
    ),
)
@results_argument
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="The archive; default NAME-bundle.zip in the current folder. One that is there is "
    "replaced.",
)
@click.option(
    "--figure",
    "names",
    multiple=True,
    metavar="NAME",
    help="Draw this figure only, as area; repeatable. Default: all that RESULTS allow.",
)
@folder_option
@reference_option
@resamples_option
@debug_option
def command(
    results: Path,
    output: Path | None,
    names: tuple[str, ...],
    folder: Path | None,
    reference: str | None,
    resamples: int,
) -> None:
    """Pack RESULTS, spec, figures and report into one archive.

    The results file, its spec, the heights and models that it names, figures, report, the
    versions that computed it, a requirements file that pins them, checksums, and how to
    compute it again. The same results make the same bytes. Prints the path of the archive.
    """
    from roughbench.bundle import make_bundle

    target = output or Path(f"{results.stem}-bundle.zip")
    made = make_bundle(
        results,
        target,
        names=names,
        folder=folder,
        reference=reference,
        resamples=resamples,
    )
    click.echo(made)
