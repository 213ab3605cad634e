"""Where each contender can be trusted: in words, from ranges and deviations.

Of every quantity that a contender gives: between which pressures it is within 10 % of the
exact solution, by how much it is off at some pressures, about one a decade, and how many
surfaces on both sides that rests on.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.fits import Deviations, Estimate, is_exact
from roughbench.fits.comparisons import NEARLY_CLOSED, Comparison
from roughbench.models.registry import presses_lines
from roughbench.notation import typeset
from roughbench.numbers import with_error
from roughbench.quantities import Quantity, compared
from roughbench.results import ModelResult
from roughbench.units import prefix
from roughbench.verdict.experiments import FittedExperiment
from roughbench.verdict.judging import Range
from roughbench.verdict.measures import OTHER_PRESSURES

FloatArray = NDArray[np.float64]

PERCENT = 10
"""How near to the exact solution a contender has to be."""
TIMES = 3.0
"""From this ratio on a deviation is said as a factor: 14 times, not +1300 %."""
FEW_PRESSURES = 4
"""So many are all shown; of more, one a decade."""
MOST_PLACES = 4
LARGE_ERROR = 0.5
"""Errors above this part of a pressure are said as the interval."""
_NEARLY_CLOSED = f"the highest with A/A₀ ≤ {NEARLY_CLOSED:g}"


@dataclass(frozen=True, slots=True)
class Deviation:
    """How far a contender is from the exact solution at one pressure.

    Attributes
    ----------
    pressure : float
        p/E*.
    estimate : Estimate
        Model over exact, less 1: -0.32 is 32 % too little.
    modulus : float or None
        E*, Pa, of results with units.
    """

    pressure: float
    estimate: Estimate
    modulus: float | None = None

    @property
    def text(self) -> str:
        """The deviation in words, with its error.

        Examples
        --------
        >>> exact = Estimate(-0.32, math.nan, math.nan, math.nan, 1.0)
        >>> Deviation(1e-3, exact).text, Deviation(1e-3, Estimate(12.9, 0.6, 12, 14, 1.0)).text
        ('−32 %', '13.9 ± 0.6 times')
        >>> Deviation(1e-3, Estimate(-391.6, 12.3, -404, -379, 1.0)).text  # of a gap
        'below zero'
        """
        value, error = self.estimate.value, self.estimate.error
        if math.isnan(value):
            return "–"
        if math.isinf(value):
            return "infinite"
        if value < -1.0:
            return "below zero"
        if value + 1.0 >= TIMES:
            return f"{_rounded(value + 1.0, error)} times"
        text = _rounded(100.0 * abs(value), 100.0 * error)
        sign = "+" if value > 0.0 else "−"
        return f"{sign * (float(text.split()[0]) != 0.0)}{text} %"

    @property
    def place(self) -> str:
        """Where it is."""
        return _pressure_text(self.pressure, self.modulus)


@dataclass(frozen=True, slots=True)
class Trust:
    """Where a contender can be trusted in one quantity on one surface.

    Attributes
    ----------
    quantity : Quantity
    noun : str
        Whose value it is held against: ``exact``, or ``reference``.
    found : Range or None
        Where it agrees with the exact solution; None where it is not compared with it.
    deviations : tuple of Deviation
        At chosen pressures.
    highest : str
        What the last pressure is that is compared.
    missing : str
        Why there is no comparison: ``not given``, or in a sentence; empty where there is one.
    modulus : float or None
        E*, Pa, of results with units: sentences then have pressures in Pa.
    """

    quantity: Quantity
    noun: str
    found: Range | None
    deviations: tuple[Deviation, ...] = ()
    highest: str = "the highest"
    missing: str = ""
    modulus: float | None = None

    @property
    def name(self) -> str:
        """The quantity in words: contact area A/A₀."""
        return f"{self.quantity.words} {typeset(self.quantity.symbol)}"

    @property
    def range_text(self) -> str:
        """Where it agrees: ``within 10 % of the exact contact area from … to …``."""
        if self.found is None:
            return self.missing
        start, end = self.found.start, self.found.end
        within = f"within {self.found.percent} % of the {self.noun} {self.quantity.words}"
        if not math.isfinite(start.value):
            return f"nowhere {within}"
        low, high = (end_text(one, self.modulus) for one in (start, end))
        if start.is_bound and end.is_bound:
            return f"{within} from {low} to {high}, the lowest pressure to {self.highest}"
        low += ", the lowest pressure," * start.is_bound
        high += f", {self.highest}" * end.is_bound
        return f"{within} from {low} to {high}"

    @property
    def sentence(self) -> str:
        """All of it in one sentence, without the quantity: ``within …; at p = … −32 %``."""
        places = [f"at p = {one.place} {one.text}" for one in self.deviations]
        return "; ".join(filter(None, [self.range_text, ", ".join(places)]))


@dataclass(frozen=True, slots=True)
class ContenderTrust:
    """Where one contender can be trusted on one surface.

    Attributes
    ----------
    where : str
        Experiment and label, after the source where there are several.
    source, experiment, label, title : str
    basis : str
        How many surfaces the comparison rests on, and what its errors are.
    quantities : tuple of Trust
    """

    where: str
    source: str
    experiment: str
    label: str
    title: str
    basis: str
    quantities: tuple[Trust, ...]


def trust_of(experiments: Sequence[FittedExperiment]) -> list[ContenderTrust]:
    """Return where each contender can be trusted, experiment by experiment.

    Parameters
    ----------
    experiments : sequence of FittedExperiment
        Those without an exact solution tell nothing.
    """
    return [
        ContenderTrust(
            experiment.where(model),
            experiment.source,
            experiment.experiment,
            model.label,
            model.title,
            _basis(model, experiment.exact),
            tuple(_quantities(experiment, model, experiment.exact)),
        )
        for experiment in experiments
        if experiment.exact is not None
        for model in experiment.contenders
    ]


def _quantities(
    experiment: FittedExperiment, model: ModelResult, exact: ModelResult
) -> Iterator[Trust]:
    fits = experiment.fits[model.label]
    deviations = experiment.deviations.get(model.label, {})
    modulus = experiment.modulus
    noun = "exact" if is_exact(exact) else "reference’s"
    for name, quantity in compared().items():
        comparison = Comparison(name)
        if not quantity.is_expected and comparison.factor not in fits:
            continue
        if name not in model:
            yield Trust(quantity, noun, None, missing="not given")
        elif name not in exact:
            yield Trust(quantity, noun, None, missing=f"not given by {exact.title}")
        elif name not in deviations:
            yield Trust(quantity, noun, None, missing=f"not compared: {OTHER_PRESSURES}")
        else:
            start, end = (fits[key] for key in comparison.ends(PERCENT))
            found = deviations[name]
            is_open = not end.is_bound or end.value >= found.pressure[-1] * (1.0 - 1e-9)
            highest = "the highest" if is_open else _NEARLY_CLOSED
            chosen = tuple(_chosen(found, modulus))
            agrees = Range(PERCENT, start, end)
            yield Trust(quantity, noun, agrees, chosen, highest, modulus=modulus)


def _chosen(found: Deviations, modulus: float | None) -> Iterator[Deviation]:
    for k in choose_pressures(found.pressure * (modulus or 1.0)):
        yield Deviation(float(found.pressure[k]), found.estimates[k], modulus)


def choose_pressures(pressure: FloatArray) -> list[int]:
    """Return the places of the pressures that are nearest to a power of ten, one each.

    Examples
    --------
    >>> choose_pressures(np.array([1e-5, 3e-5, 8e-5, 2e-4, 1.1e-3, 2e-3]))
    [0, 2, 4]
    """
    if pressure.size <= FEW_PRESSURES:
        return list(range(pressure.size))
    x = np.log10(pressure)
    tens = np.arange(math.floor(x.min() + 0.5), math.floor(x.max() + 0.5) + 1)
    return sorted({int(np.argmin(np.abs(x - ten))) for ten in tens})


# -- words -------------------------------------------------------------------------------


def _basis(model: ModelResult, exact: ModelResult) -> str:
    """Say what surfaces were compared, and where the errors come from."""
    ours, theirs = _surfaces(model), _surfaces(exact)
    whom = "the exact solution" if is_exact(exact) else exact.title
    of_theirs = f" of {theirs}" if theirs else ""
    words = f"{ours or 'from the spectrum alone'}, against {whom}{of_theirs}"
    random = [one for one in (model, exact) if one.is_random]
    if not random:
        return f"{words}; nothing in it is random: no errors"
    if any(one.n_realizations == 1 for one in random):
        return f"{words}; a single surface has no scatter: no errors"
    if len(random) == 1 and ours and theirs:
        whose = "the model" if random[0] is model else whom
        return f"{words}; ± is the standard error of {whose} alone"
    return f"{words}; ± is one standard error"


def _surfaces(result: ModelResult) -> str:
    """Return how many surfaces or lines a model looked at; empty of a theory."""
    if "grid_points" not in result.attributes:
        return ""
    noun, many = sample_noun(result), result.n_realizations
    if not result.is_random:
        return f"one given {noun}"
    return f"{many} {noun}s" if many > 1 else f"a single {noun}"


def sample_noun(result: ModelResult) -> str:
    """Return what a model works on: ``line`` or ``surface``."""
    return "line" if presses_lines(result.kind, result.attributes) else "surface"


def _pressure_text(pressure: float, modulus: float | None, error: float = math.nan) -> str:
    """Return a pressure with its error, in E*; with a modulus in MPa and the like."""
    factor, unit, digits = 1.0, "E*", 2
    if modulus is not None:
        factor, unit = prefix([pressure * modulus], "Pa")
        factor, digits = factor * modulus, 3
    text = with_error(pressure * factor, error * factor, digits, of_error=1)
    needs_brackets = " ± " in text and not text.startswith("(")
    return f"({text}) {unit}" if needs_brackets else f"{text} {unit}"


def end_text(end: Estimate, modulus: float | None = None) -> str:
    """Return an end of a range with its error, or with its interval where that is wide."""
    text = _pressure_text(end.value, modulus)
    if not end.error > 0.0 or end.is_bound:
        return text
    if end.error > LARGE_ERROR * end.value:
        low, high = (_pressure_text(p, modulus) for p in (end.low, end.high))
        low, high = (low.removesuffix(" E*"), high.removesuffix(" E*"))
        return f"{text} (68 %: {f'{low} ' if end.low > 0.0 else 'up '}to {high})"
    return _pressure_text(end.value, modulus, end.error)


def _rounded(value: float, error: float) -> str:
    """Return a number that is not negative with its error, both to its first digit.

    Examples
    --------
    >>> _rounded(13.91, 0.62), _rounded(32.4, math.nan), _rounded(0.0, math.nan)
    ('13.9 ± 0.6', '32', '0')
    """
    places = max(0, -math.floor(math.log10(error))) if error > 0.0 else math.inf
    if places > MOST_PLACES or not math.isfinite(error):  # none, or one of rounding only
        return f"{value:.2g}" if 0.01 <= value < 99.5 else f"{value:.0f}"
    return f"{value:.{places}f} ± {error:.{places}f}"
