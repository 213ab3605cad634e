"""What a reader should know before trusting a number of the report."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SpecError
from roughbench.models.base import Status
from roughbench.report.markup import number
from roughbench.report.sources import Source
from roughbench.results import ModelResult
from roughbench.spec import parse_spec

FEWEST_REALIZATIONS = 5
LARGE_ERROR = 0.1
FEWEST_CONTACT_POINTS = 100
LARGE_CORRECTION = 0.2
_POINTS_PER_WAVE = {"bem": 4.0, "line": 4.0}
_NYQUIST = 2.0
_QUANTITIES = {"area": "A/A₀", "separation": "ū", "stiffness": "K"}
_ENDS = {
    Status.STAGNATED: "stagnated",
    Status.MAX_ITERATIONS: "ran out of iterations",
    Status.NOT_FINITE: "not finite",
}

ABOUT = {
    "Missing parts": "The file does not hold all that its spec asks for.",
    "Missing pressures": "Fits and comparisons use the pressures that are there.",
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
    "Models without randomness": "They are computed from the spectrum, or from given heights: "
    "their curves have no standard error.",
}
"""Topic → what it means, in plain text."""


class Severity(StrEnum):
    """How much a remark matters."""

    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Remark:
    """One thing to know.

    Attributes
    ----------
    severity : Severity
    topic : str
        Remarks with equal topics stand together.
    where : str
        Plain text: file, experiment, model.
    text : str
        Plain text.
    """

    severity: Severity
    topic: str
    where: str
    text: str


def remarks(sources: Sequence[Source]) -> list[Remark]:
    """Return all warnings and notes about the results.

    The criteria are the constants of this module; the page on reports of the documentation
    names them.

    Parameters
    ----------
    sources : sequence of Source

    Returns
    -------
    list of Remark
        Warnings first, by topic, in the order of the files.
    """
    found = []
    for source in sources:
        found += [*_missing_parts(source), *_different_pressures(source)]
        for experiment, result in source.models():
            where = f"{source.name}: {experiment}/{result.label}"
            found += [
                remark
                for check in (_unconverged, _resolution, _few_points, _scatter, _medians)
                for remark in check(result, where)
            ]
        found += _without_randomness(source)
    order = list(Severity)
    topics = list(dict.fromkeys(remark.topic for remark in found))
    return sorted(found, key=lambda r: (order.index(r.severity), topics.index(r.topic)))


def _warning(topic: str, where: str, text: str) -> Remark:
    return Remark(Severity.WARNING, topic, where, text)


def at_pressures(pressure: NDArray[np.float64], chosen: NDArray[np.bool_]) -> str:
    """Return which pressures are meant, in words.

    Examples
    --------
    >>> at_pressures(np.array([1e-3, 1e-2, 0.1]), np.array([True, True, False]))
    'at p/E* = 0.001 and 0.01'
    """
    meant = [number(value) for value in pressure[chosen]]
    if chosen.all() and len(meant) > 2:
        return f"at all {len(meant)} pressures"
    if len(meant) <= 3:
        last = f" and {meant[-1]}" if len(meant) > 1 else meant[-1]
        return f"at p/E* = {', '.join(meant[:-1])}{last}"
    first, end = np.flatnonzero(chosen)[[0, -1]]
    lowest, highest = number(pressure[first]), number(pressure[end])
    if end - first + 1 == len(meant):
        return f"at the {len(meant)} pressures p/E* = {lowest} to {highest}"
    return f"at {len(meant)} pressures between p/E* = {lowest} and {highest}"


def _unconverged(result: ModelResult, where: str) -> Iterator[Remark]:
    if not result.n_unconverged:
        return
    status = np.asarray(result["status"])
    pressure = np.asarray(result["pressure"], float)
    ends = ", ".join(
        f"{count} {words}"
        for end, words in _ENDS.items()
        if (count := int(np.count_nonzero(status == end)))
    )
    lost = (status != 0).all(axis=0)
    text = (
        f"{result.n_unconverged} of {result.n_states} states did not converge ({ends}), "
        f"{at_pressures(pressure, (status != 0).any(axis=0))}"
    )
    if lost.any():
        text += f"; nothing is left {at_pressures(pressure, lost)}"
    yield _warning("States that did not converge", where, f"{text}.")


def _resolution(result: ModelResult, where: str) -> Iterator[Remark]:
    known = result.attributes
    if not {"grid_points", "q_max", "length"} <= set(known):
        return
    waves = float(known["q_max"]) * float(known["length"]) / (2.0 * math.pi)
    per_wave = float(known["grid_points"]) / waves
    wanted = _POINTS_PER_WAVE.get(result.kind, _NYQUIST)
    if per_wave < wanted * (1.0 - 1e-9):
        yield _warning(
            "Coarse grids",
            where,
            f"{number(per_wave)} points on the shortest wave 2π/q₁, fewer than "
            f"{number(wanted)}.",
        )


def _few_points(result: ModelResult, where: str) -> Iterator[Remark]:
    if "area_raw_mean" not in result or "grid_points" not in result.attributes:
        return
    pressure = np.asarray(result["pressure"], float)
    raw = np.asarray(result["area_raw_mean"], float)
    area = np.asarray(result["area_mean"], float)
    points = raw * float(result.attributes["grid_points"]) ** 2
    few = (points > 0.0) & (points < FEWEST_CONTACT_POINTS)
    if few.any():
        yield _warning(
            "Contacts of few points",
            where,
            f"fewer than {FEWEST_CONTACT_POINTS} points of the grid touch "
            f"{at_pressures(pressure, few)} (on average, down to "
            f"{number(points[few].min(), 2)}).",
        )
    known = np.isfinite(raw) & np.isfinite(area) & (area > 0.0)
    share = np.zeros(raw.shape)
    share[known] = np.abs(raw[known] - area[known]) / area[known]
    large = share > LARGE_CORRECTION
    if large.any():
        yield _warning(
            "Contacts of few points",
            where,
            "the area counted in points and the one corrected for the perimeter differ by "
            f"up to {100.0 * share.max():.0f} % {at_pressures(pressure, large)}.",
        )


def _scatter(result: ModelResult, where: str) -> Iterator[Remark]:
    if not is_random(result):
        return
    many = result.n_realizations
    if many < FEWEST_REALIZATIONS:
        plural = "realizations" if many > 1 else "realization"
        yield _warning(
            "Few realizations",
            where,
            f"{many} {plural}.",
        )
    pressure = np.asarray(result["pressure"], float)
    parts = []
    for quantity, words in _QUANTITIES.items():
        if quantity not in result:
            continue
        mean = np.asarray(result[f"{quantity}_mean"], float)
        error = np.asarray(result[f"{quantity}_sem"], float)
        known = np.isfinite(mean) & np.isfinite(error) & (mean > 0.0)
        share = np.zeros(mean.shape)
        share[known] = error[known] / mean[known]
        large = share > LARGE_ERROR
        if large.any():
            place = at_pressures(pressure, large)
            parts.append(f"{words} {place} (up to {100.0 * share.max():.0f} %)")
    if parts:
        yield _warning("Large standard errors", where, f"{'; '.join(parts)}.")


def _medians(result: ModelResult, where: str) -> Iterator[Remark]:
    if "stiffness" not in result:
        return
    infinite = np.isinf(np.asarray(result["stiffness_mean"], float))
    if result.n_realizations > 1 and infinite.any():
        yield Remark(
            Severity.NOTE,
            "Full contact",
            where,
            f"{at_pressures(np.asarray(result['pressure'], float), infinite)}.",
        )


def _missing_parts(source: Source) -> Iterator[Remark]:
    try:
        spec = parse_spec(source.results.spec_text)
        experiments = spec.experiments()
    except SpecError:
        yield _warning(
            "Missing parts",
            source.name,
            "the spec in the file cannot be read, so nothing tells what is missing.",
        )
        return
    for experiment, wanted in experiments:
        models = source.results.experiments.get(experiment, {})
        for model in wanted.models:
            where = f"{source.name}: {experiment}/{model.name}"
            if model.name not in models:
                yield _warning("Missing parts", where, "is in the spec, but not in the file.")
                continue
            there = np.asarray(models[model.name]["pressure"], float)
            asked = np.asarray(wanted.pressures)
            absent = ~np.isclose(asked[:, None], there[None, :], rtol=1e-9).any(axis=1)
            if absent.any():
                yield _warning(
                    "Missing pressures",
                    where,
                    f"the spec asks for states {at_pressures(asked, absent)} that are not "
                    "in the file.",
                )


def _different_pressures(source: Source) -> Iterator[Remark]:
    for experiment, models in source.results.items():
        lists = {label: result["pressure"].tobytes() for label, result in models.items()}
        if len(set(lists.values())) > 1:
            yield _warning(
                "Missing pressures",
                f"{source.name}: {experiment}",
                "the models have different pressures; those with others than the reference "
                "are not compared with it.",
            )


def is_random(result: ModelResult) -> bool:
    """Return whether a model looked at random heights, so that realizations differ."""
    return "grid_points" in result.attributes and result.attributes["surface"] != "file"


def _without_randomness(source: Source) -> Iterator[Remark]:
    labels = list(dict.fromkeys(r.label for _, r in source.models() if not is_random(r)))
    if labels:
        yield Remark(
            Severity.NOTE,
            "Models without randomness",
            source.name,
            f"{', '.join(labels)}.",
        )
