"""Claims on decades, heights and the onset, on synthetic curves whose answer is known."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.results import ModelResult, Results
from roughbench.verdict import Outcome, Verdict, judge
from roughbench.verdict.onset import DEVIATES, theory_of
from tests.fits.lawful import HEIGHT, SHARE, SLOPE, U0, P, finite_size, lawful, make

H, F, N = Outcome.HOLDS, Outcome.FAILS, Outcome.NOT_TESTED
D = Outcome.DEPENDS
SURFACE = {"q_min": 1.0, "below_rolloff": "rolloff", "seed": 1, "amplitude": "fixed"}
SCATTER = np.array([-0.02, -0.01, 0.0, 0.01, 0.02])
FloatArray = NDArray[np.float64]


def model(values: dict[str, FloatArray], kind: str, **more: Any) -> ModelResult:
    attributes: dict[str, Any] = SURFACE | more
    return make(values, kind, **attributes)


def judged(**experiments: ModelResult) -> dict[str, Verdict]:
    held = {name: {one.label: one} for name, one in experiments.items()}
    found = judge([("one.h5", Results(held, "no spec", ""))], resamples=40)
    return {verdict.key: verdict for verdict in found}


# Decades of the theory ----------------------------------------------------------------------


def theory(drift: float, **more: Any) -> ModelResult:
    """K/p that changes by a factor over every three decades, of a theory without scatter."""
    stiffness = P / U0 * drift ** (np.log10(P) / 3.0)
    known: dict[str, Any] = {"q_max": 8192.0, **more}
    made = model({"stiffness": stiffness[None, :]}, "persson", **known)
    attributes = {k: v for k, v in made.attributes.items() if k != "grid_points"}
    return replace(made, attributes=attributes)


@pytest.mark.parametrize(
    ("drift", "outcome"),
    [(1.0, H), (1.1, H), (1.19, H), (1.21, F), (1.5, F)],
)
def test_three_decades_of_the_theory_end_with_its_drift(drift: float, outcome: Outcome) -> None:
    for change in (drift, 1.0 / drift):
        found = judged(main=theory(change))["theory-decades"]
        [measured] = found.measurements
        assert measured.value == pytest.approx(drift, rel=1e-3)
        assert found.outcome == outcome


def test_the_decades_of_the_theory_are_claimed_at_the_papers_size_only() -> None:
    small = judged(main=theory(1.0, q_max=512.0))["theory-decades"]
    assert small.outcome == N
    assert small.measurements[0].note == "q₁ is not the paper's 8192 q₀"
    assert judged(main=theory(1.0, q_rolloff=1.0))["theory-decades"].measurements == ()


def labelled(label: str, drift: float, **more: Any) -> ModelResult:
    return replace(theory(drift, **more), label=label)


def test_a_theory_counts_once_however_often_it_is_there() -> None:
    """In two experiments and under two labels; a second γ of the paper's range is another."""
    held = {
        "a": {one.label: one for one in (labelled("persson", 1.1), labelled("again", 1.1))},
        "b": {"persson": labelled("persson", 1.1, seed=7, amplitude="gaussian")},
        "c": {"steep": labelled("steep", 1.5, gamma=0.5)},
    }
    found = judge([("one.h5", Results(held, "no spec", ""))], resamples=2)
    [verdict] = [one for one in found if one.key == "theory-decades"]
    once, steep = verdict.measurements
    assert (once.where, once.outcome) == ("a/persson", H)
    assert once.note == "the same theory as a/again, b/persson, counted once"
    assert (steep.where, steep.outcome, steep.note) == ("c/steep", F, "")
    assert verdict.outcome == D


def test_a_theory_with_other_options_than_the_papers_does_not_decide() -> None:
    fitted = labelled("fitted", 1.5, gamma=0.33, finite_size="blend", theta=2.3)
    held = {"main": {"fitted": fitted, "persson": labelled("persson", 1.1, gamma=0.45)}}
    found = judge([("one.h5", Results(held, "no spec", ""))], resamples=2)
    [verdict] = [one for one in found if one.key == "theory-decades"]
    [measured] = verdict.measurements
    assert (measured.where, verdict.outcome) == ("main/persson", H)
    assert measured.note == "not counted, with other options than the paper's: main/fitted"
    alone = judged(main=fitted)["theory-decades"]
    assert alone.outcome == N
    assert "fig4.yaml" in alone.remedy


# Heights of few contacts --------------------------------------------------------------------


def high(times: float, power: float) -> ModelResult:
    """Surfaces so many times as high, whose θ of eq. (10) goes as this power of the height."""
    values = lawful(SCATTER)
    height = HEIGHT * times
    few = finite_size(P) * times ** (power + (1.0 - SHARE) - 1.0)
    values["stiffness"] = np.maximum(P / (U0 * times), few) * (1.0 + SCATTER[:, None])
    made = model(values, "bem", rms_height=height, rms_slope=SLOPE * times)
    heights = {"rms_height": np.full(SCATTER.size, height)}
    return replace(made, variables={**made.variables, **heights})


@pytest.mark.parametrize(("power", "outcome"), [(0.0, H), (0.3, F), (-0.3, F)])
def test_the_finite_size_law_scales_with_the_height(power: float, outcome: Outcome) -> None:
    """Eq. (10) at fixed q_r and L: K ∼ h^(H/(1+H) - 1) p^(1/(1+H)), and θ left as h^power."""
    found = judged(**{f"h{k:g}": high(k, power) for k in (1.0, 2.0, 4.0)})
    [measured] = found["finite-size-height"].measurements
    assert measured.value == pytest.approx(power, abs=0.01)
    assert found["finite-size-height"].outcome == outcome


def test_surfaces_of_one_height_say_nothing_of_it() -> None:
    found = judged(a=high(1.0, 0.0), b=model(lawful(SCATTER), "bem", q_rolloff=2.0))
    assert found["finite-size-height"].outcome == N


# Onset of the deviation ---------------------------------------------------------------------

PAPERS = {"q_max": 8192.0, "q_rolloff": 1.0}


def foundation(onset: float, scatter: FloatArray, **more: Any) -> ModelResult:
    """K of the theory, which starts to deviate at so many times the start of its K ∼ p.

    Its two laws are joined with m = 4: at the corner 9 % from the larger of them, 16 % from the
    root of their squares, so that by itself it deviates from neither by a fifth.
    """
    known = PAPERS | more
    bare = model({"area": np.ones((1, P.size))}, "foundation", **known)
    laws = theory_of(bare, 0.45)
    assert laws is not None
    linear = math.exp(np.interp(0.0, np.log(laws.bulk / (2.0 * laws.few)), np.log(P)))
    place = onset * linear / DEVIATES
    stiffness = laws.stiffness(2.0, 4.0) * np.maximum(P / place, 1.0)
    values = {"stiffness": stiffness * (1.0 + scatter[:, None])}
    return model(values, "foundation", **known)


@pytest.mark.parametrize(("place", "outcome"), [(1.0, H), (20.0, F), (0.3, F)])
def test_the_foundation_deviates_where_the_theory_becomes_linear(
    place: float, outcome: Outcome
) -> None:
    found = judged(main=foundation(place, SCATTER))["onset-foundation"]
    assert len(found.measurements) == 2  # two ways to join the laws
    for measured in found.measurements:
        assert measured.value == pytest.approx(place, rel=0.25)
        assert 0.0 < measured.error < 0.2 * measured.value
        assert measured.outcome == outcome
    assert found.outcome == outcome


def test_the_onset_is_decided_for_each_roll_off() -> None:
    one, eight = foundation(1.0, SCATTER), foundation(20.0, SCATTER, q_rolloff=8.0)
    found = judged(a=one, b=eight)["onset-foundation"]
    cases = {case.case: case.outcome for case in found.cases}
    assert cases == {"without roll-off": H, "with roll-off": F}
    assert found.outcome == D


def test_a_foundation_of_another_modulus_is_not_the_papers() -> None:
    other = foundation(1.0, SCATTER, modulus="matched")
    assert judged(main=other)["onset-foundation"].measurements == ()
    assert judged(main=foundation(1.0, SCATTER, q_max=1e9))["onset-foundation"].outcome == H
