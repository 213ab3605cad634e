r"""Fig. 2 of the paper: the spectrum C2D(q) with q0, qr and q1, and a realized one.

Lines are the spectra of the experiments, one shade each; if there is only one, and it has
a roll-off, the spectrum of the same rms slope without it (qr = q0) is added, thin and grey.
Circles are the periodogram of realization 0, averaged over all modes in a ring: of the
exact solver's surface, :math:`(L/2\pi)^2\langle|h_q|^2\rangle`, or else of the foundation's
line, :math:`L|h_q|^2/(2\pi\cdot\pi q)`, whose spectrum is :math:`\pi q C_{2D}`. With fixed
amplitudes each mode carries exactly its share, so that the circles lie on the line.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.labels import experiment_label
from roughbench.figures.rebuild import Experiment, self_affine_experiments, spec_fault
from roughbench.figures.style import GUIDE, legend_above, new_figure
from roughbench.figures.styles import experiment_shades, lighter
from roughbench.models.base import Sample
from roughbench.planning.samples import make_sample
from roughbench.results import Results
from roughbench.spec import SelfAffineSurface, Spec
from roughbench.spectrum import Spectrum, self_affine
from roughbench.surface import wavenumbers
from roughbench.units import prefix

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

LARGEST_GRID = 2048
"""Surfaces with more points per side are not made again for a picture."""
RINGS_PER_DECADE = 12
"""Rings of equal width in ln q: the mean over one is at most 5 % above q^-3.4 at its middle."""


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    if fault := spec_fault(results):
        return fault
    return None if self_affine_experiments(results) else "a surface given by its spectrum"


def draw(results: Results) -> Figure:
    """Return the figure."""
    figure, (axes,) = new_figure(1, 3.0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    experiments = _distinct(self_affine_experiments(results))
    surfaces = [surface for _, surface, _ in experiments]
    shown = _Scales.of(results, surfaces)
    axes.set_xlabel(rf"wavevector $q$ ({shown.q_unit})")
    axes.set_ylabel(rf"spectrum $C_\mathrm{{2D}}$ ({shown.unit})")
    if len(surfaces) == 1:
        _draw_without_rolloff(axes, surfaces[0], shown)
    shades = experiment_shades([name for name, _, _ in experiments])
    for number, (name, surface, spec) in enumerate(experiments):
        colour = lighter("#000000", shades[name])
        label = experiment_label(name, surface.q_min) or "theory"
        _draw_theory(axes, surface.spectrum(), shown, colour, label, f"{name}/theory")
        realized = realized_spectrum(spec, surface)
        if realized is not None:
            kind, q, power = realized
            axes.plot(
                q * shown.q,
                power * shown.power,
                linestyle="none",
                marker="o",
                markersize=4.0 - 1.6 * number / len(experiments),
                markerfacecolor="none" if number else "white",
                color=colour,
                zorder=4 + number,
                label=f"realization 0 ({kind})" if number == len(experiments) - 1 else None,
                gid=f"{name}/{kind}",
            )
    _mark_wavevectors(axes, surfaces, shown.q)
    legend_above(figure, [*axes.get_legend_handles_labels()[0], _law(surfaces)])
    return figure


def realized_spectrum(
    spec: Spec, surface: SelfAffineSurface
) -> tuple[str, FloatArray, FloatArray] | None:
    """Return the spectrum C2D of realization 0, averaged over rings of wavevectors.

    Parameters
    ----------
    spec : Spec
        Of one experiment.
    surface : SelfAffineSurface
        Its surface.

    Returns
    -------
    (str, ndarray of float64, ndarray of float64) or None
        "surface" or "line", q (1/length) and C2D (length⁴); None if no model of the spec
        works on heights, or on a surface too large.
    """
    by_dimension = {}
    for model in reversed(spec.models):
        by_dimension[model.dimension] = model
    plane, line = by_dimension.get(2), by_dimension.get(1)
    if plane and plane.grid_points(surface.spectrum(), surface.length) <= LARGEST_GRID:
        sample = make_sample(surface, plane, spec.seed, 0)
        return ("surface", *ring_average(sample))
    if line:
        return ("line", *ring_average(make_sample(surface, line, spec.seed, 0)))
    return None


def ring_average(sample: Sample) -> tuple[FloatArray, FloatArray]:
    """Return q and the periodogram of the heights as a C2D, averaged in rings of ln q.

    Parameters
    ----------
    sample : Sample
        With periodic heights, a line or a surface, and their spectrum.

    Returns
    -------
    (ndarray of float64, ndarray of float64)
        The geometric mean of q (1/length) and the mean of C2D (length⁴) in each ring.
    """
    heights, spectrum = sample.heights, sample.spectrum
    if heights is None or spectrum is None:
        raise ValueError("a periodogram needs heights and their spectrum")
    q = wavenumbers(heights.shape, sample.length)
    power = np.abs(np.fft.rfftn(heights, norm="forward")) ** 2
    power *= (sample.length / (2.0 * np.pi)) ** heights.ndim
    power *= heights.size / heights.shape[0] ** heights.ndim  # of a cell that is no square
    inside = (q >= spectrum.q_min * (1.0 - 1e-9)) & (q <= spectrum.q_max * (1.0 + 1e-9))
    q, power = q[inside], power[inside]
    if heights.ndim == 1:
        power /= np.pi * q
    ring = np.floor(np.log10(q / spectrum.q_min) * RINGS_PER_DECADE + 1e-6).astype(int)
    count = np.bincount(ring)
    filled = count > 0
    mean_log = np.bincount(ring, np.log(q))[filled] / count[filled]
    return np.exp(mean_log), np.bincount(ring, power)[filled] / count[filled]


def _distinct(experiments: list[Experiment]) -> list[Experiment]:
    """Keep the first experiment with each spectrum."""
    first: dict[Spectrum, Experiment] = {}
    for experiment in experiments:
        first.setdefault(experiment[1].spectrum(), experiment)
    return list(first.values())


@dataclass(frozen=True, slots=True)
class _Scales:
    """What wavevectors and spectra are multiplied with, and the units that the axes name."""

    q: float = 1.0
    power: float = 1.0
    q_unit: str = "1/length"
    unit: str = "length$^4$"

    @classmethod
    def of(cls, results: Results, surfaces: list[SelfAffineSurface]) -> _Scales:
        if not results.has_units:
            return cls()
        spectra = [surface.spectrum() for surface in surfaces]
        q, q_unit = prefix([x for one in spectra for x in (one.q_min, one.q_max)], "1/m")
        ends = [float(one.psd_2d(np.array([one.q_max]))[0]) for one in spectra]
        tops = [float(one.psd_2d(np.array([one.q_min]))[0]) for one in spectra]
        power, unit = prefix(ends + tops, "m^4")
        return cls(q, power, q_unit, f"{unit.removesuffix('^4')}$^4$")


def _draw_theory(
    axes: Axes,
    spectrum: Spectrum,
    shown: _Scales,
    colour: str,
    label: str,
    name: str,
    width: float = 1.1,
) -> None:
    """Draw the power laws from edge to edge; a step at an edge comes out vertical."""
    q = np.repeat(spectrum.edges, 2)[1:-1]
    prefactors = np.repeat(spectrum.prefactors, 2)
    power = prefactors * q ** -np.repeat(spectrum.exponents, 2)
    x, y = q * shown.q, power * shown.power
    axes.plot(x, y, color=colour, linewidth=width, label=label, gid=name)


def _draw_without_rolloff(axes: Axes, surface: SelfAffineSurface, shown: _Scales) -> None:
    spectrum = surface.spectrum()
    if surface.q_rolloff == surface.q_min:
        return
    other = self_affine(
        hurst=surface.hurst,
        q_min=surface.q_min,
        q_rolloff=surface.q_min,
        q_max=surface.q_max,
        rms_slope=spectrum.rms_slope,
    )
    words = "theory for $q_r = q_0$"
    _draw_theory(axes, other, shown, GUIDE, words, "without roll-off", 0.7)


def _mark_wavevectors(axes: Axes, surfaces: list[SelfAffineSurface], scale: float) -> None:
    """Name q0, qr and q1 above the panel, each value once."""
    names: dict[float, list[str]] = {}
    for symbol, attribute in (("q_0", "q_min"), ("q_r", "q_rolloff"), ("q_1", "q_max")):
        for value in {scale * float(getattr(surface, attribute)) for surface in surfaces}:
            names.setdefault(value, []).append(symbol)
    for value, symbols in names.items():
        axes.axvline(value, color=GUIDE, linewidth=0.5, linestyle=(0, (1, 2)), zorder=1)
        axes.annotate(
            f"${' = '.join(symbols)}$",
            (value, 1.0),
            (0, 3),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            ha="center",
            va="bottom",
        )


def _law(surfaces: list[SelfAffineSurface]) -> Artist:
    """Return an entry of the legend that says the power law above the roll-off."""
    from matplotlib.lines import Line2D

    hurst = {surface.hurst for surface in surfaces}
    value = f", $H = {hurst.pop():g}$" if len(hurst) == 1 else ""
    words = rf"$\propto q^{{-2(1+H)}}${value} above $q_r$"
    return Line2D([], [], linestyle="none", label=words)
