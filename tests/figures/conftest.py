"""Results with known numbers, and figures drawn of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import NDArray

import roughbench as rb
from roughbench.ensemble import summarize
from roughbench.figures import FIGURES, available, render
from roughbench.figures.style import publication_style
from roughbench.observables import OBSERVABLES
from roughbench.quantities import QUANTITIES
from roughbench.results import ModelResult, Results

FloatArray = NDArray[np.float64]
Make = Callable[..., ModelResult]
Draw = Callable[[Results, str], Figure]
Drawn = dict[str, Figure]
TITLES = {
    "bem": "Exact (BEM)",
    "foundation": "Popov (1D foundation)",
    "persson": "Persson",
    "winkler": "Winkler",
    "line": "Line",
    "gw": "GW",
    "gw_elliptic": "Elliptic",
    "bgt": "BGT",
    "hertz_top": "Top",
}
PRESSURE = np.array([1e-4, 1e-3, 1e-2, 1e-1])
PRESSED = [1e-5, 9.82982e-05, 0.000210569, 0.000451068, 0.00206985, 0.2]
"""Pressures of ``computed`` whose fields are kept."""


@pytest.fixture
def make() -> Make:
    """Return a factory of a model's results, from arrays of realizations × pressures."""

    def build(
        kind: str = "foundation",
        *,
        stiffness: Any = None,
        n: int = 3,
        pressure: FloatArray = PRESSURE,
        label: str = "",
        status: Any = None,
        height: float = 0.5,
        **attributes: Any,
    ) -> ModelResult:
        scatter = 1.0 + 0.1 * np.arange(n)[:, None]
        shape = (n, pressure.size)
        if stiffness is None:
            stiffness = 2.0 * pressure * scatter
        values = {
            "area": np.minimum(2.0 * pressure * scatter, 1.0),
            "separation": 0.1 * scatter * -np.log(np.minimum(pressure, 0.5)),
            "stiffness": np.broadcast_to(np.asarray(stiffness, float), shape),
            "energy": pressure * scatter,
        }
        states = np.zeros(shape, np.int32) if status is None else np.asarray(status, np.int32)
        variables: dict[str, Any] = {"pressure": pressure, "status": states, **values}
        for name in QUANTITIES:
            if name in values:
                summary = summarize(values[name], states == 0)
                for statistic in ("mean", "sem", "median", "q16", "q84"):
                    variables[f"{name}_{statistic}"] = getattr(summary, statistic)
        known: dict[str, Any] = {
            "surface": "self-affine",
            "hurst": 0.7,
            "rms_height": height,
            "length": 6.28,
            "q_min": 1.0,
        }
        return ModelResult(label or kind, kind, TITLES[kind], known | attributes, variables)

    return build


@pytest.fixture
def collect() -> Callable[..., Results]:
    """Return a factory of results; models go to the experiment ``main``, or by name."""

    def build(*models: ModelResult, spec: str = "no spec", **experiments: Any) -> Results:
        groups = experiments.get("experiments") or {"main": models}
        return Results(
            {name: {m.label: m for m in group} for name, group in groups.items()}, spec, ""
        )

    return build


@pytest.fixture
def draw(shared: dict[int, Drawn]) -> Draw:
    """Return a callable that makes a figure by name: what stands in it, but not yet where.

    Those of ``computed`` are made once, and are to be looked at only.
    """

    def build(results: Results, name: str) -> Figure:
        drawn = shared.get(id(results), {})
        if name not in drawn:
            recipe = FIGURES[name]
            assert recipe.missing(results) is None
            with publication_style():
                drawn[name] = recipe.draw(results)
        return drawn[name]

    return build


@pytest.fixture
def lay_out(draw: Draw) -> Draw:
    """Return a callable that makes a figure by name and lays it out: all of it is drawn."""

    def build(results: Results, name: str) -> Figure:
        figure = draw(results, name)
        with publication_style():
            figure.draw_without_rendering()
        return figure

    return build


@pytest.fixture(scope="session")
def shared() -> dict[int, Drawn]:
    """Return the figures that were drawn of results which several tests share."""
    return {}


@pytest.fixture(scope="session")
def computed(shared: dict[int, Drawn]) -> Results:
    """Return the results of a run of two experiments, from light to full contact."""
    results = rb.run(
        {
            "name": "computed",
            "surface": {"H": 0.7, "q0": 1.0, "q1": 32.0, "slope": 0.1},
            "pressures": {"min": 1e-5, "max": 0.2, "points": 14},
            "realizations": 20,
            "seed": 7,
            "models": [{"kind": "foundation", "springs": 128}, {"kind": "persson"}],
            "save_fields": {"pressures": PRESSED, "realizations": [0]},
            "sweep": {"surface.qr": [1.0, 4.0]},
        }
    )
    shared[id(results)] = {}
    return results


@pytest.fixture(scope="session")
def observed() -> Results:
    """Return the results of a run that looks at fields."""
    return rb.run(
        {
            "name": "observed",
            "surface": {"H": 0.7, "q0": 1.0, "qr": 2.0, "q1": 32.0, "slope": 0.1},
            "pressures": [1e-4, 3e-4, 1e-3, 1e-2, 5e-2, 1e-1],
            "realizations": 2,
            "models": [{"kind": "foundation", "springs": 128}, {"kind": "winkler"}],
            "observables": list(OBSERVABLES),
            "save_fields": {"pressures": [1e-4, 1e-3, 1e-2, 1e-1], "realizations": [0, 1]},
        }
    )


@pytest.fixture(scope="session")
def rendered(computed: Results, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all figures of ``computed``, a folder below a new one."""
    folder = tmp_path_factory.mktemp("rendered") / "new" / "folder"
    for name in available(computed):
        pdf, png = render(computed, name, folder)
        assert (pdf, png) == (folder / f"{name}.pdf", folder / f"{name}.png")
    return folder
