"""What a reader should know before trusting a number of the report."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SpecError
from roughbench.models.base import Status
from roughbench.models.registry import declared, presses_lines
from roughbench.notation import typeset
from roughbench.numbers import number
from roughbench.quantities import compared
from roughbench.report.curves import has_quantity
from roughbench.report.sources import ReportSource
from roughbench.results import ModelResult
from roughbench.spec import parse_spec
from roughbench.units import prefix

FEWEST_REALIZATIONS = 5
LARGE_ERROR = 0.1
FEWEST_CONTACT_POINTS = 100
LARGE_CORRECTION = 0.2
_NYQUIST = 2.0
_ENDS = {
    Status.STAGNATED: "stagnated",
    Status.MAX_ITERATIONS: "ran out of iterations",
    Status.NOT_FINITE: "not finite",
}

ABOUT = {
    "Missing parts": "The file does not hold all that its spec asks for.",
    "Missing pressures": "Fits and comparisons use the pressures that are there.",
    "Measured heights": "What the checks of given heights found; those of a scan stand with "
    "its picture.",
    "States that did not converge": "The averages leave them out.",
    "Coarse grids": "The smallest contacts are not resolved; areas and stiffnesses of few "
    "contacts are off.",
    "Contacts of few points": "Areas at these pressures depend on the grid.",
    "Few realizations": "Standard errors are themselves uncertain then, and of a single "
    "realization there is none.",
    "Large standard errors": f"Above {100.0 * LARGE_ERROR:.0f} % of the mean.",
    "Full contact": "A realization in full contact makes the mean of K infinite at these "
    "pressures. The figures show medians with 16 % and 84 % quantiles there; of models other "
    "than the exact one, throughout.",
    "Quantities not given": "Not every model says something about all of them.",
    "Models without randomness": "They are computed from the spectrum, or from given heights: "
    "their curves have no standard error.",
}
"""Topic → what it means, in plain text."""
_NOTES = {"Full contact", "Quantities not given", "Models without randomness"}
"""Topics that no one needs to worry about."""


@dataclass(frozen=True, slots=True)
class Remark:
    """One thing to know: on which topic, about which file, experiment and model, and what."""

    topic: str
    where: str
    text: str

    @property
    def severity(self) -> str:
        """``warning`` or ``note``."""
        return "note" if self.topic in _NOTES else "warning"


def remarks(sources: Sequence[ReportSource]) -> list[Remark]:
    """Return all warnings and notes about the results, warnings first, by topic.

    The criteria are the constants of this module; the page on reports of the documentation
    names them.
    """
    found = []
    for source in sources:
        found += [*_missing_parts(source), *_different_pressures(source)]
        found += _measured(source)
        for experiment, result in source.models():
            where = f"{source.name}: {experiment}/{result.label}"
            for check in (_unconverged, _resolution, _few_points, _scatter, _medians):
                found += [Remark(topic, where, text) for topic, text in check(result)]
        found += [*_not_given(source), *_without_randomness(source)]
    topics = list(dict.fromkeys(remark.topic for remark in found))
    return sorted(found, key=lambda r: (r.topic in _NOTES, topics.index(r.topic)))


def at_pressures(
    pressure: NDArray[np.float64], chosen: NDArray[np.bool_], modulus: float | None = None
) -> str:
    """Return which pressures p/E* are meant, in words; with a modulus (Pa), in its unit.

    Examples
    --------
    >>> at_pressures(np.array([1e-3, 1e-2, 0.1]), np.array([True, True, False]))
    'at p/E* = 0.001 and 0.01'
    >>> at_pressures(np.array([1e-3, 1e-2, 0.1]), np.array([True, True, False]), 2e9)
    'at p = 2 and 20 MPa'
    """
    symbol, end = "p/E*", ""
    if modulus is not None:
        factor, unit = prefix((pressure[chosen] * modulus).tolist(), "Pa")
        pressure = pressure * modulus * factor
        symbol, end = "p", f" {unit}"
    meant = [number(value) for value in pressure[chosen]]
    if chosen.all() and len(meant) > 2:
        return f"at all {len(meant)} pressures"
    if len(meant) <= 3:
        last = f" and {meant[-1]}" if len(meant) > 1 else meant[-1]
        return f"at {symbol} = {', '.join(meant[:-1])}{last}{end}"
    first, final = np.flatnonzero(chosen)[[0, -1]]
    lowest, highest = number(pressure[first]), number(pressure[final])
    if final - first + 1 == len(meant):
        return f"at the {len(meant)} pressures {symbol} = {lowest} to {highest}{end}"
    return f"at {len(meant)} pressures between {symbol} = {lowest} and {highest}{end}"


def _at(result: ModelResult, chosen: NDArray[np.bool_]) -> str:
    return at_pressures(result.reduced()["pressure"], chosen, result.modulus)


def _share(part: ArrayLike, whole: ArrayLike) -> NDArray[np.float64]:
    """Return part / whole, 0 where one of them is not there or the whole is 0."""
    part, whole = np.asarray(part, float), np.asarray(whole, float)
    known = np.isfinite(part) & np.isfinite(whole) & (whole > 0.0)
    return np.divide(part, whole, out=np.zeros(whole.shape), where=known)


def _measured(source: ReportSource) -> Iterator[Remark]:
    """Yield what the checks found of heights whose surface the page does not show."""
    said = set()
    for experiment, result in source.models():
        if experiment in source.results.surfaces:
            continue
        for text in result.warnings:
            if (experiment, text) not in said:
                said.add((experiment, text))
                yield Remark("Measured heights", f"{source.name}: {experiment}", text)


# -- one model: pairs of topic and text --------------------------------------------------


def _unconverged(result: ModelResult) -> Iterator[tuple[str, str]]:
    if not result.n_unconverged:
        return
    status = np.asarray(result["status"])
    counts = {name: np.count_nonzero(status == end) for end, name in _ENDS.items()}
    ends = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    text = (
        f"{result.n_unconverged} of {result.n_states} states did not converge ({ends}), "
        f"{_at(result, (status != 0).any(axis=0))}"
    )
    lost = (status != 0).all(axis=0)
    if lost.any():
        text += f"; nothing is left {_at(result, lost)}"
    yield "States that did not converge", f"{text}."


def _resolution(result: ModelResult) -> Iterator[tuple[str, str]]:
    known = result.attributes
    if not {"grid_points", "q_max", "length"} <= set(known):
        return
    waves = float(known["q_max"]) * float(known["length"]) / (2.0 * math.pi)
    per_wave = float(known["grid_points"]) / waves
    model = declared(result.kind)
    wanted = model.fewest_points_per_wave if model else _NYQUIST
    if per_wave < wanted * (1.0 - 1e-9):
        points = f"{number(per_wave)} points on the shortest wave 2π/q₁"
        yield "Coarse grids", f"{points}, fewer than {number(wanted)}."


def _few_points(result: ModelResult) -> Iterator[tuple[str, str]]:
    is_counted = {"area_raw_mean", "area_mean"} <= set(result)
    if not is_counted or "grid_points" not in result.attributes:
        return
    raw, area = (np.asarray(result[f"{name}_mean"], float) for name in ("area_raw", "area"))
    side = float(result.attributes["grid_points"])
    other = 1.0 if presses_lines(result.kind, result.attributes) else side
    points = raw * side * float(result.attributes.get("grid_columns", other))
    few = (points > 0.0) & (points < FEWEST_CONTACT_POINTS)
    if few.any():
        text = (
            f"fewer than {FEWEST_CONTACT_POINTS} points of the grid touch "
            f"{_at(result, few)} (on average, down to "
            f"{number(points[few].min(), 2)})."
        )
        yield "Contacts of few points", text
    share = _share(np.abs(raw - area), area)
    large = share > LARGE_CORRECTION
    if large.any():
        text = (
            "the area counted in points and the one corrected for the perimeter differ by "
            f"up to {100.0 * share.max():.0f} % {_at(result, large)}."
        )
        yield "Contacts of few points", text


def _scatter(result: ModelResult) -> Iterator[tuple[str, str]]:
    if not result.is_random:
        return
    many = result.n_realizations
    if many < FEWEST_REALIZATIONS:
        yield "Few realizations", f"{many} realization{'s' * (many > 1)}."
    parts = []
    for name, quantity in compared().items():
        if has_quantity(result, name):
            share = _share(result[f"{name}_sem"], result[f"{name}_mean"])
            if (large := share > LARGE_ERROR).any():
                place = _at(result, large)
                parts.append(
                    f"{typeset(quantity.symbol)} {place} (up to {100.0 * share.max():.0f} %)"
                )
    if parts:
        yield "Large standard errors", f"{'; '.join(parts)}."


def _medians(result: ModelResult) -> Iterator[tuple[str, str]]:
    if has_quantity(result, "stiffness") and result.n_realizations > 1:
        infinite = np.isinf(result["stiffness_mean"])
        if infinite.any():
            yield "Full contact", f"{_at(result, infinite)}."


# -- one file ----------------------------------------------------------------------------


def _missing_parts(source: ReportSource) -> Iterator[Remark]:
    try:
        spec = parse_spec(source.results.spec_text, outside=source.results.outside_kinds)
        experiments = spec.experiments()
    except SpecError:
        text = "the spec in the file cannot be read, so nothing tells what is missing."
        yield Remark("Missing parts", source.name, text)
        return
    for experiment, wanted in experiments:
        models = source.results.experiments.get(experiment, {})
        for model in wanted.models:
            where = f"{source.name}: {experiment}/{model.name}"
            if model.name not in models:
                yield Remark("Missing parts", where, "is in the spec, but not in the file.")
                continue
            kept = models[model.name]
            there, asked = kept.reduced()["pressure"], np.asarray(wanted.pressures)
            absent = ~np.isclose(asked[:, None], there[None, :], rtol=1e-9).any(axis=1)
            if absent.any():
                meant = at_pressures(asked, absent, kept.modulus)
                missing = f"states {meant} that are not in the file."
                yield Remark("Missing pressures", where, f"the spec asks for {missing}")


def _different_pressures(source: ReportSource) -> Iterator[Remark]:
    for experiment, models in source.results.items():
        if len({result["pressure"].tobytes() for result in models.values()}) > 1:
            yield Remark(
                "Missing pressures",
                f"{source.name}: {experiment}",
                "the models have different pressures; those with others than the reference "
                "are not compared with it.",
            )


def _not_given(source: ReportSource) -> Iterator[Remark]:
    absent: dict[str, list[str]] = {}
    for label, models in source.by_label().items():
        for name, quantity in compared().items():
            if quantity.is_expected and not any(has_quantity(model, name) for model in models):
                absent.setdefault(label, []).append(typeset(quantity.symbol))
    if absent:
        text = "; ".join(f"{', '.join(names)} by {label}" for label, names in absent.items())
        yield Remark("Quantities not given", source.name, f"{text}.")


def _without_randomness(source: ReportSource) -> Iterator[Remark]:
    labels = dict.fromkeys(r.label for _, r in source.models() if not r.is_random)
    if labels:
        yield Remark("Models without randomness", source.name, f"{', '.join(labels)}.")
