"""``roughbench fit``: what the curves of a results file say in numbers, with errors."""

from __future__ import annotations

from pathlib import Path

import click

from roughbench.cli.options import (
    debug_option,
    example,
    reference_option,
    resamples_option,
    results_argument,
)


@click.command(
    "fit",
    epilog=example(
        "roughbench fit quick.h5",
        "roughbench fit quick.h5 --json | jq '.experiments.main.bem.kappa'",
    ),
)
@results_argument
@click.option("--json", "as_json", is_flag=True, help="All numbers, as strict JSON.")
@reference_option
@resamples_option
@debug_option
def command(results: Path, as_json: bool, reference: str | None, resamples: int) -> None:  # noqa: FBT001
    """Fit the laws of the paper to the curves of RESULTS.

    Prints κ = (A/A0) E*ξ/p and the range where it holds, the region K ~ p, u0 and p0 of
    ū = u0 ln(p0/p), exponent and prefactor of the stiffness of few contacts, and the
    pressures between which each model agrees with the exact one within 10 % and 50 %;
    and in a sentence for each model and quantity, where it can be trusted on these
    surfaces.

    Errors come from a bootstrap over the realizations. The criteria of all ranges stand in
    the documentation, docs/fits.md.
    """
    from roughbench.cli.fit_tables import as_text, to_json
    from roughbench.store import load
    from roughbench.text import on_one_line
    from roughbench.verdict import fit_experiments, trust_of

    loaded, name = load(results), on_one_line(str(results))
    experiments = fit_experiments([(name, loaded)], reference, resamples)
    fitted = {one.experiment: one.fits for one in experiments}
    trusts = trust_of(experiments)
    if as_json:
        click.echo(to_json(loaded, fitted, reference, resamples, trusts))
    else:
        click.echo(as_text(loaded, fitted, name, reference, trusts))
