"""The measured surface that was pressed: map, spectrum with its fit, heights."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.labels import experiment_labels
from roughbench.figures.style import COLUMN, footnote, letter, new_figure, set_width
from roughbench.notation import mathtext
from roughbench.results import Results
from roughbench.surface_record import SurfaceRecord, fitted_spectrum
from roughbench.units import in_words, prefix

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

_MEASURED, _LAW = "0.2", "#D55E00"


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    if any(name in results.surfaces for name in results):
        return None
    return "a measured surface: surface: {kind: scan, path: ...}"


def draw(results: Results) -> Figure:
    """Return the figure: a row of three panels for every measured surface."""
    labels = experiment_labels(results)
    records = {name: results.surfaces[name] for name in results if name in results.surfaces}
    figure, panels = new_figure(len(records), 2.3, 3, extra=0.2)
    set_width(figure, 2.2 * COLUMN)
    for row, (name, record) in enumerate(records.items()):
        heights, spectrum, density = panels[3 * row : 3 * row + 3]
        _draw_map(heights, record)
        _draw_spectrum(spectrum, record)
        _draw_density(density, record)
        words = [record.source, labels[name] if len(records) > 1 else ""]
        letter(heights, 3 * row, ", ".join(filter(None, words)))
        letter(spectrum, 3 * row + 1)
        letter(density, 3 * row + 2)
    footnote(figure, [_remark(record) for record in records.values()])
    return figure


def _remark(record: SurfaceRecord) -> str:
    found = {
        name: record.parameters[name] for name in ("Sq", "Sdq") if name in record.parameters
    }
    words = [f"$S_q$ = {in_words(found['Sq'], 'm')}"] if "Sq" in found else []
    words += [f"$S_{{dq}}$ = {found['Sdq']:.3g}"] if "Sdq" in found else []
    count = len(record.warnings)
    words += [f"{count} warning{'s' * (count > 1)} in the report"] if count else []
    return ", ".join(words)


def _draw_map(axes: Axes, record: SurfaceRecord) -> None:
    factor, unit = prefix(record.size, "m")
    of_height, height_unit = prefix([float(np.ptp(record.heights))], "m")
    image = axes.imshow(
        record.heights * of_height,
        origin="lower",
        cmap="cividis",
        extent=(0.0, record.size[1] * factor, 0.0, record.size[0] * factor),
        interpolation="nearest",
    )
    axes.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})")
    bar = axes.figure.colorbar(image, ax=axes, location="bottom", aspect=30)
    bar.set_label(f"height ({height_unit})")


def _draw_spectrum(axes: Axes, record: SurfaceRecord) -> None:
    q, power = (np.asarray(values, float) for values in record.spectrum)
    of_q, q_unit = prefix(q, "1/m")
    of_power, power_unit = prefix(power, "m^4")
    axes.set(xscale="log", yscale="log")
    drawn = (q > 0.0) & (power > 0.0)
    x, y = q[drawn] * of_q, power[drawn] * of_power
    axes.plot(x, y, color=_MEASURED, linewidth=1.1, label="measured", gid="measured")
    law = fitted_spectrum(record.fit)
    if law is not None and record.fit is not None:
        label = f"self-affine, $H = {record.fit['H']:.2f}$"
        axes.plot(
            law[0] * of_q,
            law[1] * of_power,
            "--",
            color=_LAW,
            linewidth=1.1,
            label=label,
            gid="law",
        )
    axes.set_xlabel(mathtext(f"wavevector $q$ ({_typeset(q_unit)})"))
    axes.set_ylabel(mathtext(f"spectrum $C_2D$ ({_typeset(power_unit)})"))
    axes.legend(loc="lower left")


def _draw_density(axes: Axes, record: SurfaceRecord) -> None:
    height, density = (np.asarray(values, float) for values in record.height_density)
    factor, unit = prefix(height, "m")
    axes.plot(
        height * factor, density / factor, color=_MEASURED, label="measured", gid="heights"
    )
    sq = float(record.parameters.get("Sq", math.nan))
    if sq > 0.0:
        normal = np.exp(-0.5 * (height / sq) ** 2) / (sq * math.sqrt(2.0 * math.pi))
        axes.plot(
            height * factor, normal / factor, "--", color=_LAW, label="normal, same $S_q$"
        )
    axes.set_ylim(0.0, 1.4 * float(np.max(density)) / factor)
    axes.set(xlabel=f"height above the mean ({unit})", ylabel=f"probability density (1/{unit})")
    axes.legend(loc="upper left")


def _typeset(unit: str) -> str:
    """Return a unit with its power as a figure shows it."""
    base, _, power = unit.partition("^")
    return f"{base}$^{power}$" if power else base
