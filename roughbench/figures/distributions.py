"""Pressures and gaps side by side: exact, of springs, and in theory.

A row is a pressure of the spec. Left the density of the contact pressure, right that of the
gap, both over all points. Models with fields are means with standard errors, and beside them
stand, thin, those of the spec that have a distribution without a field: Persson's theory, and
Winkler's springs in the limit of normally distributed heights.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.labels import (
    experiment_labels,
    height_remark,
    pressure_text,
    titles,
    unconverged_remarks,
)
from roughbench.figures.observed import ObservedLine, draw_panel, handles_of
from roughbench.figures.rebuild import self_affine_experiments, spec_fault
from roughbench.figures.style import footnote, legend_above, letter, new_figure
from roughbench.figures.styles import CurveStyle, curve_styles
from roughbench.models.distributions import shares_of
from roughbench.notation import mathtext
from roughbench.observables import OBSERVABLES
from roughbench.results import ModelResult, Results
from roughbench.spectrum import Spectrum

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

MOST_ROWS = 3
"""Pressures of a single experiment; of several, one each is drawn."""
BOTH = ("pressure_pdf", "gap_pdf")


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    if not any(_has_both(result) for _, result in results.models()):
        return (
            "the observables pressure_pdf and gap_pdf, which a spec asks for with observables"
        )
    return spec_fault(results)


def draw(results: Results) -> Figure:
    """Return the figure."""
    rows = [*_rows(results)]
    figure, axes = new_figure(len(rows), 2.1, 2, extra=0.4)
    handles: dict[str, dict[str, Any]] = {}
    for row, (words, lines) in enumerate(rows):
        for column, name in enumerate(BOTH):
            panel, number = axes[2 * row + column], 2 * row + column
            observable = OBSERVABLES[name]
            scale = "log" if observable.x_is_log else "linear"
            handles |= draw_panel(panel, lines[name], scale)
            letter(panel, number, words)
            panel.set_xlabel(mathtext(observable.x))
            panel.set_ylabel(mathtext(observable.y))
    legend_above(figure, handles_of(handles))
    footnote(figure, [height_remark(results.reduced()), *unconverged_remarks(results)])
    return figure


def _has_both(result: ModelResult) -> bool:
    return all(name in result for name in BOTH)


def _rows(results: Results) -> Iterator[tuple[str, Mapping[str, list[ObservedLine]]]]:
    """Yield what is written over a row, and the lines of both panels."""
    spectra = {
        name: surface.spectrum() for name, surface, _ in self_affine_experiments(results)
    }
    labels, styles = experiment_labels(results), curve_styles(results.models())
    reduced = results.reduced()
    held = {
        name: models
        for name, models in reduced.items()
        if any(_has_both(one) for one in models.values())
    }
    most = MOST_ROWS if len(held) == 1 else 1
    for experiment, models in held.items():
        pressures = next(one["pressure"] for one in models.values() if _has_both(one))
        shown = results[experiment]
        given = next(iter(shown.values()))["pressure"]
        places = np.linspace(0, len(pressures) - 1, min(most, len(pressures)))
        if most == 1:
            places = np.array([(len(pressures) - 1) // 2])
        for k in places.round().astype(int):
            words = [pressure_text(results, float(given[k])), labels[experiment]]
            spectrum = spectra.get(experiment)
            lines = {name: [*_lines(name, models, styles, spectrum, int(k))] for name in BOTH}
            yield ", ".join(filter(None, words)), lines


def _lines(
    name: str,
    models: Mapping[str, ModelResult],
    styles: Mapping[str, CurveStyle],
    spectrum: Spectrum | None,
    k: int,
) -> Iterator[ObservedLine]:
    """Yield the lines of one panel; the theory last."""
    names = titles(models)
    first = next(one for one in models.values() if _has_both(one))
    x, edges = first[f"{name}_bin"], first[f"{name}_edges"]
    nominal, none = float(first["pressure"][k]), np.full(x.shape, math.nan)
    for label, one in models.items():
        if _has_both(one):
            mean, sem = one[f"{name}_mean"][k], one[f"{name}_sem"][k]
            yield ObservedLine(names[label], one[f"{name}_bin"], mean, sem, styles[label])
    for label, one in models.items():
        if spectrum is None or _has_both(one):
            continue
        of_gaps = OBSERVABLES[name].is_in_heights
        unit = spectrum.rms_height if of_gaps else spectrum.rms_slope
        shares = shares_of(
            one.kind, one.attributes, spectrum, edges * unit, nominal, of_gaps=of_gaps
        )
        if shares is not None:
            y = shares / np.diff(edges)
            yield ObservedLine(names[label], x, y, none, styles[label], is_theory=True)
