"""Draw the figures of docs/study.md, and print its tables, from the runs of `make study`.

python scripts/study_figures.py results -o docs/figures
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

import roughbench as rb
from roughbench.figures.style import (
    COLOURS,
    GUIDE,
    SMALL,
    letter,
    new_figure,
    publication_style,
    save,
)
from roughbench.figures.styles import lighter, styles_of
from roughbench.fits import Estimate, factors, fit
from roughbench.models import MODELS
from roughbench.results import ModelResult, Results
from roughbench.spectrum import self_affine

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


def height(model: ModelResult) -> float:
    """Mean rms height of the realized surfaces."""
    return float(np.mean(model["rms_height"]))


def contenders(results: Results) -> Figure:
    """Draw every contender over the exact solution."""
    figure, axes = new_figure(3, 1.9, columns=2, share=True, extra=0.9)
    handles = {}
    for column, (experiment, models) in enumerate(results.items()):
        exact = models["bem"]
        p = exact["pressure"]
        for row, (name, (label, power)) in enumerate(QUANTITIES.items()):
            panel: Axes = axes[2 * row + column]
            reference = exact[f"{name}_mean"] / height(exact) ** power
            with np.errstate(invalid="ignore"):
                part = exact[f"{name}_sem"] / exact[f"{name}_mean"]
            part = np.nan_to_num(part)
            panel.fill_between(p, 1 - part, 1 + part, color="0.8", lw=0)
            panel.axhline(1.0, color="black", lw=0.8)
            for key, (words, dashes) in WORDS.items():
                colour = MODEL_COLOURS[key]
                model = models[key]
                with np.errstate(invalid="ignore", divide="ignore"):
                    ratio = model[f"{name}_mean"] / height(model) ** power / reference
                ratio = np.where((exact["area_mean"] < 0.999) & (ratio > 0), ratio, math.nan)
                (line,) = panel.plot(p, ratio, color=colour, ls=dashes, lw=1.2, label=words)
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


def sizes(results: Results) -> Figure:
    """Draw the same spectrum in larger and larger cells."""
    figure, (left, right) = new_figure(1, 2.7, columns=2)
    shades = np.linspace(0.75, 0.0, len(results))
    for shade, models in zip(shades, results.values(), strict=True):
        exact, springs = models["bem"], models["foundation"]
        side = float(exact.attributes["length"])
        unit = float(exact.attributes["rms_height"])
        p = exact["pressure"]
        times = round(side / (2 * math.pi))
        left.errorbar(
            p, exact["separation_mean"] / unit, exact["separation_sem"] / unit,
            color=str(shade), marker="s", ms=3, lw=0, elinewidth=0.8,
            label=f"exact, $L = {times}\\cdot 2\\pi/q_0$",
        )  # fmt: skip
        colour = lighter(MODEL_COLOURS["foundation"], shade)
        left.plot(
            p, springs["separation_mean"] / unit, color=colour, label=f"foundation, {times}"
        )
        right.plot(p * side / (2 * math.pi), springs["separation_mean"] / unit, color=colour)
    for panel in (left, right):
        panel.set(xscale="log", ylim=(0, 4.2), ylabel=r"$\bar u/h_\mathrm{rms}$")
    left.set_xlabel("$p/E^*$")
    right.set_xlim(None, 1e-2)
    right.set_xlabel("$p\\,L q_0/(2\\pi E^*)$")
    letter(left, 0, "against the pressure")
    letter(right, 1, "foundation, against $p L$")
    left.legend(fontsize=SMALL - 1, ncols=2)
    return figure


def nayak(model: ModelResult) -> float:
    """Nayak's parameter of the spectrum."""
    a = model.attributes
    spectrum = self_affine(
        hurst=float(a["hurst"]),
        q_min=float(a["q_min"]),
        q_rolloff=float(a["q_rolloff"]),
        q_max=float(a["q_max"]),
        rms_slope=float(a["rms_slope"]),
        below_rolloff=str(a["below_rolloff"]),
    )
    m0, m2, m4 = spectrum.moment(0), spectrum.moment(2) / 2, 3 * spectrum.moment(4) / 8
    return m0 * m4 / m2**2


def kappas(runs: Mapping[str, Results]) -> Figure:
    """Draw κ against the Hurst exponent and Nayak's parameter."""
    figure, (left, right) = new_figure(1, 2.7, columns=2)
    words = {
        "hurst": "$H$ from 0.3 to 0.9",
        "cutoff": "$q_1/q_0$ from 32 to 1024",
        "rolloff": "$q_r/q_0$ from 1 to 128",
    }
    for k, (name, label) in enumerate(words.items()):
        rows = list(kappa_rows(runs[name]))
        x = [float(model.attributes["hurst"]) for model, _ in rows]
        value = [estimate.value for _, estimate in rows]
        error = [estimate.error for _, estimate in rows]
        style = {"color": COLOURS[k], "marker": "so^"[k], "ms": 4, "lw": 0, "elinewidth": 1}
        if name == "hurst":
            left.errorbar(x, value, error, **style)
        right.errorbar([nayak(model) for model, _ in rows], value, error, label=label, **style)
    for panel in (left, right):
        panel.axhline(math.sqrt(8 / math.pi), color=GUIDE, lw=0.8, ls="--")
        panel.axhline(math.sqrt(2 * math.pi), color=GUIDE, lw=0.8, ls=":")
        panel.set(ylim=(1.5, 2.6), ylabel="κ")
    left.text(0.3, 1.61, "Persson", fontsize=SMALL, color=GUIDE)
    left.text(0.3, 2.45, "Bush, Gibson and Thomas", fontsize=SMALL, color=GUIDE, va="top")
    left.set_xlabel("$H$")
    right.set(xscale="log", xlabel="Nayak's parameter")
    right.legend(fontsize=SMALL)
    letter(left, 0)
    letter(right, 1)
    return figure


def kappa_rows(results: Results) -> Iterator[tuple[ModelResult, Estimate]]:
    """Yield the exact solution of every experiment with its κ."""
    for experiment, models in fit(results, resamples=300).items():
        yield results[experiment]["bem"], models["bem"]["kappa"]


def rolloffs(results: Results, below: Results) -> Figure:
    """Draw the width of the region in which K ~ p, and what the spectrum below q_r changes."""
    figure, (left, right) = new_figure(1, 2.7, columns=2)
    fits = fit(results, resamples=300)
    for label, colour, marker in (
        ("bem", "black", "s"), ("winkler", COLOURS[3], "^"), ("foundation", COLOURS[1], "o"),
    ):  # fmt: skip
        x, value, error, bound = [], [], [], []
        for experiment, models in fits.items():
            x.append(float(results[experiment][label].attributes["q_rolloff"]))
            found = models[label]["plateau_decades"]
            value.append(found.value)
            error.append(found.error)
            bound.append(found.is_bound)
        words = {"bem": "exact"}.get(label, WORDS.get(label, ("",))[0])
        left.errorbar(
            x, value, error, color=colour, marker=marker, ms=4, lw=0.8, elinewidth=1,
            lolims=bound, label=words,
        )  # fmt: skip
    left.set(
        xscale="log",
        xlabel="$q_r/q_0$",
        ylabel=r"decades of slope $1 \pm 0.15$",
        ylim=(0, None),
    )
    left.legend(fontsize=SMALL)
    letter(left, 0)
    a, b = ends_of(below)
    for k, (name, (_, power)) in enumerate(QUANTITIES.items()):
        ratio = b[f"{name}_mean"] / a[f"{name}_mean"] * (height(a) / height(b)) ** power
        spread = np.hypot(
            a[f"{name}_sem"] / a[f"{name}_mean"], b[f"{name}_sem"] / b[f"{name}_mean"]
        )
        words = ("$A/A_0$", r"$\bar u/h_\mathrm{rms}$", r"$K h_\mathrm{rms}$")[k]
        right.errorbar(
            a["pressure"], ratio, ratio * spread, color=COLOURS[k], marker="so^"[k], ms=3,
            lw=0.8, elinewidth=0.8, label=words,
        )  # fmt: skip
    right.axhline(1.0, color=GUIDE, lw=0.8)
    right.set(xscale="log", xlabel="$p/E^*$", ylabel="cut-off over roll-off", ylim=(0.7, 1.4))
    right.legend(fontsize=SMALL)
    letter(right, 1)
    return figure


def resolution(results: Results) -> Figure:
    """Draw what depends on the points on the shortest wave."""
    figure, (left, right) = new_figure(1, 2.7, columns=2)
    models = sorted((m["bem"] for m in results.values()), key=lambda m: m.attributes["grid"])
    finest = models[-1]
    points = [float(m.attributes["grid"]) / float(m.attributes["q_max"]) for m in models]
    for k, place in enumerate((0, 2, 4, 6)):
        p = finest["pressure"][place]
        for name, marker, ls in (("area_raw", "o", ":"), ("area", "s", "-")):
            ratio = [m[f"{name}_mean"][place] / finest["area_mean"][place] for m in models]
            word = f"$p/E^*$ = {p:.1g}" if name == "area" else None
            left.plot(
                points,
                ratio,
                color=COLOURS[k],
                marker=marker,
                ms=3.5,
                lw=0.8,
                ls=ls,
                label=word,
            )
        for name, marker, ls in (("separation", "s", "-"), ("stiffness", "^", "--")):
            ratio = [m[f"{name}_mean"][place] / finest[f"{name}_mean"][place] for m in models]
            right.plot(points, ratio, color=COLOURS[k], marker=marker, ms=3.5, lw=0.8, ls=ls)
    for panel in (left, right):
        panel.axhline(1.0, color=GUIDE, lw=0.8)
        panel.set_xscale("log", base=2)
        panel.xaxis.set_major_formatter(FormatStrFormatter("%g"))
        panel.set_xlabel("points on the shortest wave")
    left.set_ylabel("$A$, over the finest corrected")
    right.set_ylabel(r"$\bar u$ (squares), $K$ (triangles), over the finest")
    left.text(0.97, 0.93, "dotted: as counted\nsolid: corrected", transform=left.transAxes,
              fontsize=SMALL, ha="right", va="top")  # fmt: skip
    left.legend(fontsize=SMALL, loc="center right")
    letter(left, 0)
    letter(right, 1)
    return figure


LAWS = (
    "kappa",
    "kappa_decades",
    "log_decades",
    "plateau_decades",
    "alpha_realized",
    "exponent",
    "theta_realized",
)


def tables(runs: Mapping[str, Results]) -> None:
    """Print what the page quotes."""
    for name, results in runs.items():
        print(f"\n== {name}: laws of the exact solution; by which factor others depart from it")
        for experiment, models in fit(results, resamples=300).items():
            for label, found in models.items():
                model = results[experiment][label]
                if model.kind == "bem":
                    print(f"{experiment}: Nayak's parameter {nayak(model):.4g}")
                names = LAWS if model.kind == "bem" else [f"{q}_factor" for q in QUANTITIES]
                if model.kind != "bem":
                    names = [*names, "plateau_decades"]
                numbers = "  ".join(
                    f"{key} {text(found[key])}" for key in names if key in found
                )
                print(f"    {label:15} {numbers}")
    print("\n== cut-off over roll-off, factors")
    flat, zero = ends_of(runs["below"])
    for key, estimate in factors(zero, flat).items():
        print(f"    {key} {text(estimate)}")


def text(estimate: Estimate) -> str:
    """Write a number with its error."""
    return f"{estimate.value:.4g} ± {estimate.error:.1g}"


def ends_of(below: Results) -> tuple[ModelResult, ModelResult]:
    """Return the exact solutions with a flat spectrum below q_r, and with none."""
    flat, zero = (
        next(models["bem"] for experiment, models in below.items() if word in experiment)
        for word in ("=rolloff", "=cutoff")
    )
    return flat, zero


def main() -> None:
    """Draw, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="folder of the study's results")
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/figures"))
    given = parser.parse_args()
    names = ("contenders", "size", "rolloff", "below", "hurst", "cutoff", "resolution")
    runs = {name: rb.load(given.results / f"study-{name}.h5") for name in names}
    with publication_style():
        for name, figure in (
            ("contenders", contenders(runs["contenders"])),
            ("size", sizes(runs["size"])),
            ("kappa", kappas(runs)),
            ("rolloff", rolloffs(runs["rolloff"], runs["below"])),
            ("resolution", resolution(runs["resolution"])),
        ):
            for path in save(figure, f"study-{name}", given.output):
                if path.suffix == ".pdf":
                    path.unlink()
                else:
                    print(path)
    tables(runs)


if __name__ == "__main__":
    main()
