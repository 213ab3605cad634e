"""The claims of Lyashenko, Pastewka and Persson (2013), and how each is decided.

Every claim is one entry of :data:`CLAIMS`: what the paper says and where, the rule, and a
function that measures what the rule needs on all cases. "Follows" and "fails" are taken
where the exact solution itself has the law in question: for the area where A ∼ p, for
separation and stiffness where K ∼ p. There, a model follows if it stays within a factor
:data:`FOLLOWS` of the exact solution, and is another law from a factor :data:`ANOTHER` on;
in between, neither is shown.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from roughbench.fits import Estimate, factors
from roughbench.results import ModelResult
from roughbench.verdict.cases import Case, alike_but
from roughbench.verdict.rules import (
    Outcome,
    Rule,
    at_least,
    at_most,
    decide,
    near,
    together,
)
from roughbench.verdict.sizes import size_exponent

FOLLOWS = 1.5
ANOTHER = 2.0

_TO_FOLLOW = at_most(FOLLOWS, fails_above=ANOTHER, of_ratio=True)
_TO_DIFFER = at_least(ANOTHER, fails_below=FOLLOWS, of_ratio=True)
_QUANTITIES = {"area": "A/A₀", "separation": "ū/h_rms", "stiffness": "K h_rms"}


@dataclass(frozen=True, slots=True)
class Measurement:
    """One measured number behind a verdict.

    Attributes
    ----------
    where : str
        Experiment and label of the model, after the source where there are several.
    what : str
    value : float
        nan: there is none.
    error : float
        Half of a 68 % interval; nan: none.
    bound : {"", "≤", "≥"}
        Whether the value is a bound only.
    outcome : Outcome
        Of this number alone.
    note : str
        A remark, or nothing.
    """

    where: str
    what: str
    value: float
    error: float
    bound: str
    outcome: Outcome
    note: str = ""


Measure = Callable[[Sequence[Case], int], Iterator[Measurement]]
"""From all cases and the number of resamples."""


@dataclass(frozen=True, slots=True)
class Claim:
    """What the paper says, and how it is tested.

    Attributes
    ----------
    key, place, claim, rule, remedy : str
        As of :class:`~roughbench.verdict.Verdict`.
    measure : callable
    in_parts : bool
        Whether different numbers test different parts of it, each of which is needed.
    """

    key: str
    place: str
    claim: str
    rule: str
    remedy: str
    measure: Measure
    in_parts: bool = False

    def outcome(self, found: Sequence[Measurement]) -> Outcome:
        """Return what all measurements say: a failure counts, so does a missing part."""
        parts: dict[str, list[Outcome]] = {}
        for measurement in found:
            part = measurement.what if self.in_parts else ""
            parts.setdefault(part, []).append(measurement.outcome)
        outcomes = [together(part) for part in parts.values()]
        whole = together(outcomes)
        if whole == Outcome.HOLDS and Outcome.NOT_TESTED in outcomes:
            return Outcome.UNDECIDED
        return whole


# -- how numbers are taken ---------------------------------------------------------------


def _taken(
    case: Case,
    model: ModelResult,
    what: str,
    estimate: Estimate,
    rule: Rule,
    bound: str = "",
    note: str = "",
) -> Measurement:
    """Return a measurement with its outcome."""
    bound = bound if estimate.is_bound else ""
    exact = model.n_realizations == 1
    outcome = decide(rule, estimate, bound, exact=exact)
    if exact and case.reference is not None and case.exact is model:
        note = "; ".join(filter(None, (note, "a single surface: no error")))
    return Measurement(
        case.where(model), what, estimate.value, estimate.error, bound, outcome, note
    )


def _law(kind: str, *numbers: tuple[str, str, Rule, str]) -> Measure:
    """Measure fitted numbers, each (name of the fit, words, rule, kind of bound)."""

    def measure(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
        for case in cases:
            for model in case.of_kind(kind):
                fits = case.fits[model.label]
                for name, words, rule, bound in numbers:
                    if name in fits:
                        yield _taken(case, model, words, fits[name], rule, bound)

    return measure


def _factor(rule: Rule, quantities: Sequence[str], *kinds: str) -> Measure:
    """Measure the largest factor between models of some kinds and the exact solution."""

    def measure(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
        for case in cases:
            for model in filter(_as_published, case.of_kind(*kinds)):
                fits = case.fits[model.label]
                for name in quantities:
                    if f"{name}_factor" in fits:
                        words = f"largest factor in {_QUANTITIES[name]}"
                        estimate = fits[f"{name}_factor"]
                        note = _agreement(fits, name)
                        yield _taken(case, model, words, estimate, rule, note=note)

    return measure


def _as_published(model: ModelResult) -> bool:
    """Return whether a model is Persson's theory as the paper has it, with any γ.

    The self-consistent area and eq. (10) with a fitted prefactor came later.
    """
    if model.kind != "persson":
        return True
    fitted = model.attributes.get("finite_size", "none") != "none"
    fitted &= float(model.attributes.get("theta", 1.0)) != 1.0
    return not fitted and "area_gamma" not in model.attributes


def _agreement(fits: Mapping[str, Estimate], name: str) -> str:
    """Say where a model agrees with the exact solution within 50 %."""
    start, end = fits[f"{name}_agrees_from_50"], fits[f"{name}_agrees_to_50"]
    if not math.isfinite(start.value):
        return "nowhere within 50 %"
    return f"within 50 % from p = {start.value:.2g} to {end.value:.2g} E*"


def _close(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
    """Measure how much earlier the foundation closes than the exact solution."""
    for case in cases:
        exact = case.exact
        if exact is None:
            continue
        there = case.fits[exact.label]["half_contact"]
        for model in case.of_kind("foundation"):
            here = case.fits[model.label]["half_contact"]
            ratio = _ratio(there, here)
            words = "p at A/A₀ = ½, exact over foundation"
            yield _taken(case, model, words, ratio, at_least(ANOTHER, of_ratio=True))


def _u0(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
    """Measure u0 of eq. (3) over u0 of eq. (2), of the exact solution."""
    for case in cases:
        for model in case.of_kind("reference"):
            fits = case.fits[model.label]
            ratio = fits["u0_from_stiffness"].value / fits["u0"].value
            words = "u₀ of eq. (3) over u₀ of eq. (2)"
            # Both come from the same surfaces: their scatter is common.
            estimate = Estimate(ratio, math.nan, math.nan, math.nan, 1.0)
            outcome = decide(near(1.0, 0.1), estimate, exact=True)
            yield Measurement(case.where(model), words, ratio, math.nan, "", outcome)


def _theta(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
    for case in cases:
        for model in case.of_kind("reference"):
            fits = case.fits[model.label]
            if "theta_realized" in fits:
                yield _taken(case, model, "θ", fits["theta_realized"], near(1.0, 0.5))


def _exponent(kind: str) -> Measure:
    """Measure the exponent of K at the lowest pressures against 1/(1 + H)."""

    def measure(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
        for case in cases:
            for model in case.of_kind(kind):
                fits = case.fits[model.label]
                if "exponent_expected" in fits:
                    expected = fits["exponent_expected"].value
                    words = "n of K ∼ pⁿ"
                    rule = near(expected, 0.05)
                    note = f"1/(1+H) = {expected:.3f}"
                    yield _taken(case, model, words, fits["exponent"], rule, note=note)

    return measure


def _regions(cases: Sequence[Case], resamples: int) -> Iterator[Measurement]:
    yield from _exponent("reference")(cases, resamples)
    yield from _law(
        "reference",
        ("log_decades", "decades of K ∼ p", at_least(1.0), "≥"),
        ("exponent_above", "largest d ln K/d ln p above them", at_least(1.5), "≥"),
    )(cases, resamples)


def _three_decades(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
    for case in cases:
        for model in case.of_kind("reference"):
            found = model.attributes
            if "q_rolloff" not in found or "q_min" not in found:
                continue
            if math.isclose(float(found["q_rolloff"]), 8.0 * float(found["q_min"])):
                decades = case.fits[model.label]["log_decades"]
                yield _taken(case, model, "decades of K ∼ p", decades, near(3.0, 0.5), "≥")


def _kappa_by_rolloff(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
    for group in alike_but(cases, "q_rolloff"):
        first = group[0]
        for case in group[1:]:
            here, there = (c.exact for c in (case, first))
            if here is None or there is None:
                continue
            ratio = _ratio(case.fits[here.label]["kappa"], first.fits[there.label]["kappa"])
            low = float(there.attributes["q_rolloff"])
            high = float(here.attributes["q_rolloff"])
            words = f"κ(q_r = {high:g}) / κ(q_r = {low:g})"
            yield _taken(case, here, words, ratio, near(1.0, 0.1))


def _below_rolloff(cases: Sequence[Case], resamples: int) -> Iterator[Measurement]:
    for group in alike_but(cases, "below_rolloff"):
        without, flat = group  # cutoff, rolloff
        here, there = without.exact, flat.exact
        if here is None or there is None:
            continue
        found = factors(here, there, resamples)
        for name, words in _QUANTITIES.items():
            text = f"largest factor in {words} between cut-off and roll-off"
            yield _taken(
                without, here, text, found[f"{name}_factor"], at_most(1.2, of_ratio=True)
            )


def _sizes(target: float, kind: str) -> Measure:
    """Measure how the pressure at a given separation goes with the size of the cell."""

    def measure(cases: Sequence[Case], resamples: int) -> Iterator[Measurement]:
        for group in alike_but(cases, "length"):
            series = [next(case.of_kind(kind), None) for case in group]
            exact = group[0].exact
            found = [model for model in series if model is not None]
            if len(found) != len(group) or exact is None:
                continue
            start, end = (group[0].fits[exact.label][f"log_{side}"] for side in ("from", "to"))
            estimate = size_exponent(found, start.value, end.value, resamples)
            words = f"s of p ∼ Lˢ at the same ū, {len(found)} cells"
            yield _taken(group[-1], found[-1], words, estimate, near(target, 0.2))

    return measure


def _correlation(
    kind: str, observable: str, expected: Callable[[float], float], law: str
) -> Measure:
    """Measure the exponent of a spectrum, at the pressure whose area is nearest to 1 %."""

    def measure(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
        name = f"{observable}_exponent"
        for case in cases:
            for model in case.of_kind(kind):
                if f"{name}_mean" not in model or "hurst" not in model.attributes:
                    continue
                if case.exact is None:
                    continue
                area = np.asarray(case.exact["area_mean"], float)
                k = int(np.argmin(np.abs(np.log(np.maximum(area, 1e-300) / 0.01))))
                mean, error = float(model[f"{name}_mean"][k]), float(model[f"{name}_sem"][k])
                target = expected(float(model.attributes["hurst"]))
                estimate = Estimate(mean, error, mean - error, mean + error, 1.0)
                words = f"exponent, {law} = {target:.2f}"
                note = f"at p = {float(model['pressure'][k]):.2g} E*"
                yield _taken(case, model, words, estimate, near(target, 0.2), note=note)

    return measure


def _ratio(a: Estimate, b: Estimate) -> Estimate:
    """Return a/b of two independent estimates."""
    if not (math.isfinite(a.value) and math.isfinite(b.value)):
        return Estimate(math.nan, math.nan, math.nan, math.nan, 0.0)
    value = a.value / b.value
    parts = [0.0 if math.isnan(x.error) else x.error / x.value for x in (a, b)]
    error = value * math.hypot(*parts)
    if math.isnan(a.error) and math.isnan(b.error):
        error = math.nan
    return Estimate(value, error, value - error, value + error, min(a.share, b.share))


# -- the claims --------------------------------------------------------------------------

_ALONE = "any spec with bem, at pressures from 1e-6 to 0.1"
_WITH = "a spec with bem and {}"
_ALL = "A/A₀, ū/h_rms and K h_rms"
_FOLLOWS = f"at most {FOLLOWS:g} (fails from {ANOTHER:g} on)"
_ANOTHER = f"at least {ANOTHER:g} (fails up to {FOLLOWS:g})"


def _within(quantity: str, wanted: str) -> str:
    law = {"A/A₀": "A ∼ p", _ALL: "A ∼ p or K ∼ p"}.get(quantity, "K ∼ p")
    return (
        f"largest factor between the model's {quantity} and the exact one, where the exact "
        f"solution has {law}: {wanted}"
    )


CLAIMS = (
    Claim(
        "area-linear",
        "eq. (9)",
        "The real contact area is proportional to the pressure, A/A₀ = κ p/(E*ξ), until "
        "A approaches A₀.",
        "width of the range on which the exact A/p stays within ±10 % of one value: at least "
        "2 decades",
        _ALONE,
        _law("reference", ("kappa_decades", "decades of A ∼ p", at_least(2.0), "≥")),
    ),
    Claim(
        "kappa",
        "eq. (9)",
        "The factor is κ ≈ 2.",
        "exact κ: 2 ± 0.2",
        _ALONE,
        _law("reference", ("kappa", "κ", near(2.0, 0.2), "")),
    ),
    Claim(
        "area-rolloff",
        "Fig. 3(a)",
        "The contact area does not depend on the roll-off.",
        "ratio of the exact κ of surfaces that differ in q_r alone: 1 ± 0.1",
        "a spec with bem and sweep: {surface.qr: [1.0, 8.0]}",
        _kappa_by_rolloff,
    ),
    Claim(
        "area-persson",
        "Fig. 3(a)",
        "Persson's theory describes the contact area.",
        _within("A/A₀", _FOLLOWS),
        _WITH.format("persson"),
        _factor(_TO_FOLLOW, ("area",), "persson"),
    ),
    Claim(
        "area-foundation",
        "abstract, Fig. 3(a)",
        "The one-dimensional foundation fails qualitatively for the contact area.",
        _within("A/A₀", _ANOTHER),
        _WITH.format("foundation"),
        _factor(_TO_DIFFER, ("area",), "foundation"),
    ),
    Claim(
        "closing-foundation",
        "Fig. 3(a)",
        "In the foundation the area approaches A₀ at much lower pressure.",
        f"pressure at which A/A₀ = ½, exact over foundation: at least {ANOTHER:g}",
        _WITH.format("foundation"),
        _close,
    ),
    Claim(
        "separation-logarithmic",
        "eq. (2)",
        "The mean separation falls with the logarithm of the pressure, ū = u₀ ln(p₀/p).",
        "width of the range on which the exact K/p stays within ±20 % of one value: at least "
        "1 decade",
        _ALONE,
        _law("reference", ("log_decades", "decades of K ∼ p", at_least(1.0), "≥")),
    ),
    Claim(
        "stiffness-linear",
        "eq. (3)",
        "So the stiffness is proportional to the pressure, K = p/u₀, with the same u₀.",
        "u₀ from K over u₀ from ū, in that range: 1 ± 0.1",
        _ALONE,
        _u0,
    ),
    Claim(
        "alpha",
        "eq. (2)",
        "u₀ = αh_rms with α ≈ 0.5.",
        "exact u₀ over the rms height of the realized surfaces: 0.5 ± 0.1",
        _ALONE,
        _law("reference", ("alpha_realized", "α", near(0.5, 0.1), "")),
    ),
    Claim(
        "separation-persson",
        "Fig. 3(b)",
        "Persson's theory describes the mean separation.",
        _within("ū/h_rms", _FOLLOWS),
        _WITH.format("persson"),
        _factor(_TO_FOLLOW, ("separation",), "persson"),
    ),
    Claim(
        "separation-foundation",
        "abstract, Fig. 3(b)",
        "The one-dimensional foundation fails qualitatively for the mean separation.",
        _within("ū/h_rms", _ANOTHER),
        _WITH.format("foundation"),
        _factor(_TO_DIFFER, ("separation",), "foundation"),
    ),
    Claim(
        "three-regions",
        "Fig. 4",
        "The stiffness has three regions: K ∼ p^(1/(1+H)) where a few contacts carry all, "
        "K ∼ p, and a steep rise to full contact.",
        "exact exponent at the lowest pressures 1/(1+H) ± 0.05; at least 1 decade of K ∼ p; "
        "slope above it at least 1.5",
        "a spec with bem, at pressures from 1e-7 to 0.1 and a large q1/q0",
        _regions,
        in_parts=True,
    ),
    Claim(
        "rolloff-decades",
        "Fig. 4",
        "With a roll-off at 8 q₀ the region K ∼ p extends over about three decades.",
        "width of the range on which the exact K/p stays within ±20 % of one value: "
        "3 ± 0.5 decades",
        "a spec with bem and qr = 8 q0",
        _three_decades,
    ),
    Claim(
        "finite-size-exponent",
        "eq. (10)",
        "At the lowest pressures, in a finite system, K ∼ p^(1/(1+H)).",
        "exact exponent: 1/(1+H) ± 0.05",
        "a spec with bem, at pressures from 1e-7 and a large q1/q0",
        _exponent("reference"),
    ),
    Claim(
        "finite-size-prefactor",
        "eq. (10)",
        "There K h_rms/E* ≈ (h_rms/(L²q_r))^(H/(1+H)) (p/E*)^(1/(1+H)), with no further "
        "factor θ.",
        "exact θ, with the rms height of the realized surfaces: 1 ± 0.5",
        "a spec with bem, at pressures from 1e-7 and a large q1/q0",
        _theta,
    ),
    Claim(
        "finite-size-foundation",
        "Fig. 4",
        "The foundation has K ∼ p^(1/(1+H)) at the lowest pressures too.",
        "exponent of the foundation: 1/(1+H) ± 0.05",
        _WITH.format("foundation, at pressures from 1e-8"),
        _exponent("foundation"),
    ),
    Claim(
        "stiffness-foundation-linear",
        "Fig. 4",
        "The foundation has no region K ∼ p.",
        "width of the range on which its K/p stays within ±20 % of one value: at most 1 decade",
        _WITH.format("foundation"),
        _law("foundation", ("log_decades", "decades of K ∼ p", at_most(1.0), "≥")),
    ),
    Claim(
        "stiffness-foundation",
        "Fig. 4",
        "The one-dimensional foundation fails qualitatively for the stiffness.",
        _within("K h_rms", _ANOTHER),
        _WITH.format("foundation"),
        _factor(_TO_DIFFER, ("stiffness",), "foundation"),
    ),
    Claim(
        "stiffness-persson",
        "Fig. 4",
        "Persson's theory describes the stiffness.",
        _within("K h_rms", _FOLLOWS),
        _WITH.format("persson"),
        _factor(_TO_FOLLOW, ("stiffness",), "persson"),
    ),
    Claim(
        "coupling",
        "abstract, conclusions",
        "The foundation fails because it neglects the long-range elastic coupling: springs "
        "without coupling fail on the surface itself as well.",
        "winkler (independent springs under the surface): " + _within(_ALL, _ANOTHER),
        _WITH.format("winkler"),
        _factor(_TO_DIFFER, tuple(_QUANTITIES), "winkler"),
    ),
    Claim(
        "dimension",
        "conclusions",
        "The reduced dimension is not the problem: a line with elastic coupling follows the "
        "surface.",
        "line (the exact solution of a line): " + _within(_ALL, _FOLLOWS),
        _WITH.format("line"),
        _factor(_TO_FOLLOW, tuple(_QUANTITIES), "line"),
    ),
    Claim(
        "below-rolloff",
        "Fig. 2",
        "Whether the spectrum is flat or zero below the roll-off hardly matters.",
        "largest factor between the exact curves of both, where A ∼ p or K ∼ p: at most 1.2",
        "a spec with bem and sweep: {surface.below_qr: [rolloff, cutoff]}",
        _below_rolloff,
    ),
    Claim(
        "stress-correlation",
        "discussion",
        "With elastic coupling the stress is correlated as q^−(1+H).",
        "exponent of the exact stress spectrum where A/A₀ is nearest to 1 %: −(1+H) ± 0.2",
        _WITH.format("observables: [stress_spectrum]"),
        _correlation("reference", "stress_spectrum", lambda h: -(1.0 + h), "−(1+H)"),
    ),
    Claim(
        "overlap-correlation",
        "discussion",
        "Without coupling, where the bodies overlap, the contact is correlated as q^−(2+H).",
        "exponent of the contact spectrum of winkler where the exact A/A₀ is nearest to 1 %: "
        "−(2+H) ± 0.2",
        _WITH.format("winkler and observables: [contact_spectrum]"),
        _correlation("winkler", "contact_spectrum", lambda h: -(2.0 + h), "−(2+H)"),
    ),
    Claim(
        "overlap-stress",
        "beyond the paper",
        "The stress of independent springs is correlated as q^−(2+2H).",
        "exponent of the stress spectrum of winkler where the exact A/A₀ is nearest to 1 %: "
        "−(2+2H) ± 0.2",
        _WITH.format("winkler and observables: [stress_spectrum]"),
        _correlation("winkler", "stress_spectrum", lambda h: -(2.0 + 2.0 * h), "−(2+2H)"),
    ),
    Claim(
        "size-exact",
        "beyond the paper",
        "The exact ū(p) of a given spectrum does not depend on the size of the cell.",
        "s of p ∼ Lˢ at the same ū, cells that differ in L alone: 0 ± 0.2",
        "a spec with bem and a sweep over surface.length",
        _sizes(0.0, "reference"),
    ),
    Claim(
        "size-foundation",
        "beyond the paper",
        "The foundation's pressure scale goes with the size of the cell as 1/L.",
        "s of p ∼ Lˢ at the same ū, cells that differ in L alone: −1 ± 0.2",
        "a spec with bem, foundation and a sweep over surface.length",
        _sizes(-1.0, "foundation"),
    ),
    Claim(
        "asperities",
        "beyond the paper",
        "Models of independent summits fail for the contact area.",
        _within("A/A₀", _ANOTHER),
        _WITH.format("gw or gw_elliptic"),
        _factor(_TO_DIFFER, ("area",), "gw", "gw_elliptic"),
    ),
)
"""In the order of the paper's quantities: area, separation, stiffness, the reasons."""
