"""``roughbench observe``: observables of the fields that a spec asks for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from roughbench.cli.options import debug_option, example

if TYPE_CHECKING:
    from collections.abc import Iterator

    from roughbench.observe import Observations


@click.command(
    "observe",
    epilog=example(
        "roughbench observe spec.yaml -o fields",
        "roughbench observe spec.yaml --set 'observables=[clusters]'",
    ),
)
@click.argument("spec", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder for the files; default NAME-fields. Made if missing.",
)
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="FFT and loop threads.",
)
@click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change one value of the spec; repeatable.",
)
@click.option("--no-figures", is_flag=True, help="Write the numbers only.")
@click.option("-q", "--quiet", is_flag=True, help="Only errors and warnings on stderr.")
@debug_option
def command(
    spec: Path,
    output: Path | None,
    threads: int,
    overrides: tuple[str, ...],
    no_figures: bool,  # noqa: FBT001
    quiet: bool,  # noqa: FBT001
) -> None:
    """Take observables from the fields of SPEC.

    Solves its states, and writes observables.json with the averages of the spec's
    observables over its realizations, the fields of save_fields as NumPy archives, and
    figures of both: each observable of all models, and where they touch side by side.
    Prints the paths.
    """
    from tqdm import tqdm

    from roughbench.observe import observe, write_observations
    from roughbench.spec import load_spec

    loaded = load_spec(spec, overrides)
    # None: only on a terminal.
    with tqdm(unit="state", disable=True if quiet else None) as bar:

        def told(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        found = observe(loaded, threads=threads, told=told)
    for text in _warnings(found):
        click.echo(text, err=True)
    folder = output or Path(f"{loaded.name}-fields")
    paths = write_observations(found, folder)
    if not no_figures:
        from roughbench.cli.observed_figures import draw

        paths += draw(found, folder)
    for path in paths:
        click.echo(path)


def _warnings(found: Observations) -> Iterator[str]:
    if found.without_fields:
        yield f"note: without fields: {', '.join(found.without_fields)}"
    for experiment, models in found.experiments.items():
        for label, model in models.items():
            if sum(model.unconverged):
                states = model.count * len(model.pressures)
                yield (
                    f"warning: {experiment}/{label}: {sum(model.unconverged)} of {states} "
                    "states did not converge; they are left out of the averages"
                )
    for saved in found.saved:
        if saved.status:
            yield (
                f"warning: {saved.experiment}/{saved.label}: realization "
                f"{saved.realization} at p/E* = {saved.pressure:g} did not converge"
            )
