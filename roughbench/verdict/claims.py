"""The claims of Lyashenko, Pastewka and Persson (2013), and how each is decided.

Every claim is one entry of :data:`CLAIMS`: what the paper says and where, the rule, and a
function that measures what the rule needs on all cases. The thresholds are ours: the paper
compares curves by eye. Models are held against the exact solution where that itself has the
law in question: for the area where A ∼ p, for separation and stiffness where K ∼ p. There, a
model follows if it stays within a factor :data:`FOLLOWS` (e to the rms of the logarithm of the
ratio), and is off from a factor :data:`ANOTHER` on; in between, neither is shown, however
small the error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from roughbench.fits import MISSING, Estimate, factors, n_random
from roughbench.results import ModelResult
from roughbench.verdict.cases import Case, alike_but
from roughbench.verdict.rules import (
    Outcome,
    Rule,
    about,
    at_least,
    at_most,
    decide,
    near,
    together,
)
from roughbench.verdict.sizes import size_exponent

FOLLOWS = 1.5
ANOTHER = 2.0
MANY_SCALES = 32.0
"""q₁/q_r of a spectrum with many scales; the paper's is 1024 or more."""
GAMMAS = (0.4, 0.5)
"""γ of the paper's theory, which says that it is about 0.45."""

_TO_FOLLOW = at_most(FOLLOWS, fails_above=ANOTHER, of_ratio=True)
_TO_DIFFER = at_least(ANOTHER, fails_below=FOLLOWS, of_ratio=True)
_SYMBOLS = {"area": "A/A₀", "separation": "ū/h_rms", "stiffness": "K h_rms"}
_WORDS = {
    "area": "the contact area",
    "separation": "the mean separation",
    "stiffness": "the stiffness",
}


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
        outcomes = self._of_parts(found)
        whole = together(outcomes)
        if whole == Outcome.HOLDS and Outcome.NOT_TESTED in outcomes:
            return Outcome.UNDECIDED
        return whole

    def lacks(self, found: Sequence[Measurement]) -> bool:
        """Return whether nothing tests it, or one of its parts."""
        return not found or Outcome.NOT_TESTED in self._of_parts(found)

    def _of_parts(self, found: Sequence[Measurement]) -> list[Outcome]:
        parts: dict[str, list[Outcome]] = {}
        for measurement in found:
            part = measurement.what if self.in_parts else ""
            parts.setdefault(part, []).append(measurement.outcome)
        return [together(part) for part in parts.values()]


# -- how numbers are taken ---------------------------------------------------------------


def _models(
    cases: Sequence[Case], *kinds: str
) -> Iterator[tuple[Case, ModelResult, Mapping[str, Estimate]]]:
    """Yield every model of some kinds, with its case and its fits."""
    for case in cases:
        for model in case.of_kind(*kinds):
            yield case, model, case.fits[model.label]


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
    outcome = decide(rule, estimate, bound)
    if not estimate.is_given:
        note = "the model does not give it"
    elif outcome == Outcome.NOT_TESTED:
        note = "there is no such region, or no value in it"
    elif math.isnan(estimate.low) and estimate.count == 1:
        note = "; ".join(filter(None, (note, "a single surface: no error")))
    return Measurement(
        case.where(model), what, estimate.value, estimate.error, bound, outcome, note
    )


def _not_tested(case: Case, model: ModelResult, what: str, why: str) -> Measurement:
    return Measurement(case.where(model), what, math.nan, math.nan, "", Outcome.NOT_TESTED, why)


def _law(kind: str, *numbers: tuple[str, str, Rule, str]) -> Measure:
    """Measure fitted numbers, each (name of the fit, words, rule, kind of bound)."""

    def measure(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
        for case, model, fits in _models(cases, kind):
            for name, words, rule, bound in numbers:
                if name in fits:
                    yield _taken(case, model, words, fits[name], rule, bound)

    return measure


def _factor(rule: Rule, name: str, *kinds: str) -> Measure:
    """Measure the factor between models of some kinds and the exact solution."""

    def measure(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
        words = f"factor in {_SYMBOLS[name]}"
        for case, model, fits in _models(cases, *kinds):
            if not _as_published(model):
                continue
            if f"{name}_factor" in fits:
                note = _agreement(fits, name)
                yield _taken(case, model, words, fits[f"{name}_factor"], rule, note=note)
            elif case.exact is not None:
                why = "its pressures are not those of the exact solution"
                yield _not_tested(case, model, words, why)

    return measure


def _as_published(model: ModelResult) -> bool:
    """Return whether a model is Persson's theory as the paper has it.

    Other γ, the self-consistent area and eq. (10) with a fitted prefactor are not.
    """
    if model.kind != "persson":
        return True
    found = model.attributes
    fitted = found.get("finite_size", "none") != "none"
    fitted &= float(found.get("theta", 1.0)) != 1.0
    usual = GAMMAS[0] <= float(found.get("gamma", 0.45)) <= GAMMAS[1]
    return usual and not fitted and "area_gamma" not in found


def _agreement(fits: Mapping[str, Estimate], name: str) -> str:
    """Say where a model agrees with the exact solution within 50 %."""
    start, end = fits[f"{name}_agrees_from_50"], fits[f"{name}_agrees_to_50"]
    if not math.isfinite(start.value):
        return "nowhere within 50 %"
    low = "the first pressure" if start.is_bound else f"p = {start.value:.2g} E*"
    high = "the last" if end.is_bound else f"{end.value:.2g} E*"
    return f"within 50 % from {low} to {high}"


def _close(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
    """Measure how much earlier the foundation closes than the exact solution."""
    words = "p at A/A₀ = ½, exact over foundation"
    for case, model, fits in _models(cases, "foundation"):
        if case.reference is not None:
            there = case.fits[case.reference]["half_contact"]
            ratio = _ratio(there, fits["half_contact"])
            yield _taken(case, model, words, ratio, at_least(ANOTHER, of_ratio=True))


def _exponent(kind: str) -> Measure:
    """Measure the exponent of K at the lowest pressures against 1/(1 + H)."""

    def measure(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
        for case, model, fits in _models(cases, kind):
            if "exponent_expected" in fits:
                expected = fits["exponent_expected"].value
                rule, note = near(expected, 0.05), f"1/(1+H) = {expected:.3f}"
                yield _taken(case, model, "n of K ∼ pⁿ", fits["exponent"], rule, note=note)

    return measure


def _regions(cases: Sequence[Case], resamples: int) -> Iterator[Measurement]:
    yield from _exponent("reference")(cases, resamples)
    yield from _law(
        "reference",
        ("plateau_decades", "decades of slope 1", at_least(1.0), "≥"),
        ("exponent_above", "largest d ln K/d ln p above them", at_least(1.5), ""),
    )(cases, resamples)


def _kappa(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
    """Measure κ of the exact solution, on spectra of many scales."""
    for case, model, fits in _models(cases, "reference"):
        if _is_narrow(model):
            yield _not_tested(case, model, "κ", _NARROW)
        else:
            yield _taken(case, model, "κ", fits["kappa"], near(2.0, 0.2))


def _is_narrow(model: ModelResult) -> bool:
    found = model.attributes
    if "q_max" not in found or "q_rolloff" not in found:
        return False
    return float(found["q_max"]) < MANY_SCALES * float(found["q_rolloff"]) * (1.0 - 1e-9)


_NARROW = f"q₁ is less than {MANY_SCALES:g} q_r"


def _three_decades(cases: Sequence[Case], _resamples: int) -> Iterator[Measurement]:
    for case, model, fits in _models(cases, "reference"):
        found = model.attributes
        if "q_rolloff" not in found or "q_min" not in found:
            continue
        eight = math.isclose(float(found["q_rolloff"]), 8.0 * float(found["q_min"]))
        bump = float(found["q_min"]) * float(found["length"]) / (2.0 * math.pi)
        if eight and math.isclose(bump, 1.0, rel_tol=1e-6):
            decades, rule = fits["log_decades"], near(3.0, 0.5)
            yield _taken(case, model, "decades of K ∼ p", decades, rule, "≥")


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
            if _is_narrow(here):
                yield _not_tested(case, here, words, _NARROW)
            else:
                yield _taken(case, here, words, ratio, near(1.0, 0.1))


def _below_rolloff(cases: Sequence[Case], resamples: int) -> Iterator[Measurement]:
    for group in alike_but(cases, "below_rolloff"):
        without, flat = group  # cutoff, rolloff
        here, there = without.exact, flat.exact
        if here is None or there is None:
            continue
        found = factors(here, there, resamples)
        for name, words in _SYMBOLS.items():
            text = f"factor in {words} between cut-off and roll-off"
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
        name, words = f"{observable}_exponent", f"exponent, {law}"
        for case, model, _ in _models(cases, kind):
            exact, found = case.exact, model.attributes
            if exact is None or f"{name}_mean" not in model or "hurst" not in found:
                continue
            k = _place_of_one_percent(exact)
            if k is None or not np.array_equal(model["pressure"], exact["pressure"]):
                why = f"no pressure has an exact A/A₀ between {_AROUND[0]} and {_AROUND[1]}"
                yield _not_tested(case, model, words, why)
                continue
            mean, error = float(model[f"{name}_mean"][k]), float(model[f"{name}_sem"][k])
            count = n_random(model)
            estimate = Estimate(mean, error, mean - error, mean + error, 1.0, count=count)
            target = expected(float(found["hurst"]))
            note = f"{target:.2f} expected; at p = {float(model['pressure'][k]):.2g} E*"
            yield _taken(case, model, words, estimate, near(target, 0.2), note=note)

    return measure


_AROUND = (0.003, 0.03)


def _place_of_one_percent(exact: ModelResult) -> int | None:
    """Return the pressure at which A/A0 is nearest to 1 %, within a factor of three."""
    area = np.asarray(exact["area_mean"], float)
    close = (area >= _AROUND[0]) & (area <= _AROUND[1])
    if not close.any():
        return None
    distance = np.abs(np.log(np.where(close, area, math.nan) / 0.01))
    return int(np.nanargmin(distance))


def _ratio(a: Estimate, b: Estimate) -> Estimate:
    """Return a/b of two estimates; their errors are taken as independent."""
    if not (math.isfinite(a.value) and math.isfinite(b.value)):
        return MISSING
    count = min((x.count for x in (a, b) if x.count), default=0)
    value = a.value / b.value
    parts = [x.error / x.value if x.count else 0.0 for x in (a, b)]
    error = value * math.hypot(*parts) if count else math.nan
    share = min(a.share, b.share)
    return Estimate(value, error, value - error, value + error, share, count=count)


# -- the claims --------------------------------------------------------------------------

_ALONE = "any spec with bem, at pressures from 1e-6 to 0.1"
_WITH = "a spec with bem and {}"
_PLATEAU = "width of the range on which d ln K/d ln p, over two pressures, is 1 ± 0.15,"
_FOLLOWS = f"at most {FOLLOWS:g} (fails from {ANOTHER:g} on)"
_ANOTHER = f"at least {ANOTHER:g} (fails up to {FOLLOWS:g})"


def _within(name: str, wanted: str) -> str:
    law = "A ∼ p" if name == "area" else "K ∼ p"
    unit = "" if name == "area" else ", each with the rms height of its own surfaces,"
    return (
        f"factor between the model's {_SYMBOLS[name]} and the exact one{unit} where the exact "
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
        f"exact κ: 2 ± 0.2, for q₁ ≥ {MANY_SCALES:g} q_r",
        _ALONE,
        _kappa,
    ),
    Claim(
        "area-rolloff",
        "Fig. 3(a)",
        "The contact area does not depend on the roll-off.",
        "ratio of the exact κ of surfaces that differ in q_r alone: 1 ± 0.1, for "
        f"q₁ ≥ {MANY_SCALES:g} q_r",
        "a spec with bem and sweep: {surface.qr: [1.0, 8.0]}",
        _kappa_by_rolloff,
    ),
    Claim(
        "area-persson",
        "Fig. 3(a)",
        "Persson's theory describes the contact area.",
        _within("area", _FOLLOWS),
        _WITH.format("persson"),
        _factor(_TO_FOLLOW, "area", "persson"),
    ),
    Claim(
        "area-foundation",
        "abstract, Fig. 3(a)",
        "The one-dimensional foundation is far off in the contact area.",
        _within("area", _ANOTHER),
        _WITH.format("foundation"),
        _factor(_TO_DIFFER, "area", "foundation"),
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
        "eqs. (2), (3)",
        "The mean separation falls with the logarithm of the pressure, ū = u₀ ln(p₀/p), so "
        "that the stiffness is proportional to it, K = p/u₀.",
        f"{_PLATEAU} of the exact solution: at least 1 decade",
        _ALONE,
        _law("reference", ("plateau_decades", "decades of slope 1", at_least(1.0), "≥")),
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
        _within("separation", _FOLLOWS),
        _WITH.format("persson"),
        _factor(_TO_FOLLOW, "separation", "persson"),
    ),
    Claim(
        "separation-foundation",
        "abstract, Fig. 3(b)",
        "The one-dimensional foundation is far off in the mean separation.",
        _within("separation", _ANOTHER),
        _WITH.format("foundation"),
        _factor(_TO_DIFFER, "separation", "foundation"),
    ),
    Claim(
        "three-regions",
        "Fig. 4",
        "The stiffness has three regions: K ∼ p^(1/(1+H)) where a few contacts carry all, "
        "K ∼ p, and a steep rise to full contact.",
        "exact exponent at the lowest pressures 1/(1+H) ± 0.05; at least 1 decade of "
        "d ln K/d ln p within 1 ± 0.15; slope above it at least 1.5",
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
        "There K h_rms/E* ≈ (h_rms/(L²q_r))^(H/(1+H)) (p/E*)^(1/(1+H)): the prefactor θ is "
        "about one.",
        f"exact θ, with the rms height of the realized surfaces: 1 within a factor {FOLLOWS:g}",
        "a spec with bem, at pressures from 1e-7 and a large q1/q0",
        _law("reference", ("theta_realized", "θ", about(1.0, FOLLOWS), "")),
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
        f"{_PLATEAU} of the foundation: at most 1 decade",
        _WITH.format("foundation"),
        _law("foundation", ("plateau_decades", "decades of slope 1", at_most(1.0), "≥")),
    ),
    Claim(
        "stiffness-foundation",
        "Fig. 4",
        "The one-dimensional foundation is far off in the stiffness.",
        _within("stiffness", _ANOTHER),
        _WITH.format("foundation"),
        _factor(_TO_DIFFER, "stiffness", "foundation"),
    ),
    Claim(
        "stiffness-persson",
        "Fig. 4",
        "Persson's theory describes the stiffness.",
        _within("stiffness", _FOLLOWS),
        _WITH.format("persson"),
        _factor(_TO_FOLLOW, "stiffness", "persson"),
    ),
    *(
        Claim(
            f"coupling-{name}",
            "abstract; the test is ours",
            "The foundation fails because it neglects the long-range elastic coupling: "
            f"springs without coupling are off in {words} on the surface itself as well.",
            f"Winkler’s independent springs, under the surface: {_within(name, _ANOTHER)}",
            _WITH.format("winkler"),
            _factor(_TO_DIFFER, name, "winkler"),
        )
        for name, words in _WORDS.items()
    ),
    *(
        Claim(
            f"dimension-{name}",
            "discussion; the test is ours",
            "The reduced dimension is not the problem: a line with elastic coupling follows "
            f"the surface in {words}.",
            f"the exact solution of a line: {_within(name, _FOLLOWS)}",
            _WITH.format("line"),
            _factor(_TO_FOLLOW, name, "line"),
        )
        for name, words in _WORDS.items()
    ),
    Claim(
        "below-rolloff",
        "Fig. 2",
        "Whether the spectrum is flat or zero below the roll-off hardly matters.",
        "factor between the exact curves of both, each with the rms height of its own "
        "surfaces, where A ∼ p or K ∼ p: at most 1.2",
        "a spec with bem and sweep: {surface.below_qr: [rolloff, cutoff]}",
        _below_rolloff,
    ),
    Claim(
        "stress-correlation",
        "discussion",
        "With elastic coupling the stress is correlated as q^−(1+H).",
        "exponent of the exact stress spectrum where A/A₀ is about 1 %: −(1+H) ± 0.2",
        _WITH.format("observables: [stress_spectrum]"),
        _correlation("reference", "stress_spectrum", lambda h: -(1.0 + h), "−(1+H)"),
    ),
    Claim(
        "overlap-correlation",
        "discussion",
        "Without coupling, where the bodies overlap, the contact is correlated as q^−(2+H).",
        "exponent of the contact spectrum of Winkler’s springs where the exact A/A₀ is about "
        "1 %: −(2+H) ± 0.2",
        _WITH.format("winkler and observables: [contact_spectrum]"),
        _correlation("winkler", "contact_spectrum", lambda h: -(2.0 + h), "−(2+H)"),
    ),
    Claim(
        "overlap-stress",
        "beyond the paper",
        "The stress of independent springs is correlated as q^−(2+2H).",
        "exponent of the stress spectrum of Winkler’s springs where the exact A/A₀ is about "
        "1 %: −(2+2H) ± 0.2",
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
        _within("area", _ANOTHER),
        _WITH.format("gw or gw_elliptic"),
        _factor(_TO_DIFFER, "area", "gw", "gw_elliptic"),
    ),
)
"""In the order of the paper's quantities: area, separation, stiffness, the reasons."""
