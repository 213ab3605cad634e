"""The results files of a report, under names that tell them apart and no one's folders."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from roughbench.errors import StoreError
from roughbench.figures.labels import experiment_label, smallest_wavevector, titles
from roughbench.report.markup import escape, from_mathtext
from roughbench.results import ModelResult, Results
from roughbench.store import load


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """One results file.

    Attributes
    ----------
    name : str
        Of the file, with as many of its folders as it takes to tell it from the others.
    results : Results
    """

    name: str
    results: Results

    def models(self) -> Iterator[tuple[str, ModelResult]]:
        """Yield every (experiment, result), in the order of the spec."""
        return self.results.models()

    def experiment(self, name: str) -> str:
        """Return how an experiment is called on the page, as HTML."""
        return experiment_html(name, smallest_wavevector(self.results, name))

    def title(self, label: str) -> str:
        """Return what a model is called on the page: its title, which tells it from others."""
        found = {result.label: result for _, result in self.models()}
        return titles(found)[label]

    def has(self, reference: str | None) -> str | None:
        """Return a label if all experiments have a model of this name, else None."""
        known = all(reference in models for models in self.results.values())
        return reference if known else None


def read_sources(paths: Sequence[Path]) -> list[Source]:
    """Read results files.

    Parameters
    ----------
    paths : sequence of Path

    Returns
    -------
    list of Source
        In the order given.

    Raises
    ------
    StoreError
        If a file is missing, damaged or none of roughbench, or is given twice.
    """
    return [Source(name, load(path)) for name, path in zip(names_of(paths), paths, strict=True)]


def names_of(paths: Sequence[Path]) -> list[str]:
    """Return the shortest ends of the paths that tell them apart.

    Examples
    --------
    >>> names_of([Path("a/quick.h5"), Path("b/quick.h5")])
    ['a/quick.h5', 'b/quick.h5']
    """
    parts = [path.absolute().resolve().parts for path in paths]
    for number, own in enumerate(parts):
        if own in parts[:number]:
            raise StoreError(f"{paths[number]}: given twice; give every results file once")
    return [_name(own, [other for other in parts if other is not own]) for own in parts]


def _name(own: tuple[str, ...], others: Sequence[tuple[str, ...]]) -> str:
    length = 1
    while any(other[-length:] == own[-length:] for other in others):
        length += 1
    return "/".join(own[-length:])


def experiment_html(experiment: str, q_min: float | None = None) -> str:
    r"""Return the name of an experiment as HTML, ``main`` for the only one.

    Other wavevectors are divided by ``q_min``, q0, where it is known.

    Examples
    --------
    >>> experiment_html("surface.length=12.566370614359172")
    'L\xa0=\xa012.5664'
    """
    label = experiment_label(experiment, q_min)
    return from_mathtext(label).replace(" = ", "\xa0=\xa0") or "main"


def full_places(sources: Sequence[Source]) -> dict[str, str]:
    """Return what warnings call a model, always with its file → the same as HTML."""
    return {
        f"{source.name}: {experiment}/{result.label}": ", ".join(
            [escape(source.name)]
            + [source.experiment(experiment)] * (len(source.results) > 1)
            + [escape(source.title(result.label))]
        )
        for source in sources
        for experiment, result in source.models()
    }


def places(sources: Sequence[Source]) -> dict[str, str]:
    """Return what verdicts call a model, with and without its file → the same as HTML."""
    found = {}
    for source in sources:
        for experiment, result in source.models():
            words = [source.experiment(experiment)] * (len(source.results) > 1)
            words += [escape(source.name)] * (len(sources) > 1)
            text = escape(source.title(result.label))
            if words:
                text += f', <span class="muted">{", ".join(words)}</span>'
            name = f"{experiment}/{result.label}"
            found[f"{source.name}: {name}" if len(sources) > 1 else name] = text
    return found
