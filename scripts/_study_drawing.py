"""The figures of docs/study.md, from the results of the study's runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from _study_curves import Number, at_separation, curve_of, ratio_of
from _study_numbers import Numbers, Runs, gap_density, rungs, slope_cases, spectrum_of
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

from roughbench.figures.labels import number_text
from roughbench.figures.style import COLOURS, GUIDE, SMALL, letter, new_figure
from roughbench.figures.styles import lighter, styles_of
from roughbench.models import MODELS
from roughbench.results import ModelResult

WORDS = {
    "foundation": ("foundation", "-"),
    "persson": ("Persson, γ = 0.45", "--"),
    "persson-fitted": ("Persson, fitted", "--"),
    "winkler": ("springs under the surface", "-."),
    "line": ("line with coupling", (0, (9, 2, 1.5, 2))),
    "gw": ("Greenwood-Williamson", ":"),
    "gw_elliptic": ("elliptic summits", ":"),
    "hertz_top": ("highest asperity", (0, (2.5, 1))),
}
KINDS = {key: key.partition("-")[0] for key in WORDS}
STYLES = styles_of({key: (kind, MODELS[kind].style) for key, kind in KINDS.items()})
MODEL_COLOURS = {key: style.colour for key, style in STYLES.items()}
QUANTITIES = {
    "area": (r"$A/A_\mathrm{exact}$", 0),
    "separation": (r"$\bar u/\bar u_\mathrm{exact}$", 1),
    "stiffness": (r"$K/K_\mathrm{exact}$", -1),
}
CASES = {
    "8-1024": ("8", COLOURS[0], "s"),
    "32-coarse": ("32", COLOURS[2], "o"),
    "128": ("128", COLOURS[1], "^"),
}
"""Of the figure of local slopes: case → q₁/q_r, colour, marker."""


def slopes(runs: Runs) -> Figure:
    """Draw the local slope, and pressures over the exact one at equal separation."""
    figure, (left, right) = new_figure(1, 3.0, columns=2, extra=0.7)
    shown = {name: models for name, models in slope_cases(runs) if name in CASES}
    for case, models in shown.items():
        ratio, colour, marker = CASES[case]
        exact = curve_of(models["bem"])
        bars = _errors(models["bem"])
        left.errorbar(
            exact.separation, exact.slope, bars[: exact.slope.size], color=colour,
            marker=marker, ms=4, lw=0, elinewidth=0.8, mfc="white",
            label=f"exact, $q_1/q_r$ = {ratio}",
        )  # fmt: skip
        for label, dashes in (("winkler", "-."), ("persson", "--")):
            curve = curve_of(models[label])
            at = np.arange(0.1, 4.01, 0.05)
            slope = [curve.at_separation("slope", u) for u in at]
            left.plot(at, slope, color=colour, ls=dashes, lw=1.0)
            at = np.arange(0.25, 3.6, 0.25)
            found = [_over(models[label], models["bem"], u) for u in at]
            right.errorbar(
                at, [one.value for one in found], [one.error for one in found],
                color=colour, ls=dashes, lw=1.0, elinewidth=0.8,
            )  # fmt: skip
    gaussian = curve_of(next(iter(shown.values()))["winkler-gaussian"])
    at = np.arange(0.1, 4.01, 0.05)
    slope = [gaussian.at_separation("slope", u) for u in at]
    left.plot(at, slope, color="0.3", ls=":", lw=1.0)
    at = np.linspace(1.6, 4.0, 50)
    left.plot(at, 1.0 / at, color=GUIDE, lw=0.6)
    left.text(1.68, 0.61, r"$h/\bar u$", fontsize=SMALL, color=GUIDE)
    left.set(
        xlabel=r"$\bar u/h_\mathrm{rms}$",
        ylabel=r"$p/(K h_\mathrm{rms})$",
        xlim=(0, 4),
        ylim=(0.1, 0.7),
    )
    right.axhline(1.0, color=GUIDE, lw=0.8)
    right.set(
        xlabel=r"$\bar u/h_\mathrm{rms}$", yscale="log", xlim=(0, 4),
        ylabel=r"$p/p_\mathrm{exact}$ at equal $\bar u$",
    )  # fmt: skip
    letter(left, 0)
    letter(right, 1)
    for label, dashes in (
        ("springs under the surface", "-."),
        ("Persson, γ = 0.45", "--"),
        ("Gaussian springs", ":"),
    ):
        left.plot([], [], color="0.3", ls=dashes, lw=1.0, label=label)
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def _errors(model: ModelResult) -> np.ndarray:
    """Return the standard error of p/(K h) at every pressure."""
    each = np.asarray(model["pressure"]) / (
        np.asarray(model["stiffness"]) * np.asarray(model["rms_height"])[:, None]
    )
    return np.asarray(each.std(axis=0, ddof=1) / math.sqrt(len(each)))


def _over(model: ModelResult, exact: ModelResult, separation: float) -> Number:
    return ratio_of(model, exact, at_separation("pressure", separation))


def ladder(runs: Runs, numbers: Numbers) -> Figure:
    """Draw what each rung of the coupling ladder has, over the half-space."""
    figure, (left, right) = new_figure(1, 2.8, columns=2, extra=0.3)
    screenings = [screening for screening, _, _ in rungs(runs["ladder"])]
    last = 2.0 * max(one for one in screenings if math.isfinite(one))
    places = [
        one if 0.0 < one < math.inf else (0.5 if one == 0.0 else last) for one in screenings
    ]
    for k, (what, words) in enumerate(
        (("area", r"$A$"), ("stiffness", r"$K$"), ("separation", r"$\bar u$"))
    ):
        for p, ls in ((1e-4, ":"), (1e-3, "-"), (1e-2, "--")):
            found = [numbers[f"ladder.{one:g}.{what}.{p:g}"] for one in screenings]
            left.errorbar(
                places, [one.value for one in found], [one.error for one in found],
                color=COLOURS[k], marker="os^"[k] if ls == "-" else "", ms=3.5, ls=ls, lw=0.9,
                elinewidth=0.8, label=words if ls == "-" else None,
            )  # fmt: skip
    for k, what in enumerate(("stress", "contact")):
        for p, ls in ((1e-3, "-"), (1e-2, "--")):
            found = [numbers[f"ladder.{one:g}.{what}.{p:g}"] for one in screenings]
            right.errorbar(
                places, [one.value for one in found], [one.error for one in found],
                color=COLOURS[k], marker="os"[k] if ls == "-" else "", ms=3.5, ls=ls, lw=0.9,
                elinewidth=0.8, label=what if ls == "-" else None,
            )  # fmt: skip
    for panel in (left, right):
        panel.set(xscale="log", xlabel="$q_c/q_0$")
        ticks = [places[0], 1, 8, 64, last]
        panel.xaxis.set_major_locator(FixedLocator(ticks))
        panel.xaxis.set_minor_locator(NullLocator())
        panel.set_xticklabels(["0", "1", "$q_r$", "64", "springs"])
    left.axhline(1.0, color=GUIDE, lw=0.8)
    left.set(yscale="log", ylabel="over the half-space, equal $p$")
    left.yaxis.set_major_locator(FixedLocator([0.7, 1, 1.5, 2, 3, 5, 7]))
    left.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    left.yaxis.set_minor_locator(NullLocator())
    right.set(ylabel="exponent of the spectrum")
    for level in (-1.7, -2.7, -3.4):
        right.axhline(level, color=GUIDE, lw=0.5, ls=":")
    left.legend(fontsize=SMALL)
    right.legend(fontsize=SMALL)
    letter(left, 0, r"$p/E^*$: $10^{-4}$ dotted, $10^{-3}$ solid, $10^{-2}$ dashed")
    letter(right, 1)
    return figure


def _height(model: ModelResult) -> float:
    return float(np.mean(model["rms_height"]))


def contenders(runs: Runs) -> Figure:
    """Draw every contender over the exact solution."""
    figure, axes = new_figure(3, 1.9, columns=2, share=True, extra=0.9)
    handles = {}
    for column, (experiment, models) in enumerate(runs["contenders-256"].items()):
        exact = models["bem"]
        p = exact["pressure"]
        for row, (name, (label, power)) in enumerate(QUANTITIES.items()):
            panel: Axes = axes[2 * row + column]
            reference = exact[f"{name}_mean"] / _height(exact) ** power
            with np.errstate(invalid="ignore"):
                part = exact[f"{name}_sem"] / exact[f"{name}_mean"]
            part = np.nan_to_num(part)
            panel.fill_between(p, 1 - part, 1 + part, color="0.8", lw=0)
            panel.axhline(1.0, color="black", lw=0.8)
            for key, (words, dashes) in WORDS.items():
                model = models[key]
                with np.errstate(invalid="ignore", divide="ignore"):
                    ratio = model[f"{name}_mean"] / _height(model) ** power / reference
                ratio = np.where((exact["area_mean"] < 0.999) & (ratio > 0), ratio, math.nan)
                (line,) = panel.plot(
                    p, ratio, color=MODEL_COLOURS[key], ls=dashes, lw=1.2, label=words
                )
                handles[words] = line
            panel.set(xscale="log", yscale="log", ylim=(0.09, 40) if row == 0 else (0.25, 8))
            if row:
                panel.yaxis.set_major_locator(FixedLocator([0.3, 0.5, 1.0, 2.0, 4.0, 8.0]))
                panel.yaxis.set_major_formatter(FormatStrFormatter("%g"))
                panel.yaxis.set_minor_locator(NullLocator())
            letter(panel, 2 * row + column, experiment.replace("surface.qr=", "$q_r/q_0$ = "))
            if column == 0:
                panel.set_ylabel(label)
            if row == 2:
                panel.set_xlabel("$p/E^*$")
    figure.legend(handles=list(handles.values()), loc="outside upper center", ncols=3)
    return figure


def sizes(runs: Runs) -> Figure:
    """Draw the same spectrum in larger and larger cells."""
    figure, (left, right) = new_figure(1, 2.7, columns=2)
    results = runs["cells"]
    shades = np.linspace(0.7, 0.0, len(results))
    for shade, models in zip(shades, results.values(), strict=True):
        exact, springs = models["bem"], models["foundation"]
        side = float(exact.attributes["length"])
        unit = float(exact.attributes["rms_height"])
        times = round(side / (2 * math.pi))
        left.errorbar(
            exact["pressure"], exact["separation_mean"] / unit, exact["separation_sem"] / unit,
            color=str(shade), marker="s", ms=3, lw=0, elinewidth=0.8,
            label=f"exact, $L = {times}\\cdot 2\\pi/q_0$",
        )  # fmt: skip
        colour = lighter(MODEL_COLOURS["foundation"], shade)
        u = springs["separation_mean"] / unit
        left.plot(springs["pressure"], u, color=colour, label=f"foundation, {times}")
        right.plot(springs["pressure"] * side / (2 * math.pi), u, color=colour)
    for panel in (left, right):
        panel.set(xscale="log", ylim=(0, 4.2), ylabel=r"$\bar u/h_\mathrm{rms}$")
    left.set_xlabel("$p/E^*$")
    right.set_xlim(None, 1e-2)
    right.set_xlabel("$p\\,L q_0/(2\\pi E^*)$")
    letter(left, 0, "against the pressure")
    letter(right, 1, "foundation, against $p L$")
    left.legend(fontsize=SMALL - 1, ncols=2)
    return figure


def distributions(runs: Runs) -> Figure:
    """Draw the distributions of gap and pressure of the contenders."""
    figure, axes = new_figure(2, 2.3, columns=2, extra=0.5)
    results = runs["contenders-256"]
    models = results["surface.qr=8.0"]
    handles = {}
    for column, wanted in enumerate((1e-4, 1e-2)):
        for row, name in enumerate(("pressure_pdf", "gap_pdf")):
            panel = axes[2 * row + column]
            exact_p = models["bem"]["pressure"]
            for key in ("bem", "winkler", "line", "foundation"):
                if key == "foundation" and row == 0:
                    continue  # its pressures are of springs of another stiffness
                model = models[key]
                k = int(np.argmin(np.abs(np.log(np.asarray(model["pressure"]) / wanted))))
                x, y = model[f"{name}_bin"], model[f"{name}_mean"][k]
                colour = "black" if key == "bem" else MODEL_COLOURS[key]
                words = "exact" if key == "bem" else WORDS[key][0]
                (line,) = panel.plot(
                    x, np.where(y > 0, y, math.nan), color=colour, lw=1.2, label=words,
                    ls="-" if key == "bem" else WORDS[key][1],
                )  # fmt: skip
                handles[words] = line
                if key == "bem" and row == 0:
                    theory = model["pressure_pdf_persson"][k]
                    words = WORDS["persson"][0].partition(",")[0]
                    (line,) = panel.plot(
                        x, theory, color=MODEL_COLOURS["persson"], lw=1.2, ls="--", label=words
                    )
                    handles[words] = line
            if row == 1:
                theory = gap_density(models["persson"], models["bem"], k)
                x = models["bem"]["gap_pdf_bin"]
                panel.plot(x, theory, color=MODEL_COLOURS["persson"], lw=1.2, ls="--")
            panel.set(yscale="log", xscale="linear" if row == 0 else "log")
            panel.set_xlabel(r"$\sigma/(E^*\xi)$" if row == 0 else r"gap$/h_\mathrm{rms}$")
            if column == 0:
                panel.set_ylabel("density")
            letter(panel, 2 * row + column, f"$p/E^*$ = {number_text(exact_p[k])}")
            top = panel.get_ylim()[1]
            panel.set_ylim(top * 1e-5, top)
            panel.set_xlim((0, 2) if row == 0 else (1e-3, 8))
    figure.legend(handles=list(handles.values()), loc="outside upper center", ncols=5)
    return figure


def kappas(runs: Runs, numbers: Numbers) -> Figure:
    """Draw κ at one pressure against the Hurst exponent and Nayak's parameter."""
    figure, (left, right) = new_figure(1, 2.7, columns=2)
    for k, (name, label) in enumerate(
        (("exponents-8", "64 bumps, 2 points"), ("exponents-64", "4096 bumps, 2 points"))
    ):
        for panel in (left, right):
            x, found = [], []
            for experiment, models in runs[name].items():
                model = models["bem"]
                x.append(
                    float(model.attributes["hurst"])
                    if panel is left
                    else spectrum_of(model).nayak
                )
                found.append(numbers[f"kappa.{name}.{experiment.rpartition('=')[2]}"])
            panel.errorbar(
                x, [one.value for one in found], [one.error for one in found],
                color=COLOURS[k], marker="so"[k], ms=4, lw=0, elinewidth=1, label=label,
            )  # fmt: skip
    x, found = [], []
    for case, models in slope_cases(runs):
        x.append(spectrum_of(models["bem"]).nayak)
        found.append(numbers[f"kappa.{case}.0.001"])
    right.errorbar(
        x, [one.value for one in found], [one.error for one in found], color=COLOURS[2],
        marker="^", ms=4, lw=0, elinewidth=1, label="$H$ = 0.7, local slopes",
    )  # fmt: skip
    for panel in (left, right):
        panel.axhline(math.sqrt(8 / math.pi), color=GUIDE, lw=0.8, ls="--")
        panel.axhline(math.sqrt(2 * math.pi), color=GUIDE, lw=0.8, ls=":")
        panel.set(ylim=(1.5, 2.6), ylabel=r"$(A/A_0)\,E^*\xi/p$ at $10^{-3}\,E^*$")
    left.text(0.3, 1.61, "Persson", fontsize=SMALL, color=GUIDE)
    left.text(0.55, 2.495, "Bush, Gibson and Thomas", fontsize=SMALL, color=GUIDE, va="top")
    left.set_xlabel("$H$")
    right.set(xscale="log", xlabel="Nayak's parameter")
    right.legend(fontsize=SMALL)
    letter(left, 0)
    letter(right, 1)
    return figure


Draw = Callable[[Runs, Numbers], Figure]
FIGURES: Mapping[str, tuple[tuple[str, ...], Draw]] = {
    "slope": (("cells", "slope-32-coarse", "slope-128"), lambda runs, _: slopes(runs)),
    "ladder": (("ladder",), ladder),
    "contenders": (("contenders-256",), lambda runs, _: contenders(runs)),
    "size": (("cells",), lambda runs, _: sizes(runs)),
    "distributions": (("contenders-256",), lambda runs, _: distributions(runs)),
    "kappa": (("exponents-8", "exponents-64", "cells"), kappas),
}
"""Name → the runs that it needs, and what draws it."""
