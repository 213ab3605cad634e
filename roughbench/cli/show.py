"""``roughbench show``: the curves of a results file as tables, or as JSON."""

from __future__ import annotations

from pathlib import Path

import click

from roughbench.cli.options import (
    debug_option,
    example,
    partial_option,
    results_argument,
    results_read,
)


@click.command(
    "show",
    epilog=example(
        "roughbench show quick.h5",
        "roughbench show quick.h5 --partial",
        "roughbench show quick.h5 --json | jq '.experiments.main.bem.variables.area_mean'",
    ),
)
@results_argument
@click.option("--json", "as_json", is_flag=True, help="Everything in the file, as strict JSON.")
@partial_option
@debug_option
def command(results: Path, as_json: bool, partial: bool) -> None:  # noqa: FBT001
    """Print the curves of RESULTS as tables or JSON.

    Tables show mean ± standard error over the realizations. Lengths are
    divided by h_rms, the rms height of the spectrum (continuum); for heights from a file
    it is theirs. Of a spec with units, pressures, lengths and stiffnesses have theirs, such
    as kPa, nm and MPa/nm. States that did not converge are left out; n counts the
    realizations that did.

    JSON has no infinity and no nan: the stiffness at full contact is the string "inf",
    and what is not defined is null. Units stand beside the variables; with units they
    are those of SI.

    With --partial averages are over the realizations that are finished at all pressures, and
    the title says how many of how many.
    """
    from roughbench.cli.results_json import to_json
    from roughbench.cli.tables import as_text
    from roughbench.text import on_one_line

    with results_read(results, partial=partial) as content:
        if not as_json:
            click.echo(as_text(content, on_one_line(str(results))))
            return
        for piece in to_json(content):
            click.echo(piece, nl=False)
        click.echo()
