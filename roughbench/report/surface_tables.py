"""Surfaces in numbers: parameters and preparation of a measured one, spectra of others."""

from __future__ import annotations

import math
from collections.abc import Mapping

from roughbench.numbers import number, with_error
from roughbench.report.sources import ReportSource
from roughbench.report.tables import ReportTable, TableCell
from roughbench.report.text import RichText, Span, from_notation, joined
from roughbench.results import ModelResult
from roughbench.surface_record import SurfaceRecord
from roughbench.units import in_words, prefix

_PARAMETERS: Mapping[str, tuple[str, str]] = {
    "Sq": ("rms height", "m"),
    "Sa": ("mean distance from the mean height", "m"),
    "Sz": ("highest minus lowest point", "m"),
    "peak_to_valley": ("highest minus lowest point", "m"),
    "Ssk": ("skewness: negative where pits are deeper than peaks are high", "1"),
    "Sku": ("kurtosis: 3 for normally distributed heights", "1"),
    "Sdq": ("rms slope (gradient)", "1"),
    "Sdr": ("share of area that the slopes add", "%"),
    "m0": ("variance of the heights of a profile", "m^2"),
    "m2": ("variance of the slopes of a profile", "1"),
    "m4": ("variance of the curvatures of a profile", "1/m^2"),
    "nayak": ("Nayak’s parameter m_0 m_4/m_2^2, the width of the spectrum", "1"),
    "anisotropy": (
        "largest over smallest rms slope of all directions: 1 where all are alike",
        "1",
    ),
    "direction": ("direction of the largest slope, from the rows", "°"),
}
_SYMBOLS = {"m0": "m_0", "m2": "m_2", "m4": "m_4", "nayak": "α", "peak_to_valley": "Sz"}
_SYNTHETIC = {
    "hurst": "Hurst exponent H",
    "q_min": "longest wave 2π/q_0",
    "q_rolloff": "roll-off 2π/q_r",
    "q_max": "shortest wave 2π/q_1",
    "rms_slope": "rms slope ξ",
    "rms_height": "rms height h_rms",
    "length": "side of the cell L",
}


def fit_in_words(fit: Mapping[str, float] | None) -> RichText:
    """Return the self-affine law of a spectrum in words."""
    if fit is None:
        return [
            Span("No self-affine law fits this spectrum: the theories take it as measured.")
        ]

    def found(name: str) -> tuple[float, float]:
        return fit[name], float(fit.get(f"{name}_error", math.nan))

    def wave(name: str) -> str:
        q, error = found(name)
        length = 2.0 * math.pi / q
        factor, unit = prefix([length], "m")
        return f"{with_error(length * factor, length * error / q * factor)} {unit}"

    text = (
        f"A self-affine law fits the spectrum: Hurst exponent H = {with_error(*found('H'))}, "
        f"flat for waves longer than {wave('qr')}, down to waves of {wave('q1')}; "
        f"rms slope {with_error(*found('slope'))}."
    )
    return [Span(text)]


def parameter_table(record: SurfaceRecord) -> ReportTable:
    """Return the surface in numbers, a row a parameter."""
    rows: list[list[TableCell]] = []
    for name, value in record.parameters.items():
        words, unit = _PARAMETERS.get(name, (name, "1"))
        symbol = from_notation(_SYMBOLS.get(name, name))
        rows.append([symbol, from_notation(words), _value(float(value), unit)])
    headings = ("Symbol", "What it is", "Value")
    title = "The surface as it is pressed, in numbers"
    return ReportTable(headings, rows, title, is_numeric=False)


def _value(value: float, unit: str) -> RichText:
    if not math.isfinite(value):
        return [Span("–")]
    if unit in {"1", "%", "°"}:
        text = f"{number(100.0 * value)} %" if unit == "%" else number(value)
        return [Span(text + "°" * (unit == "°"))]
    factor, shown = prefix([value], unit)
    return from_notation(f"{number(value * factor)} {shown}")


def step_table(record: SurfaceRecord) -> ReportTable:
    """Return how the heights were prepared, a row a step."""
    rows: list[list[TableCell]] = [
        [
            step.name,
            step.text,
            " × ".join(f"{count}" for count in step.points),
            in_words(step.Sq, "m"),
            number(step.Sdq),
        ]
        for step in record.steps
    ]
    headings = ("Step", "What was done", "Points", "Sq after it", "Sdq after it")
    return ReportTable(headings, rows, "From the file to the pressed surface", is_numeric=False)


def synthetic_table(source: ReportSource) -> ReportTable | None:
    """Return the spectra of the experiments whose surfaces are made, a row each.

    Wavevectors stand as wavelengths. Experiments with equal spectra share a row; None where
    there is none.
    """
    rows: dict[tuple[str, ...], list[RichText]] = {}
    for experiment, models in source.results.items():
        if experiment in source.results.surfaces:
            continue
        first = next((one for one in models.values() if "hurst" in one.attributes), None)
        if first is not None:
            cells = tuple(_cell_of(first, name) for name in _SYNTHETIC)
            rows.setdefault(cells, []).append(source.experiment(experiment))
    if not rows:
        return None
    headings: list[TableCell] = ["Surfaces", *(from_notation(w) for w in _SYNTHETIC.values())]
    table: list[list[TableCell]] = [
        [joined(names, "; "), *cells] for cells, names in rows.items()
    ]
    notes = ["Drawn at random with this spectrum."]
    if not source.results.has_units:
        notes = ["Drawn at random with this spectrum; lengths in one unit, that of the spec."]
    return ReportTable(headings, table, notes=notes, is_numeric=False)


def _cell_of(result: ModelResult, name: str) -> str:
    if name not in result.attributes:
        return "–"
    value = float(result.attributes[name])
    if name.startswith("q_"):
        value = 2.0 * math.pi / value
    if result.has_units and name not in ("hurst", "rms_slope"):
        return in_words(value, "m", 4)
    return number(value, 4)
