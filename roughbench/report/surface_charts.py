"""Charts of a measured surface: its spectrum, and how its heights are distributed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughbench.report.charts import ChartSeries, Ranges, ReportChart
from roughbench.surface_record import SurfaceRecord, fitted_spectrum
from roughbench.units import prefix

FloatArray = NDArray[np.float64]
_INK, _FIT = "#1d2a5e", "#c0590a"


def spectrum_chart(record: SurfaceRecord) -> ReportChart:
    """Return the spectrum of the heights, with the law that fits it."""
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


def height_chart(record: SurfaceRecord) -> ReportChart:
    """Return the distribution of the heights, with a normal one as wide."""
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
