"""Claims on energy, scatter, ranges, scaling and fields, on laws that are known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.results import ModelResult, Results
from roughbench.verdict import Outcome, Verdict, judge
from roughbench.verdict.claims import CLAIMS
from roughbench.verdict.fields import distance
from roughbench.verdict.judging import GROUPS
from roughbench.verdict.states import STIFF, stiff_pressure
from tests.fits.lawful import HEIGHT, HURST, LENGTH, SHARE, U0, P, finite_size, lawful, make

H, F, U, N = Outcome.HOLDS, Outcome.FAILS, Outcome.UNDECIDED, Outcome.NOT_TESTED
D = Outcome.DEPENDS
SURFACE = {"q_min": 1.0, "below_rolloff": "rolloff", "seed": 1, "amplitude": "fixed"}
SCATTER = np.array([-0.02, -0.01, 0.0, 0.01, 0.02])
Curves = dict[str, NDArray[np.float64]]


def curves(**changes: Any) -> Curves:
    values = lawful(SCATTER)
    values["separation"] = np.maximum(values["separation"], 1e-3 * HEIGHT)
    values["energy"] = U0 * P * (1.0 + SCATTER[:, None])
    for name, factor in changes.items():
        values[name] = values[name] * factor
    return values


def model(values: Curves, kind: str = "bem", **more: Any) -> ModelResult:
    attributes: dict[str, Any] = SURFACE | more
    return make(values, kind, **attributes)


def judged(*models: ModelResult, **experiments: list[ModelResult]) -> dict[str, Verdict]:
    groups = experiments or {"main": list(models)}
    held = {name: {m.label: m for m in group} for name, group in groups.items()}
    sources = [("one.h5", Results(held, "no spec", ""))]
    return {verdict.key: verdict for verdict in judge(sources, resamples=40)}


def test_every_claim_belongs_to_a_group() -> None:
    assert {claim.group for claim in CLAIMS} == set(GROUPS)
    groups = [claim.group for claim in CLAIMS]
    assert groups == sorted(groups, key=list(GROUPS).index)
    for claim in CLAIMS:
        assert (claim.place == "beyond the paper") == (claim.group == "beyond")


def test_both_readings_of_the_abstract_are_tested() -> None:
    readings = {claim.key: claim.place for claim in CLAIMS if "abstract" in claim.place}
    assert readings["coupling-area"].startswith("abstract of the preprint")
    assert readings["size-foundation"] == "abstract as published"


def test_energy_in_proportion_to_the_pressure() -> None:
    found = judged(model(curves()))
    assert found["energy-linear"].outcome == H
    assert found["energy-height"].outcome == H  # u0 = 0.4 h
    drift, ratio = found["energy-linear"].measurements
    assert drift.value == pytest.approx(1.0)
    assert ratio.value == pytest.approx(1.0, rel=0.05)  # ū ends at 0.04 E*
    # Twice as much after two decades; or half of u0 everywhere; or a tenth of h.
    drifting = judged(model(curves(energy=2.0 ** (np.log10(P) / 2))))["energy-linear"]
    assert drifting.measurements[0].value == pytest.approx(2.0, rel=1e-6)
    assert drifting.outcome == F
    assert judged(model(curves(energy=0.5)))["energy-linear"].outcome == F
    assert judged(model(curves(energy=0.2)))["energy-height"].outcome == F


def test_a_drift_over_two_decades_is_no_logarithm() -> None:
    values = curves(stiffness=3.0 ** np.log10(P))
    found = judged(model(values))["separation-logarithmic"]
    assert found.outcome == F
    assert judged(model(curves()))["separation-logarithmic"].outcome == H


def test_area_and_stiffness_are_linear_together() -> None:
    whole = np.where(P < 0.0101, 1.0, 2.0)  # lawful areas have a step there
    assert judged(model(curves(area=whole)))["same-range"].outcome == H
    start = 3e-5  # K ∼ p up from here, A ∼ p up to here
    area = np.where(start > P, 1.0, (P / start) ** 0.5)
    stiffness = np.where(start > P, (P / start) ** -0.5, 1.0)
    found = judged(model(curves(area=area, stiffness=stiffness)))["same-range"]
    assert found.measurements[0].value < 0.3
    assert found.outcome == F


def wild(at_low: float, n: int = 24) -> Curves:
    """Return curves whose K scatters by 2 % where K ∼ p, and by so much below 1e-8."""
    normal = np.random.default_rng(3).normal(size=(n, 1))
    values = lawful(np.zeros(n))
    values["separation"] = np.maximum(values["separation"], 1e-3 * HEIGHT)
    values["stiffness"] = values["stiffness"] * (1 + normal * np.where(P < 1e-8, at_low, 0.02))
    return values


@pytest.mark.parametrize(("at_low", "outcome"), [(0.2, H), (0.02, F)])
def test_stiffness_fluctuates_at_low_pressure(at_low: float, outcome: Outcome) -> None:
    found = judged(model(wild(at_low)))["fluctuations"]
    assert found.measurements[0].value == pytest.approx(at_low / 0.02, rel=0.02)
    assert found.outcome == outcome
    late = curves(stiffness=np.maximum(finite_size(P) * U0 / P, 1.0) ** -1.0)  # K ∼ p all over
    [measured] = judged(model(late))["fluctuations"].measurements
    assert measured.outcome == N
    assert judged(model(late))["fluctuations"].remedy == "a spec with bem at lower pressures"


def closing(at: float) -> Curves:
    values = curves()
    values["stiffness"] = np.where(at > P, values["stiffness"] / (1 - P / at) ** 3, np.inf)
    return values


def test_a_foundation_that_diverges_earlier() -> None:
    exact, foundation = closing(0.09), closing(0.005)
    found = judged(model(exact), model(foundation, "foundation"))["divergence-foundation"]
    assert found.outcome == H
    assert found.measurements[0].value > 5.0
    same = judged(model(exact), model(exact, "foundation"))["divergence-foundation"]
    assert same.measurements[0].value == pytest.approx(1.0)
    assert same.outcome == F


def test_the_pressure_of_a_stiffness_is_interpolated_to_closed_states() -> None:
    values = curves()
    values["stiffness"] = np.where(P < 1e-3, 1e-9, np.inf) * (1 + 0 * SCATTER[:, None])
    place = stiff_pressure(model(values), 20).value
    before, after = P[P < 1e-3][-1], P[P >= 1e-3][0]
    assert before < place <= after
    assert STIFF == 1.0


STEEP = np.maximum(P / 1e-2, 1.0) ** 2
"""Where the region K ∼ p ends."""


def with_rolloff(rolloff: float, scatter: float = 0.02, theta: float = 1.0) -> Curves:
    """Return curves whose region K ∼ p begins where eq. (10) with this roll-off ends."""
    normal = np.array([-1.5, -1.0, -0.5, 0.0, 0.0, 0.5, 1.0, 1.5])[:, None]
    values = lawful(np.zeros(8))
    values["separation"] = np.maximum(values["separation"], 1e-3 * HEIGHT)
    few = theta * finite_size(P) * (8.0 / rolloff) ** (1 - SHARE)
    values["stiffness"] = np.maximum(P / U0, few) * (1 + scatter * normal) * STEEP
    return values


def test_the_rolloff_widens_the_linear_region() -> None:
    one, eight = (model(with_rolloff(q), q_rolloff=q, label=f"bem{q:g}") for q in (1.0, 8.0))
    found = judged(a=[one], b=[eight])["rolloff-widens"]
    assert found.outcome == H
    wider, earlier = found.measurements
    # The crossing goes as q_r^-1: 0.9 decades earlier.
    assert earlier.value == pytest.approx(1 / 8, rel=0.2)
    assert wider.value == pytest.approx(math.log10(8), rel=0.1)
    swapped = judged(
        a=[model(with_rolloff(8.0), q_rolloff=1.0)], b=[model(with_rolloff(1.0), q_rolloff=8.0)]
    )
    assert swapped["rolloff-widens"].outcome == F


def test_regions_that_begin_before_the_pressures_are_bounds() -> None:
    """One K ∼ p throughout, one from 1e-8 on: it is wider by 0.9 decades at least."""
    linear = with_rolloff(8.0)
    linear["stiffness"] = np.broadcast_to(P / U0 * STEEP, linear["stiffness"].shape)
    one, all_over = model(with_rolloff(1.0), q_rolloff=1.0), model(linear, q_rolloff=8.0)
    found = judged(a=[one], b=[all_over])["rolloff-widens"]
    wider, earlier = found.measurements
    assert (wider.bound, earlier.bound) == ("≥", "≤")
    assert found.outcome == H
    first, second = model(linear, q_rolloff=1.0), model(with_rolloff(1.0), q_rolloff=8.0)
    turned = judged(a=[first], b=[second])
    wider, earlier = turned["rolloff-widens"].measurements
    assert (wider.bound, earlier.bound) == ("≤", "≥")
    assert turned["rolloff-widens"].outcome == F
    both = judged(a=[first], b=[all_over])["rolloff-widens"]
    assert both.outcome == N
    assert both.remedy == "pressures from 1e-7 to 0.1, beyond both ends of K ∼ p"


@pytest.mark.parametrize(("start", "outcome"), [(1.0, H), (30.0, F), (1 / 30, F)])
def test_both_laws_begin_where_many_asperities_touch(start: float, outcome: Outcome) -> None:
    begin = judged(model(curves()))["many-contacts"]
    [measured] = begin.measurements
    assert measured.outcome == F  # A ∼ p all over
    assert measured.bound == "≤"
    crossing = float(P[np.argmax(finite_size(P) * U0 / P < 1.2)])
    area = np.minimum((P / (start * crossing)) ** 0.5, 1.0)
    found = judged(model(curves(area=area)))["many-contacts"]
    assert found.measurements[0].value == pytest.approx(start, rel=0.6)
    assert found.outcome == outcome
    late = curves(stiffness=np.maximum(finite_size(P) * U0 / P, 1.0) ** -1.0)  # K ∼ p all over
    assert judged(model(late))["many-contacts"].remedy == "a spec with bem at lower pressures"


@pytest.mark.parametrize(("power", "outcome"), [(0.0, H), (0.3, F)])
def test_the_finite_size_law_scales(power: float, outcome: Outcome) -> None:
    """θ ∼ q_r^power is what eq. (10) would have missed."""
    models = {
        f"q{q:g}": [model(with_rolloff(q, theta=q**power), q_rolloff=q)]
        for q in (1.0, 2.0, 4.0)
    }
    found = judged(**models)["finite-size-rolloff"]
    [measured] = found.measurements
    assert measured.value == pytest.approx(power, abs=0.01)
    assert found.outcome == outcome
    lengths = {
        f"L{scale:g}": [
            model(
                _longer(scale, power),
                length=LENGTH * scale,
                grid_points=512 * scale,
            )
        ]
        for scale in (1.0, 2.0, 4.0)
    }
    found = judged(**lengths)["finite-size-length"]
    assert found.measurements[0].value == pytest.approx(power, abs=0.01)
    assert found.outcome == outcome


def _longer(scale: float, power: float) -> Curves:
    values = curves()
    few = finite_size(P) * scale ** (power - 2 * (1 - SHARE))
    values["stiffness"] = np.maximum(P / U0, few) * (1 + SCATTER[:, None])
    return values


@pytest.mark.parametrize(("power", "outcome"), [(-1.0, H), (0.0, F)])
def test_repetition_shows_in_the_scatter(power: float, outcome: Outcome) -> None:
    def surfaces(rolloff: float) -> ModelResult:
        values = with_rolloff(rolloff, 0.05 * rolloff**power)
        many = {name: np.repeat(array, 8, axis=0) for name, array in values.items()}
        return model(many, q_rolloff=rolloff)

    found = judged(**{f"q{q:g}": [surfaces(q)] for q in (1.0, 2.0, 4.0, 8.0)})["repetition"]
    [measured] = found.measurements
    assert measured.value == pytest.approx(power, abs=0.05)
    assert 0.0 < measured.error < 0.1
    assert found.outcome == outcome


@pytest.mark.parametrize(("exponent", "outcome"), [(SHARE, H), (1.0, F)])
def test_the_highest_asperity_has_the_exponent_without_coupling(
    exponent: float, outcome: Outcome
) -> None:
    values = curves()
    values["stiffness"] = (P**exponent)[None, :] * (1 + SCATTER[:, None])
    found = judged(model(curves()), model(values, "hertz_top"))["uncoupled-exponent"]
    assert found.measurements[0].value == pytest.approx(exponent)
    assert found.outcome == outcome
    assert HURST == 0.7


def observed(values: NDArray[np.float64], name: str) -> ModelResult:
    """Return the exact solution with a distribution over (realization, pressure, bin)."""
    one = model(curves(area=0.05))  # A/A0 from 1e-10 to 0.05
    return ModelResult("bem", "bem", "bem", one.attributes, {**one.variables, name: values})


@pytest.mark.parametrize(
    ("observable", "key"),
    [("pressure_pdf", "distribution-pressure"), ("clusters", "distribution-patches")],
)
def test_distributions_that_change_with_the_load(observable: str, key: str) -> None:
    bins = np.arange(1.0, 21.0)
    same = np.exp(-bins / 5.0) * P[:, None] * np.ones((5, 1, 1))
    found = judged(observed(same, observable))[key]
    assert found.measurements[0].value == pytest.approx(0.0, abs=1e-12)
    assert found.outcome == H
    wider = np.exp(-bins / (5.0 + 200.0 * P[:, None])) * np.ones((5, 1, 1))
    other = observed(wider, observable)
    found = judged(other)[key]
    assert found.outcome == F
    low, high = (np.cumsum(wider[0, k]) / wider[0, k].sum() for k in (30, 45))
    exact = np.abs(low - high).max()
    assert distance(other, observable, (30, 45), 5).value == pytest.approx(exact)


def test_cases_are_decided_apart() -> None:
    """κ = 2 without, 3 with a roll-off: neither decides for the other."""
    one = model(curves(), q_rolloff=1.0)
    eight = model(curves(area=1.5), q_rolloff=8.0)
    found = judged(a=[one], b=[eight])["kappa"]
    assert {one.case: one.outcome for one in found.cases} == {
        "without roll-off": H,
        "with roll-off": F,
    }
    assert found.outcome == D
    both = judged(a=[one], b=[model(curves(), q_rolloff=8.0)])["kappa"]
    assert both.outcome == H
    again = judged(a=[eight], b=[model(curves(), q_rolloff=4.0)])["kappa"]
    assert [case.outcome for case in again.cases] == [D]


def test_three_decades_are_claimed_at_the_papers_size_only() -> None:
    small = model(curves(), q_max=512.0)
    found = judged(small)["rolloff-decades"]
    assert found.outcome == N
    assert found.measurements[0].note == "q₁ is not the paper's 8192 q₀"
    assert "8192" in found.remedy
    assert judged(model(curves(), q_max=8192.0))["rolloff-decades"].outcome == H
    flat = model(curves(), q_max=8192.0, q_rolloff=1.0)
    assert judged(flat)["rolloff-decades"].measurements == ()


def test_the_remedy_is_what_lacks() -> None:
    narrow = model(curves(), q_max=128.0)
    assert judged(narrow)["kappa"].remedy == (
        "surface.q1 of at least 32 times the largest surface.qr"
    )
    # Both models are there: what lacks is the region, or the same pressures.
    flat = model(curves(area=(P / P[0]) ** -0.5, stiffness=(P / P[0]) ** -0.5))
    found = judged(flat, model(curves(), "persson"))
    for key, law in (("area", "A"), ("separation", "K"), ("stiffness", "K")):
        remedy = found[f"{key}-persson"].remedy
        assert remedy.startswith(f"more pressures where the exact solution has {law} ∼ p")
    other = model(curves(), "persson")
    other.variables["pressure"] = P * 1.01  # type: ignore[index]
    found = judged(model(curves()), other)
    assert found["area-persson"].remedy == "the same pressures for both"
    # No spec that exists has three decades of pressure in K ∼ p at the paper's cut-off.
    small = judged(model(curves(), q_max=512.0))["rolloff-decades"]
    assert "pressures from 1e-6" in small.remedy
    assert "2 or more realizations" in small.remedy
