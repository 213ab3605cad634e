"""Where the models touch: the fields that a run kept, side by side.

White out of contact, the darker the higher the pressure, up to E*ξ; lines appear as stripes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.labels import MODULUS, experiment_labels, pressure_text, titles
from roughbench.figures.style import footnote, new_figure
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_GROUPS = 6
"""States of more groups are in the results, but not in the figure."""
_SIDE = 1.7
"""Of a panel, inches: half a column."""


@dataclass(frozen=True, slots=True)
class ContactMap:
    """One state to be drawn.

    Attributes
    ----------
    title : str
        Of the model.
    pressure : ndarray of float64, shape (n, m) or (n,)
        Contact pressure / (E* ξ), zero out of contact.
    """

    title: str
    pressure: NDArray[np.float64]


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    if any("field_pressure" in result for _, result in results.models()):
        return None
    return "fields, which a spec asks for with save_fields"


def draw(results: Results) -> Figure:
    """Return the figure."""
    groups = dict(_groups(results))
    figure = contact_maps(dict(list(groups.items())[:MOST_GROUPS]))
    if len(groups) > MOST_GROUPS:
        footnote(figure, [f"{len(groups) - MOST_GROUPS} more are in the results."])
    return figure


def _groups(results: Results) -> Iterator[tuple[str, list[ContactMap]]]:
    """Yield the states of each experiment, realization and pressure, and what it is called."""
    labels = experiment_labels(results)
    for experiment, models in results.items():
        names = titles(models)
        found: dict[tuple[int, float], list[ContactMap]] = {}
        for label, result in models.items():
            if "field_pressure" not in result:
                continue
            slope = float(result.attributes["rms_slope"]) * (result.modulus or 1.0)
            for r, p, field in zip(
                result["field_realization"].tolist(),
                result["field_nominal_pressure"].tolist(),
                result["field_pressure"],
                strict=True,
            ):
                found.setdefault((r, p), []).append(ContactMap(names[label], field / slope))
        for (r, p), maps in sorted(found.items(), key=lambda group: group[0]):
            words = [labels[experiment], f"realization {r}" if r else ""]
            pressure = pressure_text(results, p)
            yield "\n".join(filter(None, [pressure, *words])), maps


def contact_maps(groups: Mapping[str, Sequence[ContactMap]]) -> Figure:
    """Return a figure of groups of states, one row each, or two columns for a single one.

    Parameters
    ----------
    groups : mapping of str to sequence of ContactMap
        By what is written beside them.
    """
    from matplotlib import colormaps

    most = max(len(maps) for maps in groups.values())
    columns = most if len(groups) > 1 else min(2, most)
    rows = {name: math.ceil(len(maps) / columns) for name, maps in groups.items()}
    width = max(2.2, _SIDE * columns)
    figure, panels = new_figure(sum(rows.values()), 1.9, columns, extra=0.3, width=width)
    colours = colormaps["viridis_r"].with_extremes(bad="white")
    image, start, used = None, 0, []
    for name, maps in groups.items():
        own = panels[start : start + columns * rows[name]]
        start += len(own)
        for axes in own[len(maps) :]:
            axes.remove()
        own[0].set_ylabel(name)
        for axes, drawn in zip(own, maps, strict=False):
            is_line = drawn.pressure.ndim == 1
            pressure = drawn.pressure[None, :] if is_line else drawn.pressure
            image = axes.imshow(
                np.where(pressure > 0.0, pressure, np.nan),
                cmap=colours,
                vmin=0.0,
                vmax=1.0,
                interpolation="nearest",
                aspect="auto" if is_line else "equal",
            )
            axes.set(xticks=[], yticks=[])
            share = np.count_nonzero(drawn.pressure) / drawn.pressure.size
            axes.set_title(f"{drawn.title}\n{100 * share:.3g} % of the points", fontsize=7.5)
            used.append(axes)
    if image is not None:
        bar = figure.colorbar(image, ax=used, location="bottom", extend="max", aspect=30)
        bar.set_label(rf"pressure $\sigma/({MODULUS}\xi)$")
    return figure
