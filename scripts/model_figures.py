"""Draw the figures of docs/models: each model against the exact solution, from `make models`.

    python scripts/model_figures.py                    # from docs/figures/models.h5.xz
    python scripts/model_figures.py results/models.h5  # from a new run, which is kept there

The exact solver itself is drawn against Westergaard's wave, which is computed here.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import _kept
import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import roughbench as rb
from roughbench.figures.files import save
from roughbench.figures.style import GUIDE, letter, new_figure, publication_style
from roughbench.figures.styles import lighter, style_of

FOLDER = Path(__file__).parents[1] / "docs" / "figures"
KEPT = FOLDER / "models.h5.xz"
QUANTITIES = {  # name → symbol, that of the ratio, power of the length
    "area": (r"$A/A_0$", r"$A/A_\mathrm{exact}$", 0),
    "separation": (r"$\bar u/h_\mathrm{rms}$", r"$\bar u/\bar u_\mathrm{exact}$", 1),
    "stiffness": (r"$K h_\mathrm{rms}/E^*$", r"$K/K_\mathrm{exact}$", -1),
}
SIZE: dict[str, Any] = {"height": 2.0, "columns": 3, "width": 6.9, "extra": 0.4}
FULL = 0.999
"""From this area on there is no gap to speak of."""

FloatArray = NDArray[np.float64]


def reduced(model: rb.ModelResult, name: str, ending: str = "mean") -> FloatArray:
    """Return an average in units of the mean rms height of the realized surfaces."""
    power = QUANTITIES[name][2]
    values = np.asarray(model[f"{name}_{ending}"], float)
    values = values / float(np.mean(model["rms_height"])) ** power
    return np.where(np.isfinite(values) & (values > 0), values, math.nan)


def comparison(results: rb.Results, kind: str) -> Figure:
    """Draw a model and the exact solution, and below the ratio of the two."""
    figure, panels = new_figure(2, **SIZE)
    above, below = panels[:3], panels[3:]
    for (experiment, models), share in zip(results.items(), (0.0, 0.55), strict=True):
        exact, model = models["bem"], models[kind]
        pressure = exact["pressure"]
        partial = exact["area_mean"] < FULL
        all_converged = model["n_converged"] == model.n_realizations
        words = experiment.replace("surface.qr=", "$q_r/q_0 = $").removesuffix(".0")
        colour, grey = lighter(style_of(model).colour or "#0072B2", share), str(share)
        for name, upper, lower in zip(QUANTITIES, above, below, strict=True):
            if name not in model:
                continue
            reference = np.where(partial, reduced(exact, name), math.nan)
            error = np.where(partial, reduced(exact, name, "sem"), math.nan)
            values = np.where(partial & all_converged, reduced(model, name), math.nan)
            upper.errorbar(
                pressure, reference, error,
                color=grey, marker="s", ms=2.6, mfc="none", lw=0, elinewidth=0.7,
                label=f"exact, {words}",
            )  # fmt: skip
            upper.plot(pressure, values, color=colour, lw=1.3, label=f"{kind}, {words}")
            part = error / reference
            lower.fill_between(pressure, 1 - part, 1 + part, color=grey, alpha=0.25, lw=0)
            lower.plot(pressure, values / reference, color=colour, lw=1.3)
    for panel, (symbol, ratio, _) in zip(
        [*above, *below], [*QUANTITIES.values(), *QUANTITIES.values()], strict=True
    ):
        is_ratio = panel in below
        panel.set(xscale="log", yscale="log", xlim=(6e-7, 0.3))
        panel.set_ylabel(ratio if is_ratio else symbol)
        if is_ratio:
            panel.set_xlabel("$p/E^*$")
            limit_ratio(panel)
        else:
            panel.tick_params(labelbottom=False)
    return finished(figure, above)


def limit_ratio(panel: Axes) -> None:
    """Show the ratios at one scale up and down, from a factor of 2 to one of 20."""
    lines = [np.asarray(line.get_ydata(), float) for line in panel.get_lines()]
    values = np.concatenate([*lines, [1.0]])
    values = values[np.isfinite(values)]
    most = float(np.clip(np.max(np.abs(np.log(values))), math.log(2), math.log(20)))
    panel.axhline(1.0, color=GUIDE, lw=0.7, zorder=0)
    panel.set_ylim(math.exp(-1.05 * most), math.exp(1.05 * most))
    steps = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20]
    steps = [step for step in steps if abs(math.log(step)) <= 1.001 * most]
    panel.set_yticks(steps, [f"{step:g}" for step in steps], minor=False)
    panel.set_yticks([], minor=True)


def finished(figure: Figure, above: list[Axes]) -> Figure:
    """Put letters on the upper panels, and the legend over all of them."""
    for number, panel in enumerate(above):
        letter(panel, number)
    handles, labels = above[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4)
    return figure


def westergaard(load: FloatArray, height: float) -> dict[str, FloatArray]:
    """Return the closed forms of a wave at p/p_full, in units of its rms height."""
    rms = height / math.sqrt(2)
    return {
        "area": 2 / np.pi * np.arcsin(np.sqrt(load)),
        "separation": height / rms * (1 - load + load * np.log(load)),
        "stiffness": np.pi * rms / np.log(1 / load),
    }


def wave() -> Figure:
    """Draw the solver on one wave over Westergaard's closed forms (docs/models/line.md)."""
    points, rows, height = 512, 8, 0.01
    heights = height * np.cos(2 * np.pi * np.arange(points) / points) * np.ones((rows, 1))
    loads = np.geomspace(3e-3, 0.95, 13)
    pressures = np.pi * height * loads  # over E*; at π E* h₀/λ the last gap closes
    curve = rb.solve_curve(heights, pressures, length=(rows / points, 1.0))
    rms = height / math.sqrt(2)
    solved = {
        "area": np.asarray(curve.area),
        "separation": np.asarray(curve.separation) / rms,
        "stiffness": np.asarray(curve.stiffness) * rms,
    }
    figure, panels = new_figure(2, **SIZE)
    load = np.geomspace(2e-3, 0.97, 200)
    squares = {"color": "black", "marker": "s", "ms": 3, "mfc": "none"}
    for name, upper, lower in zip(QUANTITIES, panels[:3], panels[3:], strict=True):
        closed = westergaard(load, height)[name]
        upper.plot(load, closed, color=GUIDE, lw=1.0, label="Westergaard, closed form")
        words = f"bem, {points} points on the wave"
        upper.plot(loads, solved[name], **squares, lw=0, label=words)
        off = solved[name] / westergaard(loads, height)[name] - 1
        lower.plot(loads, off, **squares, lw=0.5)
        lower.axhline(0.0, color=GUIDE, lw=0.7, zorder=0)
        upper.set(xscale="log", yscale="log", ylabel=QUANTITIES[name][0])
        lower.set(xscale="log", xlabel=r"$p/p_\mathrm{full}$", ylabel="deviation")
        lower.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))
        upper.tick_params(labelbottom=False)
        print(name, "largest deviation", float(np.max(np.abs(off))))
    return finished(figure, panels[:3])


def main() -> None:
    """Draw them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, nargs="?", help="of a new run, to be kept")
    path = parser.parse_args().results
    if path:
        _kept.keep(path, KEPT)
    results = _kept.load(KEPT)
    with publication_style(), rc_context({"savefig.dpi": 160}):
        kinds = [kind for kind in next(iter(results.values())) if kind != "bem"]
        for kind in kinds:
            save_one(comparison(results, kind), kind)
        save_one(wave(), "bem")


def save_one(figure: Figure, kind: str) -> None:
    """Write one of them, and print its path."""
    print(*save(figure, f"model-{kind}", FOLDER, formats=["png"]))


if __name__ == "__main__":
    main()
