"""The surfaces of a file: a measured one with its picture, a synthetic one as a table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.numbers import number, with_error
from roughbench.report.charts import ChartSeries, Ranges, ReportChart
from roughbench.report.pictures import address, coarse, levels, picture
from roughbench.report.sources import ReportSource
from roughbench.report.tables import ReportTable, TableCell
from roughbench.report.text import RichText, Span, from_notation, joined
from roughbench.results import ModelResult
from roughbench.surface_record import SurfaceRecord, fitted_spectrum
from roughbench.units import in_words, prefix

FloatArray = NDArray[np.float64]

HEIGHT_COLOURS = (
    (0.0, "#00224e"),
    (0.25, "#3b496c"),
    (0.5, "#7b7b78"),
    (0.75, "#bcad6c"),
    (1.0, "#fee838"),
)
"""From the lowest to the highest point: told apart with any colour vision, and in grey."""
_INK, _FIT = "#1d2a5e", "#c0590a"
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


@dataclass(frozen=True, slots=True)
class SurfaceSection:
    """What the page shows of one measured surface.

    Attributes
    ----------
    key : str
        Of its elements.
    title : RichText
    image, label, shape : str
        The map as an address, what stands in its place, and its shape, width / height.
    scale : tuple of str
        Lowest height, the mean and the highest.
    caption : str
        How large it is.
    charts : list of ReportChart
        Spectrum and distribution of heights.
    fit : RichText
        The self-affine law in words.
    parameters, steps : ReportTable
        The surface in numbers, and how it was prepared.
    warnings : tuple of str
    """

    key: str
    title: RichText
    image: str
    label: str
    shape: str
    scale: tuple[str, ...]
    caption: str
    charts: list[ReportChart]
    fit: RichText
    parameters: ReportTable
    steps: ReportTable
    warnings: tuple[str, ...]


def surface_sections(source: ReportSource) -> list[SurfaceSection]:
    """Return the measured surfaces of a file, in the order of its experiments."""
    return [
        _section(source, name, source.results.surfaces[name], place)
        for place, name in enumerate(source.results)
        if name in source.results.surfaces
    ]


def _section(
    source: ReportSource, experiment: str, record: SurfaceRecord, place: int
) -> SurfaceSection:
    height, width = (in_words(length, "m") for length in record.size)
    named = record.source or source.name
    low, high = float(np.nanmin(record.heights)), float(np.nanmax(record.heights))
    factor, unit = prefix([low, high], "m")
    shown = (
        (record.heights - low) / (high - low) if high > low else np.zeros_like(record.heights)
    )
    pixels = levels(coarse(np.asarray(shown, float)))
    title = joined([named, *[source.experiment(experiment)] * source.has_sweep])
    return SurfaceSection(
        f"surface-{place}",
        title,
        address(picture(pixels, HEIGHT_COLOURS)),
        f"Map of the heights of {named}, {width} by {height}",
        f"{record.size[1] / record.size[0]:.6g}",
        tuple(f"{number(value * factor)} {unit}" for value in (low, high)),
        f"{width} × {height}",
        [_spectrum_chart(record), _height_chart(record)],
        fit_in_words(record.fit),
        _parameter_table(record),
        _step_table(record),
        tuple(record.warnings),
    )


# -- charts ------------------------------------------------------------------------------


def _spectrum_chart(record: SurfaceRecord) -> ReportChart:
    q, power = (np.asarray(values, float) for values in record.spectrum)
    shown = (q > 0.0) & (power > 0.0) & np.isfinite(power)
    q, power = q[shown], power[shown]
    q_factor, q_unit = prefix(q, "1/m")
    factor, unit = prefix(power, "m^4")
    curves = [_curve("measured", q * q_factor, power * factor, _INK)]
    law = fitted_spectrum(record.fit)
    if law is not None:
        x, y = law
        curves.append(_curve("self-affine fit", x * q_factor, y * factor, _FIT, "dash"))
    return ReportChart(
        "spectrum",
        "Spectrum: roughness by scale",
        f"Radially averaged spectrum of the heights against the wavevector, {_names(curves)}",
        f"wavevector q = 2π/wavelength ({q_unit})",
        f"spectrum C ({unit})",
        curves,
        _open(power * factor),
        legend="bottom",
    )


def _height_chart(record: SurfaceRecord) -> ReportChart:
    height, density = (np.asarray(values, float) for values in record.height_density)
    factor, unit = prefix(height, "m")
    curves = [_curve("measured", height * factor, density / factor, _INK)]
    sq = float(record.parameters.get("Sq", math.nan))
    if sq > 0.0:
        normal = np.exp(-0.5 * (height / sq) ** 2) / (sq * math.sqrt(2.0 * math.pi))
        curves.append(_curve("normal, same Sq", height * factor, normal / factor, _FIT, "dash"))
    return ReportChart(
        "heights",
        "Distribution of the heights",
        f"Probability density of the heights, {_names(curves)}",
        f"height above the mean ({unit})",
        f"probability density (1/{unit})",
        curves,
        {**_open(density / factor), "linear": [0.0, 1.4 * float(density.max()) / factor]},
        (False, False),
        legend="top",
    )


def _curve(
    name: str, x: FloatArray, y: FloatArray, colour: str, dash: str = "solid"
) -> ChartSeries:
    none = np.full_like(x, math.nan)
    return ChartSeries(name, {}, x, y, none, none, colour, dash)


def _names(curves: list[ChartSeries]) -> str:
    return " and ".join(curve.name for curve in curves)


def _open(values: FloatArray) -> Ranges:
    """Return a range that shows all that was measured, and no more decades."""
    known = values[np.isfinite(values) & (values > 0.0)]
    if known.size == 0:
        return {"log": None, "linear": None}
    low, high = float(known.min()), float(known.max())
    return {"log": [math.log10(low / 2.0), math.log10(high * 2.0)], "linear": None}


# -- words and tables --------------------------------------------------------------------


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


def _parameter_table(record: SurfaceRecord) -> ReportTable:
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


def _step_table(record: SurfaceRecord) -> ReportTable:
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
