"""Made-up contenders with known deviations, judged as any other model is."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

from roughbench.fits import Estimate
from roughbench.results import ModelResult, Results
from roughbench.verdict import Outcome, Verdict, judge
from roughbench.verdict.trust import end_text
from tests.fits.lawful import P, make
from tests.fits.test_comparisons import SCATTER, exact_curves, ratio, where_it_is, without

KIND = "mytheory.py:Erf09"


def contender(
    area: float | np.ndarray = 1.0, stiffness: float = 1.0, label: str = "", kind: str = KIND
) -> ModelResult:
    """Return a model whose area and stiffness are off by these factors."""
    values = exact_curves(scatter=SCATTER)
    values["area"], values["stiffness"] = values["area"] * area, values["stiffness"] * stiffness
    result = make(values, kind, label)
    return ModelResult(result.label, kind, "Erf 0.9", result.attributes, result.variables)


def exact() -> ModelResult:
    return make(exact_curves(scatter=SCATTER))


def judged(*models: ModelResult, reference: str | None = None) -> list[Verdict]:
    results = Results({"main": {m.label: m for m in models}}, "no spec", "")
    verdicts = judge([("one.h5", results)], reference=reference, resamples=50)
    return [verdict for verdict in verdicts if verdict.contender]


def test_every_model_but_the_exact_one_is_judged_once() -> None:
    found = judged(exact(), contender(label="erf"), contender(kind="persson"))
    assert [verdict.contender for verdict in found] == ["erf", "persson"]
    assert [verdict.key for verdict in found] == [f"contender-{KIND}-erf", "contender-persson"]
    for verdict in found:
        assert verdict.claim == "Erf 0.9 follows the exact solution."
        assert verdict.rule.endswith("at most 1.5 (fails from 2 on)")
        assert verdict.outcome == Outcome.HOLDS
        assert [m.what for m in verdict.measurements] == [
            "factor in A/A₀",
            "factor in ū/h_rms",
            "factor in K h_rms",
            "factor in A/A₀ at equal ū/h_rms",
            "factor in K h_rms at equal ū/h_rms",
            "factor in p at equal ū/h_rms",
        ]


@pytest.mark.parametrize(
    ("factor", "outcome"),
    [
        (1.3, Outcome.HOLDS),
        (1 / 1.3, Outcome.HOLDS),
        (1.75, Outcome.UNDECIDED),
        (2.5, Outcome.FAILS),
        (1 / 2.5, Outcome.FAILS),
    ],
)
def test_the_factor_decides(factor: float, outcome: Outcome) -> None:
    [verdict] = judged(exact(), contender(stiffness=factor))
    assert verdict.outcome == outcome
    of_stiffness = [m for m in verdict.measurements if "K h_rms" in m.what]
    assert len(of_stiffness) == 2
    for measured in of_stiffness:
        assert measured.value == pytest.approx(max(factor, 1 / factor))
        assert measured.outcome == outcome


@pytest.mark.parametrize(
    ("factor", "outcome"), [(1.3, Outcome.HOLDS), (0.2, Outcome.FAILS), (3.0, Outcome.FAILS)]
)
def test_the_pressure_at_equal_separation_decides_too(factor: float, outcome: Outcome) -> None:
    """ū = u0 ln(p0 c/p) for c times the pressure: a tenth more of ū, whatever c."""
    values = exact_curves(scatter=SCATTER)
    base = np.maximum(values["separation"], 0.0)
    moved = exact_curves(scatter=SCATTER)
    slope = (base[:, :1] - base[:, 1:2]) / math.log(P[1] / P[0])
    moved["separation"] = np.where(base > 0, base + slope * math.log(factor), base)
    [verdict] = judged(make(values), make(moved, KIND))
    measured = verdict.measurements[-1]
    assert measured.value == pytest.approx(max(factor, 1 / factor), rel=0.1)
    assert measured.outcome == outcome
    assert "times the exact p at ū/h_rms = " in measured.note
    assert verdict.outcome == outcome


def test_a_verdict_says_where_a_known_deviation_ends() -> None:
    """area = exact × (1 + ε(p)), with an error from a scatter that is the contender's own."""
    theirs = make(exact_curves(scatter=np.zeros(5)))
    [verdict] = judged(theirs, contender(area=ratio(0.15)))
    for measured in verdict.measurements[0], verdict.measurements[3]:
        ten, fifty = measured.ranges
        assert (ten.percent, fifty.percent) == (10, 50)
        for one in measured.ranges:
            part = one.percent / 100
            assert one.start.value == pytest.approx(where_it_is(1 - part, 0.15), rel=1e-9)
            assert one.end.value == pytest.approx(where_it_is(1 + part, 0.15), rel=1e-9)
            assert 0 < one.start.error < 0.2 * one.start.value
        low, high = where_it_is(0.9, 0.15), where_it_is(1.1, 0.15)
        ends = re.findall(r"[(]([\d.]+) ?[(±][^)]*[)]*·10(\S+) E", measured.note)
        powers = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
        values = [float(f"{one}e{power.translate(powers)}") for one, power in ends]
        assert values[:2] == pytest.approx([low, high], rel=0.02)
        assert measured.error > 0
    same = verdict.measurements[1]
    assert same.note == (
        "within 10 % from the first pressure to the last; "
        "within 50 % from the first pressure to the last"
    )


def test_an_end_with_a_wide_error_has_its_interval() -> None:
    """It read (1.4·10⁻⁵ ± 2·10⁻⁵) E*, and of no error (0.28 ± 0) E*."""
    wide = Estimate(1.4e-5, 2.4e-5, 1.3e-5, 6.1e-5, 1.0)
    assert end_text(wide) == "1.4·10⁻⁵ E* (68 %: 1.3·10⁻⁵ to 6.1·10⁻⁵)"
    assert end_text(Estimate(0.28, 0.0, 0.28, 0.28, 1.0)) == "0.28 E*"


def test_a_model_with_an_area_alone_is_judged_on_that() -> None:
    bare = without(contender(area=1.2), "separation", "stiffness")
    [verdict] = judged(exact(), bare)
    assert verdict.outcome == Outcome.HOLDS
    area, separation, stiffness, at_separation = verdict.measurements
    assert area.value == pytest.approx(1.2)
    for measured in separation, stiffness, at_separation:
        assert measured.note == "not given"
        assert measured.outcome == Outcome.NOT_TESTED
        assert math.isnan(measured.value)
    assert at_separation.what == "factor in A/A₀ at equal ū/h_rms"


def test_the_papers_claims_do_not_break_on_what_is_not_given() -> None:
    """A foundation without separation and stiffness: what rests on them is not tested."""
    values = make(exact_curves(scatter=SCATTER), "foundation")
    bare = without(values, "separation", "stiffness")
    results = Results({"main": {"bem": exact(), "foundation": bare}}, "no spec", "")
    found = {v.key: v for v in judge([("one.h5", results)], resamples=20)}
    assert found["area-foundation"].outcome == Outcome.FAILS  # its area is the exact one
    for key in ("separation-foundation", "stiffness-foundation", "finite-size-foundation"):
        assert found[key].outcome == Outcome.NOT_TESTED
        assert [measured.note for measured in found[key].measurements] == ["not given"]


def test_neither_exact_solution_nor_contender_need_give_more_than_an_area() -> None:
    sources = []
    for scale, below in ((1.0, "rolloff"), (2.0, "rolloff"), (1.0, "cutoff")):
        more: dict[str, Any] = {"q_min": 1.0, "seed": 1, "amplitude": "fixed"}
        more |= {"below_rolloff": below, "length": scale, "grid_points": 512 * scale}
        values = exact_curves(scatter=SCATTER)
        models = [make(values, kind, **more) for kind in ("bem", "foundation", "winkler")]
        models[0] = without(models[0], *("separation", "stiffness") * (scale == 1.0))
        models[1] = without(models[1], "separation", "stiffness")
        models[2] = without(models[2], "area")
        for statistic in ("mean", "sem"):
            name = f"stress_spectrum_exponent_{statistic}"
            models[2].variables[name] = P  # type: ignore[index]
        experiment = {"main": {one.label: one for one in models}}
        sources.append((f"{scale:g}-{below}.h5", Results(experiment, "no spec", "")))
    for reference, linear, size in (
        (None, Outcome.HOLDS, Outcome.NOT_TESTED),
        ("foundation", Outcome.HOLDS, Outcome.NOT_TESTED),
        ("winkler", Outcome.NOT_TESTED, Outcome.HOLDS),  # which gives all but the area
    ):
        found = {v.key: v for v in judge(sources, reference=reference, resamples=10)}
        assert found["area-linear"].outcome == linear
        assert found["size-exact"].outcome == size
        assert found["stress-correlation"].outcome == Outcome.NOT_TESTED
    assert {m.note for m in found["kappa"].measurements} == {"not given"}


def test_other_pressures_leave_the_comparison_at_equal_separation() -> None:
    other = contender(stiffness=1.2)
    other.variables["pressure"] = P * 1.01  # type: ignore[index]
    [verdict] = judged(exact(), other)
    notes = [measured.note for measured in verdict.measurements]
    assert notes[:3] == ["its pressures are not those of the exact solution"] * 3
    assert verdict.measurements[4].value == pytest.approx(1.2)
    assert verdict.outcome == Outcome.HOLDS


def test_without_an_exact_solution_nothing_is_tested() -> None:
    [verdict] = judged(contender())
    assert verdict.outcome == Outcome.NOT_TESTED
    assert verdict.measurements == ()
    assert verdict.remedy == "a spec with bem"
    [other] = judged(contender(label="one"), contender(label="two"), reference="one")
    assert (other.contender, other.outcome) == ("two", Outcome.HOLDS)


def test_without_a_region_the_ranges_remain() -> None:
    """Exact curves without A ∼ p or K ∼ p: no factor, but where the contender agrees."""
    values = {
        "area": 0.5 * (P / P[-1])[None, :] ** 0.3 * np.ones((2, 1)),
        "separation": -np.log(P)[None, :] * np.ones((2, 1)),
        "stiffness": P[None, :] ** 3 * np.ones((2, 1)),
    }
    [verdict] = judged(make(values), make(values, KIND))
    assert verdict.outcome == Outcome.NOT_TESTED
    assert verdict.remedy == "a spec with bem, at pressures where it has A ∼ p or K ∼ p"
    *ranges, pressures = verdict.measurements
    assert pressures.what == "factor in p at equal ū/h_rms"
    for measured in ranges:
        compared = " compared" * ("at equal" in measured.what)
        assert measured.note.startswith(f"within 10 % from the first pressure{compared} to the")
    for measured in verdict.measurements:
        assert "no factor: the exact solution has no region" in measured.note
        assert math.isnan(measured.value)
