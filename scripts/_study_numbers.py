"""Every number of docs/study.md, by a name, from the results of the study's runs."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from _study_curves import (
    Curve,
    FloatArray,
    IntArray,
    Number,
    at_pressure,
    at_separation,
    jackknife,
    number_of,
    ratio_of,
)

from roughbench.fits import Estimate, fit
from roughbench.models.distributions import persson_gap_shares
from roughbench.results import ModelResult, Results
from roughbench.spec import load_spec
from roughbench.spectrum import Spectrum, self_affine, wavenumbers

Runs = Mapping[str, Results]
Numbers = Mapping[str, Number]
Lines = Iterator[tuple[str, Number]]

RUNS = (
    "ladder",
    "slope-8",
    "slope-32",
    "slope-32-coarse",
    "slope-128",
    "slope-128-few",
    "slope-512",
    "contenders-256",
    "cells",
    "exponents-8",
    "exponents-64",
    "gaussian",
    "points",
    "finite-size",
    "finite-size-rolloff",
    "theory",
)
"""Those that numbers are read from, as far as they are there: configs/study/NAME.yaml."""
CONFIGS = Path(__file__).parents[1] / "configs" / "study"
SEPARATIONS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5)
PRESSURES = (1e-5, 1e-4, 1e-3, 1e-2)
SLOPE_RANGE = (1e-5, 1e-3)
RESAMPLES = 300


def slope_cases(runs: Runs) -> Iterator[tuple[str, Mapping[str, ModelResult]]]:
    """Yield name and models of the ensembles that local slopes are read from.

    The name is q₁/q_r, then ``-bumps`` where there are other than 256 bumps of the roll-off in
    the cell, or ``-coarse``.
    """
    if "cells" in runs:
        for models in runs["cells"].values():
            side = float(models["bem"].attributes["length"]) / (2.0 * math.pi)
            bumps = round((16.0 * side) ** 2)
            yield "8" if bumps == 256 else f"8-{bumps}", models
    if "exponents-64" in runs:
        yield "8-4096-coarse", runs["exponents-64"]["surface.H=0.7"]
    for name in ("8", "32-coarse", "32", "128-few", "128", "512"):
        if f"slope-{name}" in runs:
            yield "8-4096" if name == "8" else name, runs[f"slope-{name}"]["main"]


def _drift(curve: Curve) -> float:
    return curve.at_separation("slope", 1.5) / curve.at_separation("slope", 3.0)


def _exponent(curve: Curve) -> float:
    return curve.exponent(*SLOPE_RANGE)


def _decades(curve: Curve) -> float:
    """Return the decades of pressure between ū = h/2 and 2h."""
    return math.log10(curve.pressure_at(0.5) / curve.pressure_at(2.0))


def slopes(runs: Runs) -> Lines:
    """Yield local slopes p/(K h), pressures at equal separation, mean exponents of K."""
    for case, models in slope_cases(runs):
        exact = models["bem"]
        for label in ("bem", "winkler", "winkler-gaussian", "persson"):
            if label not in models:
                continue
            model = models[label]
            yield f"exponent.{case}.{label}", number_of(model, _exponent)
            yield f"drift.{case}.{label}", number_of(model, _drift)
            for u in SEPARATIONS:
                name = f"{case}.{label}.{u:g}"
                yield f"slope.{name}", number_of(model, at_separation("slope", u))
                if label != "bem":
                    for what, quantity in (("pressure", "pressure"), ("slope-over", "slope")):
                        found = ratio_of(model, exact, at_separation(quantity, u))
                        yield f"{what}.{name}", found
            if label == "bem":
                continue
            for p in PRESSURES:
                for what in ("separation", "stiffness"):
                    found = ratio_of(model, exact, at_pressure(what, p))
                    yield f"{what}-ratio.{case}.{label}.{p:g}", found
        for p in (1e-4, 1e-3):
            rate = number_of(exact, at_pressure("area", p))
            scale = float(exact.attributes["rms_slope"]) / p
            yield f"kappa.{case}.{p:g}", _times(rate, scale)
        yield f"decades.{case}", number_of(exact, _decades)
        yield f"area-at.{case}.2", number_of(exact, at_separation("area", 2.0))
        yield f"area-at.{case}.3", number_of(exact, at_separation("area", 3.0))
        yield f"first.{case}", number_of(exact, at_pressure("separation", 1e-6))


def _times(number: Number, factor: float) -> Number:
    return Number(number.value * factor, number.error * factor, number.count)


def spectrum_of(model: ModelResult) -> Spectrum:
    """Return the spectrum of a model's surfaces."""
    a = model.attributes
    return self_affine(
        hurst=float(a["hurst"]),
        q_min=float(a["q_min"]),
        q_rolloff=float(a["q_rolloff"]),
        q_max=float(a["q_max"]),
        rms_slope=float(a["rms_slope"]),
        below_rolloff=str(a["below_rolloff"]),
    )


def stiffening(model: ModelResult, screening: float) -> float:
    """Return by which factor screening raises the energy at full contact.

    Σ|h_q|²√(q² + q_c²)/Σ|h_q|²q over the waves of a cell, for fixed amplitudes.
    """
    points = int(model.attributes["grid_points"])
    q = wavenumbers((points, points), float(model.attributes["length"]))
    power = spectrum_of(model).psd_2d(q)
    power[:, 1:-1] *= 2.0  # the other half plane
    return float(np.sum(power * np.hypot(q, screening)) / np.sum(power * q))


def rungs(results: Results) -> Iterator[tuple[float, ModelResult, float]]:
    """Yield q_c, the model and the scale of its pressures of every rung of the ladder.

    With q_c the half-space becomes stiffer as well as less coupled. The scale, the inverse of
    :func:`stiffening`, undoes the former: all rungs hold the same energy at full contact, and
    the last are the springs with k_w.
    """
    for experiment, models in results.items():
        screening = float(experiment.rpartition("=")[2])
        yield screening, models["bem"], 1.0 / stiffening(models["bem"], screening)
    yield math.inf, next(iter(results.values()))["winkler"], 1.0


def ladder(runs: Runs) -> Lines:
    """Yield what each rung of the coupling ladder has over the half-space."""
    if "ladder" not in runs:
        return
    found = list(rungs(runs["ladder"]))
    exact = found[0][1]
    for screening, model, scale in found:
        name = f"ladder.{screening:g}"
        yield f"{name}.stiffening", Number(1.0 / scale)
        for p in (1e-4, 1e-3, 1e-2):
            for what in ("area", "separation", "stiffness"):
                yield (
                    f"{name}.{what}.{p:g}",
                    ratio_of(model, exact, at_pressure(what, p), scale),
                )
            for what in ("stress", "contact"):
                read = functools.partial(_spectrum_at, model, what, p, scale)
                yield f"{name}.{what}.{p:g}", jackknife(read, model.n_realizations)
        for u in (1.0, 2.0, 3.0):
            for what in ("area", "slope", "pressure"):
                value = ratio_of(model, exact, at_separation(what, u), scale)
                yield f"{name}.{what}-at.{u:g}", value


def _spectrum_at(
    model: ModelResult, what: str, pressure: float, scale: float, chosen: IntArray
) -> float:
    """Return the exponent of a spectrum at a pressure, between those that were computed."""
    values = np.asarray(model[f"{what}_spectrum_exponent"], float)[chosen].mean(axis=0)
    x = np.log(np.asarray(model["pressure"], float) * scale)
    known = np.isfinite(values)
    if not x[known][0] <= math.log(pressure) <= x[known][-1]:
        return math.nan
    return float(np.interp(math.log(pressure), x[known], values[known]))


def _number(found: Estimate) -> Number:
    return Number(found.value, found.error, found.count)


def fitted(runs: Runs, name: str, wanted: Mapping[str, tuple[str, ...]]) -> Lines:
    """Yield numbers of ``roughbench fit``: by run, experiment, label and name."""
    if name not in runs:
        return
    for experiment, models in fit(runs[name], resamples=RESAMPLES).items():
        case = experiment.replace("surface.", "")
        for label, found in models.items():
            for what in wanted.get(label, wanted.get("", ())):
                if what in found:
                    yield f"{name}.{case}.{label}.{what}", _number(found[what])


FACTORS = (
    "area_factor",
    "separation_factor",
    "stiffness_factor",
    "pressure_at_separation_factor",
    "pressure_at_1h",
    "pressure_at_2h",
    "pressure_at_3h",
)
LAWS = (
    "kappa",
    "kappa_decades",
    "drift_1",
    "drift_2",
    "drift_3",
    "alpha_realized",
    "log_decades",
)
FEW = ("exponent", "exponent_expected", "theta_realized")


def fits(runs: Runs) -> Lines:
    """Yield what is fitted to the contenders, to other H and to the lowest pressures."""
    contenders = {
        "bem": (*LAWS, *FEW, "half_contact"),
        "": (*FACTORS, *LAWS, *FEW, "half_contact"),
    }
    yield from fitted(runs, "contenders-256", contenders)
    for name in ("exponents-8", "exponents-64"):
        yield from fitted(runs, name, {"bem": LAWS, "": (*FACTORS, *LAWS)})
        for experiment, models in runs[name].items() if name in runs else ():
            rate = number_of(models["bem"], at_pressure("area", 1e-3))
            scale = float(models["bem"].attributes["rms_slope"]) / 1e-3
            yield f"kappa.{name}.{experiment.rpartition('=')[2]}", _times(rate, scale)


FEW_PRESSURES = (10**-6.5, 10**-5.5)
"""Between which the exponent of the finite-size law is taken; θ in the middle."""


def few_contacts(runs: Runs) -> Lines:
    """Yield n of K ∼ pⁿ at the lowest pressures, and θ of eq. (10) there, realized h_rms."""
    for name in ("finite-size", "finite-size-rolloff"):
        for experiment, models in runs[name].items() if name in runs else ():
            case = f"{name}.{experiment.rpartition('=')[2]}"
            yield f"few.{case}.expected", Number(1.0 / (1.0 + _hurst(models["bem"])))
            for label in ("bem", "foundation", "winkler"):
                model = models[label]
                power = number_of(model, lambda curve: curve.exponent(*FEW_PRESSURES))
                yield f"few.{case}.{label}.exponent", power
                stiffness = number_of(model, at_pressure("stiffness", 1e-6))
                yield (
                    f"few.{case}.{label}.theta",
                    _times(stiffness, 1.0 / _printed(model, 1e-6)),
                )


def _hurst(model: ModelResult) -> float:
    return float(model.attributes["hurst"])


def _printed(model: ModelResult, pressure: float) -> float:
    """Return K h_rms/E* of eq. (10), the finite-size law, with θ = 1 and realized h_rms."""
    share = 1.0 / (1.0 + _hurst(model))
    height = float(np.mean(model["rms_height"]))
    base = height / (
        float(model.attributes["length"]) ** 2 * float(model.attributes["q_rolloff"])
    )
    return float(base ** (1.0 - share) * pressure**share)


def sizes(runs: Runs) -> Lines:
    """Yield s of p ∼ L^s at one separation, from cells of L and 2L."""
    if "cells" not in runs:
        return
    ends = list(runs["cells"].values())
    first, last = ends[0], ends[-1]
    times = float(last["bem"].attributes["length"]) / float(first["bem"].attributes["length"])
    for label in ("bem", "foundation", "line"):
        for u in (1.0, 2.0):
            a, b = (
                number_of(one[label], at_separation("pressure", u)) for one in (first, last)
            )
            error = math.hypot(a.error / a.value, b.error / b.value) / math.log(times)
            power = math.log(b.value / a.value) / math.log(times)
            yield f"size.{label}.{u:g}", Number(power, error, min(a.count, b.count))
    for models, times_ in zip(ends, (1, 2), strict=True):
        for p in (1e-5, 1e-4, 1e-3):
            for what in ("area", "separation", "stiffness"):
                found = ratio_of(models["line"], models["bem"], at_pressure(what, p))
                yield f"line.{times_}.{what}.{p:g}", found


def mean_response(model: ModelResult) -> float:
    """Return k_w = M₁/2M₀ of a foundation's lines, whose amplitudes are fixed, in E*/length."""
    spectrum, length = spectrum_of(model), float(model.attributes["length"])
    highest = round(float(model.attributes["q_max"]) * length / (2.0 * math.pi))
    q = 2.0 * math.pi / length * np.arange(1, highest + 1)
    power = spectrum.psd_1d(q)
    return float(np.sum(power * q) / (2.0 * np.sum(power)))


def foundation(runs: Runs) -> Lines:
    """Yield the foundation over the exact solution with one thing changed at a time.

    Its scale (``published``: aE*, ``mean``: k_w as the springs under the surface) and its
    rule for the area (``area``: Σn², ``points``: springs in contact). Neither changes a state:
    pressures are multiplied, areas counted otherwise.
    """
    if "contenders-256" not in runs:
        return
    for experiment, models in runs["contenders-256"].items():
        case = f"{float(experiment.rpartition('=')[2]):g}"
        model, exact = models["foundation"], models["bem"]
        counted = np.asarray(model["springs_in_contact"], float) / int(
            model.attributes["springs"]
        )
        by_points = replace(model, variables={**model.variables, "area": counted})
        times = mean_response(model) * math.pi / 4.0 * float(model.attributes["length"])
        yield f"foundation.{case}.stiffening", Number(times)
        for scale, factor in (("published", 1.0), ("mean", times)):
            for p in (1e-5, 1e-4, 1e-3, 1e-2):
                for what in ("area", "separation", "stiffness"):
                    found = ratio_of(model, exact, at_pressure(what, p), factor)
                    yield f"foundation.{case}.{scale}.{what}.{p:g}", found
                found = ratio_of(by_points, exact, at_pressure("area", p), factor)
                yield f"foundation.{case}.{scale}.points.{p:g}", found
            for u in (1.0, 2.0, 3.0):
                read = at_separation("pressure", u)
                name = f"foundation.{case}.{scale}.pressure-at.{u:g}"
                yield name, ratio_of(model, exact, read, factor)
        line = models["line"]
        raw = replace(line, variables={**line.variables, "area": line["area_raw"]})
        for p in (1e-4, 1e-3, 1e-2):
            yield f"edges.{case}.line.{p:g}", ratio_of(line, raw, at_pressure("area", p))
        for label in ("winkler", "line", "persson", "gw"):
            for p in (1e-5, 1e-4, 1e-3, 1e-2):
                for what in ("area", "separation", "stiffness"):
                    found = ratio_of(models[label], exact, at_pressure(what, p))
                    yield f"beside.{case}.{label}.{what}.{p:g}", found
            for u in (1.0, 2.0, 3.0):
                read = at_separation("pressure", u)
                yield (
                    f"beside.{case}.{label}.pressure-at.{u:g}",
                    ratio_of(models[label], exact, read),
                )


def amplitudes(runs: Runs) -> Lines:
    """Yield what Gaussian amplitudes change, and by how much their surfaces scatter."""
    if "gaussian" not in runs:
        return
    fixed, gaussian = runs["gaussian"].values()
    heights = np.asarray(gaussian["bem"]["rms_height"], float)
    count = heights.size
    yield (
        "gaussian.height-scatter",
        jackknife(
            lambda chosen: float(heights[chosen].std(ddof=1) / heights[chosen].mean()), count
        ),
    )
    yield (
        "gaussian.height",
        jackknife(
            lambda chosen: float(heights[chosen].mean() / fixed["bem"]["rms_height"].mean()),
            count,
        ),
    )
    for label in ("bem", "winkler"):
        for p in PRESSURES:
            for what in ("area", "separation", "stiffness"):
                read = at_pressure(what, p)
                a, b = (number_of(one[label], read) for one in (gaussian, fixed))
                value = a.value / b.value
                error = value * math.hypot(a.error / a.value, b.error / b.value)
                yield f"gaussian.{label}.{what}.{p:g}", Number(value, error, count)
    for p in PRESSURES:
        for what in ("area", "separation", "stiffness"):
            for case, models in (("fixed", fixed), ("gaussian", gaussian)):
                found = ratio_of(models["winkler"], models["bem"], at_pressure(what, p))
                yield f"gaussian.{case}.winkler.{what}.{p:g}", found


def points(runs: Runs) -> Lines:
    """Yield what 2 and 4 points on the shortest wave change, against 8 and the limit."""
    if "points" not in runs:
        return
    models = [one["bem"] for one in runs["points"].values()]
    grids = [int(model.attributes["grid_points"]) for model in models]
    waves = float(models[0].attributes["q_max"])
    finest = models[-1]
    for model, grid in zip(models[:-1], grids[:-1], strict=True):
        for p in (1e-4, 1e-3, 1e-2):
            for what in ("area", "separation", "stiffness"):
                found = ratio_of(model, finest, at_pressure(what, p))
                yield f"points.{grid / waves:g}.{what}.{p:g}", found
    for p in (1e-4, 1e-3, 1e-2):
        read = functools.partial(_limit, models, p)
        yield f"points.limit.area.{p:g}", jackknife(read, finest.n_realizations)


def _limit(models: list[ModelResult], pressure: float, chosen: IntArray) -> float:
    """Return A on two points over its limit, with an error ∼ 1/points of 4 and 8 points."""
    k = int(np.argmin(np.abs(np.log(np.asarray(models[0]["pressure"], float) / pressure))))
    two, four, eight = (np.asarray(one["area"])[chosen, k].mean() for one in models)
    return float(two / (2.0 * eight - four))


def distributions(runs: Runs) -> Lines:
    """Yield densities of pressure and gap over the exact ones, at loads near powers of ten."""
    if "contenders-256" not in runs:
        return
    for experiment, models in runs["contenders-256"].items():
        case, exact = f"{float(experiment.rpartition('=')[2]):g}", models["bem"]
        for p in (1e-4, 1e-3, 1e-2):
            k = int(np.argmin(np.abs(np.log(np.asarray(exact["pressure"], float) / p))))
            for label in ("winkler", "persson"):
                for sigma in (0.1, 0.5, 1.0):
                    read = functools.partial(_pressure_density, models[label], exact, k, sigma)
                    found = jackknife(read, exact.n_realizations)
                    yield f"pdf.{case}.{label}.pressure-{sigma:g}.{p:g}", found
            gaps = (("winkler", models["winkler"]), ("persson", models["persson"]))
            for label, density in ((name, gap_density(one, exact, k)) for name, one in gaps):
                for low, high in ((0.01, 0.1), (0.1, 1.0), (1.0, 10**0.5), (10**0.5, 10.0)):
                    read = functools.partial(_gap_share, density, exact, k, low, high)
                    found = jackknife(read, exact.n_realizations)
                    yield f"pdf.{case}.{label}.gap-{low:.2g}-{high:.2g}.{p:g}", found


def _pressure_density(
    model: ModelResult, exact: ModelResult, k: int, sigma: float, chosen: IntArray
) -> float:
    """Return the density at σ/(E*ξ), mean of five bins around it, over the exact one."""
    at = int(np.argmin(np.abs(np.asarray(exact["pressure_pdf_bin"], float) - sigma)))
    part = slice(at - 2, at + 3)
    ours = np.asarray(exact["pressure_pdf"], float)[chosen, k, part].mean()
    if model.kind == "persson":
        return float(np.asarray(exact["pressure_pdf_persson"], float)[k, part].mean() / ours)
    return float(np.asarray(model["pressure_pdf"], float)[chosen, k, part].mean() / ours)


def gap_density(model: ModelResult, exact: ModelResult, k: int) -> FloatArray:
    """Return the density of the gap over h_rms at a pressure, in the bins of the exact one.

    Its shape is that of realizations and bins, for Persson's theory of bins alone.
    """
    if model.kind != "persson":
        return np.asarray(model["gap_pdf"], float)[:, k]
    spectrum, edges = spectrum_of(exact), np.asarray(exact["gap_pdf_edges"], float)
    pressure, gamma = float(exact["pressure"][k]), float(model.attributes["gamma"])
    shares = persson_gap_shares(edges * spectrum.rms_height, spectrum, pressure, gamma)
    return shares / np.diff(edges)


def _gap_share(
    density: FloatArray, exact: ModelResult, k: int, low: float, high: float, chosen: IntArray
) -> float:
    """Return the share of points with a gap between two, in h_rms, over the exact one."""
    edges = np.asarray(exact["gap_pdf_edges"], float)
    part = (edges[:-1] >= low * 0.999) & (edges[1:] <= high * 1.001)
    width = np.diff(edges)[part]
    ours = density[chosen] if density.ndim == 2 else density[None]
    one, other = (
        float((values[:, part] * width).sum(axis=1).mean())
        for values in (ours, gap_density(exact, exact, k)[chosen])
    )
    return one / other


def theories(runs: Runs) -> Lines:
    """Yield over how many decades Persson's theory has K ∼ p at the paper's cut-off."""
    yield from fitted(runs, "theory", {"persson": ("drift_3", "log_decades", "alpha_realized")})


def ensembles(runs: Runs) -> Lines:
    """Yield how many exact surfaces a run has, and for how many its spec asks."""
    for name, results in runs.items():
        models = next(iter(results.values()))
        if "bem" not in models:
            continue
        count = min(one["bem"].n_realizations for one in results.values())
        yield f"run.{name}.computed", Number(float(count))
        spec = load_spec(CONFIGS / f"{name}.yaml")
        yield f"run.{name}.asked", Number(float(spec.realizations))


def everything(runs: Runs) -> dict[str, Number]:
    """Return all numbers, by name."""
    found: dict[str, Number] = {}
    for part in (
        slopes,
        ladder,
        foundation,
        distributions,
        fits,
        few_contacts,
        sizes,
        amplitudes,
        points,
        theories,
        ensembles,
    ):
        for name, number in part(runs):
            if name in found:
                raise ValueError(f"two numbers of the name {name}")
            found[name] = number
    return found
