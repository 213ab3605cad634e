"""The figures of ``roughbench observe``, from its observations."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from roughbench.figures.observed import (
    ContactMap,
    Line,
    draw_contact_maps,
    draw_observable,
)
from roughbench.observe import GAMMA, Observations, Observed, Saved

_SPECTRA = ("stress_spectrum", "contact_spectrum")
_WORDS = {
    "pressure_pdf": (r"pressure $\sigma/E\!^*\xi$", "density"),
    "gap_pdf": (r"gap $g/h_\mathrm{rms}$", "density"),
    "stress_spectrum": (r"wavevector $q$", r"$C_\sigma(q)$, lines: $C_\sigma/\pi q$"),
    "contact_spectrum": (r"wavevector $q$", r"$C_c(q)$, lines: $C_c/\pi q$"),
    "energy": (r"wavevector $q$", r"energy per ring"),
    "clusters": ("points of a patch", "patches"),
}


def draw(found: Observations, folder: Path) -> list[Path]:
    """Draw every observable of every experiment, and the saved states side by side.

    Parameters
    ----------
    found : Observations
    folder : Path

    Returns
    -------
    list of Path
    """
    paths = []
    for experiment, models in found.experiments.items():
        names = next((list(model.averages) for model in models.values()), [])
        for name in names:
            lines = _lines(models, name)
            if lines:
                axis, value = _WORDS[name]
                scale = "linear" if name == "pressure_pdf" else "log"
                paths += draw_observable(
                    lines, axis, value, f"{experiment}-{name}", folder, scale
                )
    for (experiment, realization, pressure), group in itertools.groupby(
        sorted(found.saved, key=_place), _place
    ):
        states = list(group)
        paths += draw_contact_maps(
            [ContactMap(saved.title, saved.state.pressure) for saved in states],
            states[0].state.rms_slope,
            f"{experiment}-contact-realization{realization}-p{pressure:g}",
            folder,
        )
    return paths


def _place(saved: Saved) -> tuple[str, int, float]:
    return saved.experiment, saved.realization, saved.pressure


def _lines(models: Mapping[str, Observed], name: str) -> dict[float, list[Line]]:
    lines: dict[float, list[Line]] = {}
    for model in models.values():
        for k, pressure in enumerate(model.pressures):
            column = model.averages[name][k]
            if column is not None:
                # A line's spectrum stands for the surface's that is mapped to it.
                is_line = model.dimension == 1 and name in _SPECTRA
                unit = np.pi * column.places if is_line else np.ones(column.places.shape)
                lines.setdefault(pressure, []).append(
                    Line(model.title, column.places, column.mean / unit, column.sem / unit)
                )
    for model in models.values():
        if name not in model.persson:
            continue
        for k, pressure in enumerate(model.pressures):
            column = model.averages[name][k]
            if column is None or pressure not in lines:
                continue
            title = "Persson" if name == "pressure_pdf" else rf"Persson, $\gamma = {GAMMA:g}$"
            values = model.persson[name][k]
            if title not in {line.title for line in lines[pressure]}:
                none = np.full(values.shape, np.nan)
                lines[pressure].append(Line(title, column.places, values, none, is_theory=True))
    return lines
