"""One picture of a characterized scan: map, spectrum with the law, heights' distribution."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from roughbench.errors import StoreError
from roughbench.figures.files import FIGURE, image
from roughbench.figures.style import COLOURS, GUIDE, letter, new_figure, publication_style
from roughbench.outputs import OutputPath, check_output, write_output
from roughbench.scans.characterization import Characterization
from roughbench.units import prefix

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LARGEST_MAP = 512
"""Points per side of the map; every so many are shown of a larger one."""


def check_picture(path: Path, inputs: Iterable[OutputPath] = ()) -> None:
    """Refuse a picture that could not be written.

    Raises
    ------
    StoreError
        If its name does not end as a picture's, or it must not be written over.
    """
    kind = FIGURE.get(path.suffix.lower().removeprefix("."))
    if kind is None:
        raise StoreError(f"cannot draw {path}: its name must end in .png, .pdf or .svg")
    check_output(path, kind, inputs)


def draw_picture(
    found: Characterization, path: Path, inputs: Iterable[OutputPath] = ()
) -> Path:
    """Draw a characterized scan into a file, as its name says a PNG, a PDF or an SVG."""
    suffix = path.suffix.lower().removeprefix(".")
    check_picture(path, inputs)
    with publication_style():
        return write_output(image(draw(found), suffix), path, FIGURE[suffix], inputs)


def draw(found: Characterization) -> Figure:
    """Return the figure."""
    figure, (chart, spectrum, heights) = new_figure(1, 3.0, 3)
    _draw_map(figure, chart, found)
    _draw_spectrum(spectrum, found)
    _draw_heights(heights, found)
    for number, (axes, text) in enumerate(
        ((chart, "heights without trend"), (spectrum, "spectrum"), (heights, "distribution"))
    ):
        letter(axes, number, text)
    return figure


def _draw_map(figure: Figure, axes: Axes, found: Characterization) -> None:
    heights, size = found.levelled, found.scan.size
    step = max(1, math.ceil(max(heights.shape) / LARGEST_MAP))
    shown = heights[::step, ::step]
    side, unit = prefix(list(size), "m")
    scale, height_unit = prefix([found.prepared.Sq], "m")
    low, high = np.nanquantile(shown, [0.002, 0.998]) * scale
    image = axes.imshow(
        np.ma.masked_invalid(shown * scale),
        cmap="viridis",
        vmin=low,
        vmax=high,
        extent=(0.0, size[1] * side, size[0] * side, 0.0),
        interpolation="nearest",
    )
    axes.set_facecolor("0.85")  # missing points
    axes.set_xlabel(f"$x$ ({unit})")
    axes.set_ylabel(f"$y$ ({unit})")
    figure.colorbar(image, ax=axes, extend="both", label=f"height ({height_unit})")


def _draw_spectrum(axes: Axes, found: Characterization) -> None:
    bins = found.surface.binned()
    q, unit = prefix(bins.q.tolist(), "1/m")
    scale, power_unit = 1e36, "nm$^4$"
    axes.set_xscale("log")
    axes.set_yscale("log")
    there = bins.power > 0.0
    relative = np.minimum(1.0 / np.sqrt(bins.independent[there]), 0.9)
    power = bins.power[there] * scale
    axes.errorbar(
        bins.q[there] * q,
        power,
        yerr=[power * relative, power * relative],
        linestyle="none",
        marker="o",
        markersize=3.0,
        color=COLOURS[0],
        label="measured",
    )
    fit = found.fit
    if fit is not None:
        line = np.geomspace(fit.q_min, fit.q_max * (1.0 - 1e-9), 200)
        law = fit.spectrum().psd_2d(line) * scale
        # At a given slope, an error of H turns the law about the waves that carry it.
        pivot = math.sqrt(fit.q_max * max(fit.q_rolloff, fit.q_max / 10.0))
        turned = 2.0 * fit.hurst_error * np.abs(np.log(np.maximum(line, fit.q_rolloff) / pivot))
        spread = np.exp(
            np.hypot(turned, np.hypot(2.0 * fit.rms_slope_error / fit.rms_slope, fit.scatter))
        )
        axes.fill_between(line * q, law / spread, law * spread, color=COLOURS[1], alpha=0.25)
        axes.plot(line * q, law, color=COLOURS[1], label=f"law, $H = {fit.hurst:.2f}$")
        for value, name in ((fit.q_rolloff, "$q_r$"), (fit.q_max, "$q_1$")):
            axes.axvline(value * q, color=GUIDE, linewidth=0.5, linestyle=(0, (1, 2)), zorder=1)
            axes.annotate(
                name,
                (value * q, 0.02),
                (-2, 0),
                xycoords=axes.get_xaxis_transform(),
                textcoords="offset points",
                ha="right",
            )
    else:
        axes.plot([], [], " ", label="no self-affine law fits")
    if there.any():
        axes.set_ylim(power.max() * 1e-14 if power.min() < power.max() * 1e-14 else None, None)
    axes.set_xlabel(f"wavevector $q$ ({unit})")
    axes.set_ylabel(rf"$C_\mathrm{{2D}}$ ({power_unit})")
    axes.legend()


def _draw_heights(axes: Axes, found: Characterization) -> None:
    heights = found.levelled[np.isfinite(found.levelled)]
    scale, unit = prefix([found.prepared.Sq], "m")
    mean, rms = float(heights.mean()), float(heights.std())
    reach = np.linspace(-6.0, 6.0, 97)
    counts, _ = np.histogram((heights - mean) / rms, reach)
    density = counts / counts.sum() / np.diff(reach) / (rms * scale)
    place = reach * rms * scale
    axes.stairs(
        np.where(density > 0.0, density, np.nan), place, color=COLOURS[0], label="measured"
    )
    smooth = np.linspace(-6.0, 6.0, 241)
    normal = np.exp(-(smooth**2) / 2.0) / math.sqrt(2.0 * math.pi) / (rms * scale)
    axes.plot(
        smooth * rms * scale, normal, color=COLOURS[1], label="Gaussian of the same $S_q$"
    )
    axes.set_yscale("log")
    lowest = density[density > 0.0].min()
    axes.set_ylim(lowest / 2.0, max(density.max(), normal.max()) * 3.0)
    axes.set_xlabel(f"height ({unit})")
    axes.set_ylabel(f"probability (1/{unit})")
    axes.legend()
