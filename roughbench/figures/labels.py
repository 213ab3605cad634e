"""What the figures say: axes, legends and remarks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from roughbench.figures.curves import curve_of
from roughbench.figures.points import POINTS
from roughbench.models.registry import declared, is_theory
from roughbench.results import ModelResult, Results
from roughbench.units import in_words

MODULUS = r"E\!^*"
_SYMBOLS: Mapping[str, str] = {
    "surface.H": "H",
    "surface.q0": "q_0",
    "surface.qr": "q_r",
    "surface.q1": "q_1",
    "surface.slope": r"\xi",
    "surface.length": "L",
    "surface.rms_height": r"h_\mathrm{rms}",
}

_WAVEVECTORS = ("surface.qr", "surface.q1")


def number_text(value: float) -> str:
    r"""Return a positive number with two digits, as in a text.

    Examples
    --------
    >>> print(number_text(2.73e-05))
    $2.7\times10^{-5}$
    """
    digits, exponent = f"{value:.1e}".split("e")
    return rf"${digits}\times10^{{{int(exponent)}}}$"


def pressure_text(result: ModelResult | Results, pressure: float) -> str:
    """Return what pressure a panel is about: p/E*, or of results with units p."""
    if result.has_units:
        return f"$p$ = {in_words(pressure, 'Pa')}"
    return rf"$p/{MODULUS} = {number_text(pressure).strip('$')}$"


def experiment_label(name: str, q_min: float | None = None) -> str:
    """Return how an experiment is called in a legend; empty for the only one, ``main``.

    Parameters
    ----------
    name : str
        Of the experiment, in the words of the spec.
    q_min : float, optional
        q0, where it is known: other wavevectors are divided by it.

    Examples
    --------
    >>> experiment_label("surface.qr=8.0", 1.0), experiment_label("main")
    ('$q_r/q_0 = 8$', '')
    """
    if name == "main":
        return ""
    words = []
    for part in name.split(","):
        key, equals, value = part.partition("=")
        symbol = _SYMBOLS.get(key)
        try:
            number = float(value)
        except ValueError:
            number, symbol = math.nan, None
        if q_min and key in _WAVEVECTORS:
            symbol, number = f"{symbol}/q_0", number / q_min
        if symbol and math.isfinite(number):
            words.append(f"${symbol} = {_plain(number)}$")
        else:
            words.append(f"{key.removeprefix('surface.')} = {value}" if equals else part)
    return ", ".join(words)


def _plain(number: float) -> str:
    """Return a number of a spec with the digits that tell it from its neighbours."""
    digits, times, exponent = f"{number:.6g}".partition("e")
    return rf"{digits}\times10^{{{int(exponent)}}}" if times else digits


def experiment_labels(results: Results) -> dict[str, str]:
    """Return how each experiment is called in a legend, wavevectors in units of q0."""
    return {
        name: experiment_label(name, smallest_wavevector(results, name)) for name in results
    }


def smallest_wavevector(results: Results, experiment: str) -> float | None:
    """Return q0 of the surfaces of an experiment; None of given heights."""
    for result in results[experiment].values():
        if "q_min" in result.attributes:
            return float(result.attributes["q_min"])
    return None


def height_remark(results: Results) -> str:
    """Return which rms height the lengths are divided by, in words for a caption.

    Empty of results with units, whose lengths are divided by none.

    The sum over the modes of a cell exceeds the integral over the spectrum by up to
    40 % of h_rms without a roll-off, so a figure has to name its h_rms.
    """
    if results.has_units:
        return ""
    from_files = {result.is_measured for _, result in results.models()}
    words = {
        frozenset({False}): "rms height of the spectrum (continuum)",
        frozenset({True}): "rms height of the given heights",
    }
    either = "rms height of the spectrum, or of the given heights"
    return rf"$h_\mathrm{{rms}}$: {words.get(frozenset(from_files), either)}."


def model_names(results: Results, experiments: Sequence[str], quantity: str) -> dict[str, str]:
    """Return the legend's text for every label: title, parameters, n, kind of average."""
    found: dict[str, list[ModelResult]] = {}
    for experiment in experiments:
        for label, result in results[experiment].items():
            found.setdefault(label, []).append(result)
    titles = [models[0].title for models in found.values()]
    names = {}
    for label, models in found.items():
        title, kind = models[0].title, models[0].kind
        if titles.count(title) > 1 and label != kind:
            title = f"{title}, {label}"
        remarks = _parameters(models[0], quantity) + _counts(models)
        if any(curve_of(model, quantity).is_median.all() for model in models):
            remarks.append("median")
        names[label] = ", ".join([title, *remarks])
    return names


def titles(models: Mapping[str, ModelResult]) -> dict[str, str]:
    """Return a title for every label, which tells it from the others."""
    plain = [result.title for result in models.values()]
    return {
        label: result.title if plain.count(result.title) == 1 else f"{result.title}, {label}"
        for label, result in models.items()
    }


def _counts(models: Sequence[ModelResult]) -> list[str]:
    """Return the number of realizations; a theory of the spectrum alone has none."""
    if all(_is_theory(model) for model in models):
        return []
    counts = sorted({model.n_realizations for model in models})
    span = f"{counts[0]}" if len(counts) == 1 else f"{counts[0]}–{counts[-1]}"
    return [f"$n = {span}$" if len(counts) == 1 else f"$n$ = {span}"]


def _is_theory(model: ModelResult) -> bool:
    """Return whether there is nothing to count: a model of the spectrum alone, or points."""
    if model.kind == POINTS:
        return True
    has_heights = "grid_points" in model.attributes or model.is_measured
    return is_theory(model.kind) or not (has_heights or model.n_realizations > 1)


def _parameters(model: ModelResult, quantity: str) -> list[str]:
    known = declared(model.kind)
    return [*known.legend(model.attributes, quantity)] if known else []


def unconverged_remarks(results: Results) -> list[str]:
    """Return a line for every contender with states that the averages leave out."""
    total: dict[str, tuple[str, int, int]] = {}
    for _, result in results.models():
        _, failed, states = total.get(result.label, ("", 0, 0))
        total[result.label] = (
            result.title,
            failed + result.n_unconverged,
            states + result.n_states,
        )
    return [
        f"{title}: {failed} of {states} states did not converge and are left out."
        for title, failed, states in total.values()
        if failed
    ]
