"""The results files of a report, under names that tell them apart and no one's folders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from roughbench.errors import StoreError
from roughbench.figures.labels import experiment_label, smallest_wavevector, titles
from roughbench.report.text import RichText, Span, from_mathtext, joined
from roughbench.results import ModelResult, Results
from roughbench.store import load


@dataclass(frozen=True, slots=True, eq=False)
class ReportSource:
    """One results file, named with as many folders as it takes to tell it from the others."""

    name: str
    results: Results

    @property
    def stem(self) -> str:
        """Name of the file without folders and ending."""
        return PurePosixPath(self.name).stem

    @property
    def has_sweep(self) -> bool:
        """Whether there are several experiments, which have to be told apart."""
        return len(self.results) > 1

    def models(self) -> Iterator[tuple[str, ModelResult]]:
        """Yield every (experiment, result), in the order of the spec."""
        return self.results.models()

    def by_label(self) -> dict[str, list[ModelResult]]:
        """Return the results of each model in all experiments."""
        found: dict[str, list[ModelResult]] = {}
        for _, result in self.models():
            found.setdefault(result.label, []).append(result)
        return found

    def experiment(self, name: str) -> RichText:
        """Return what an experiment is called on the page, ``main`` for the only one.

        Other wavevectors are divided by q0, where it is known.
        """
        label = experiment_label(name, smallest_wavevector(self.results, name))
        return from_mathtext(label.replace(" = ", "\xa0=\xa0")) or [Span("main")]

    def title(self, label: str) -> str:
        """Return what a model is called on the page: its title, which tells it from others."""
        return titles({result.label: result for _, result in self.models()})[label]

    def curve_name(self, experiment: str, label: str) -> RichText:
        """Return the title of a model, and its experiment if there are several."""
        swept = [self.experiment(experiment)] * self.has_sweep
        return joined([self.title(label), *swept])


def read_sources(paths: Sequence[Path]) -> list[ReportSource]:
    """Read results files, in the order given.

    Raises
    ------
    StoreError
        If a file is missing, damaged or none of roughbench, or is given twice.
    """
    names = names_of(paths)
    return [ReportSource(name, load(path)) for name, path in zip(names, paths, strict=True)]


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


class ModelPlace(NamedTuple):
    """What a verdict or a warning calls ``file: experiment/label``, as the page shows it.

    The details are experiment and file, each where there are several; in full, they are file,
    experiment and the title of the model.
    """

    model: str
    details: RichText
    full: RichText


def places(sources: Sequence[ReportSource]) -> Mapping[str, ModelPlace]:
    """Return the models of all files by what verdicts and warnings call them.

    Verdicts leave the file out where there is but one.
    """
    found = {}
    for source in sources:
        for experiment, result in source.models():
            swept = [source.experiment(experiment)] * source.has_sweep
            title = source.title(result.label)
            place = ModelPlace(
                title,
                joined([*swept, *([source.name] * (len(sources) > 1))]),
                joined([source.name, *swept, title]),
            )
            name = f"{experiment}/{result.label}"
            found[f"{source.name}: {name}"] = place
            if len(sources) == 1:
                found[name] = place
    return found
