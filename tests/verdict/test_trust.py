"""Where a contender can be trusted: made-up deviations, said in words."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from roughbench.numbers import number
from roughbench.results import ModelResult, Results
from roughbench.verdict import ContenderTrust, Trust, fit_experiments, trust_of
from roughbench.verdict.trust import choose_pressures
from tests.fits.lawful import P, make
from tests.fits.test_comparisons import SCATTER, exact_curves, ratio, where_it_is, without

Values = dict[str, np.ndarray]


def trusted(*models: ModelResult, reference: str | None = None) -> list[ContenderTrust]:
    results = Results({"main": {m.label: m for m in models}}, "no spec", "")
    return trust_of(fit_experiments([("one.h5", results)], reference, 50))


def contender(scatter: np.ndarray = SCATTER, **factors: Any) -> ModelResult:
    values = exact_curves(scatter=scatter)
    for name, factor in factors.items():
        values[name] = values[name] * factor
    return make(values, "erf09")


def by_name(found: ContenderTrust) -> dict[str, Trust]:
    return {one.quantity.name: one for one in found.quantities}


def test_the_range_is_that_of_the_fits_and_has_its_error() -> None:
    [found] = trusted(make(exact_curves(scatter=np.zeros(5))), contender(area=ratio(0.15)))
    area = by_name(found)["area"]
    low, high = where_it_is(0.9, 0.15), where_it_is(1.1, 0.15)
    assert area.found is not None
    assert area.found.start.value == pytest.approx(low, rel=1e-9)
    assert area.found.end.value == pytest.approx(high, rel=1e-9)
    assert area.range_text.startswith(
        f"within 10 % of the exact contact area from ({low * 1e6:.1f} ± "
    )
    assert f")·10⁻⁶ E* to ({high * 1e5:.1f} ± " in area.range_text


def test_a_deviation_is_that_of_the_means_with_an_error_of_the_scatter() -> None:
    """−32 % of each surface ± 2 %: the error of the mean of five is known."""
    [found] = trusted(make(exact_curves(scatter=np.zeros(5))), contender(area=0.68))
    area = by_name(found)["area"]
    expected = 0.68 * float(np.std(SCATTER, ddof=1)) / math.sqrt(5)
    for one in area.deviations:
        assert one.estimate.value == pytest.approx(-0.32, rel=1e-9)
        assert one.estimate.error == pytest.approx(expected, rel=0.35)
        assert one.text.startswith("−32.0 ± 0.")
    assert area.range_text == "nowhere within 10 % of the exact contact area"
    first = area.deviations[0]
    assert f"; at p = 10⁻¹⁰ E* {first.text}, at p = 10⁻⁹ E* " in area.sentence


def test_a_scatter_of_both_is_none_of_their_ratio() -> None:
    [found] = trusted(make(exact_curves(scatter=SCATTER)), contender(area=0.68))
    assert {one.text for one in by_name(found)["area"].deviations} == {"−32 %"}


@pytest.mark.parametrize(
    ("factor", "text"),
    [(1.0, "0 %"), (1.05, "+5 %"), (0.07, "−93 %"), (2.9, "+190 %"), (14.0, "14 times")],
)
def test_a_deviation_in_words(factor: float, text: str) -> None:
    [found] = trusted(make(exact_curves()), contender(np.zeros(2), area=factor))
    assert {one.text for one in by_name(found)["area"].deviations} == {text}


def test_a_model_that_agrees_everywhere_says_which_pressures_that_is() -> None:
    [found] = trusted(make(exact_curves()), contender(np.zeros(2), separation=1.01))
    assert by_name(found)["separation"].range_text == (
        "within 10 % of the exact mean separation from 10⁻¹⁰ E* to 0.1 E*, "
        "the lowest pressure to the highest"
    )
    values = exact_curves()
    values["area"] = np.minimum(values["area"] * 5.0, 1.0)
    [found] = trusted(make(values), make(values, "erf09"))
    last = P[values["area"][0] <= 0.9][-1]
    assert by_name(found)["area"].range_text.endswith(
        f"to {number(last, 2)} E*, the lowest pressure to the highest with A/A₀ ≤ 0.9"
    )


def test_one_decade_has_one_pressure_and_few_are_all_shown() -> None:
    chosen = P[choose_pressures(P)]
    assert np.abs(np.log10(chosen) - np.round(np.log10(chosen))).max() < 0.1
    assert np.round(np.log10(chosen)).tolist() == list(range(-10, 0))
    assert choose_pressures(np.array([0.01, 0.02, 0.05])) == [0, 1, 2]


def test_full_contact_of_both_is_agreement_and_of_one_is_none() -> None:
    exact, values = exact_curves(), exact_curves()
    exact["stiffness"][:, -1] = values["stiffness"][:, -1] = math.inf
    values["stiffness"][:, 0] = math.inf
    [found] = trusted(make(exact), make(values, "erf09"))
    stiffness = by_name(found)["stiffness"].deviations
    assert [one.text for one in stiffness] == ["infinite", *["0 %"] * (len(stiffness) - 1)]


def test_what_is_not_given_or_cannot_be_compared_says_so() -> None:
    [found] = trusted(make(exact_curves()), without(contender(np.zeros(2)), "stiffness"))
    assert by_name(found)["stiffness"].sentence == "not given"
    other = make(exact_curves(1.5 * P), "erf09")
    other.variables["pressure"] = 1.5 * P  # type: ignore[index]
    [found] = trusted(make(exact_curves()), other)
    assert by_name(found)["area"].sentence == (
        "not compared: its pressures are not those of the exact solution"
    )
    assert trusted(contender()) == []


@pytest.mark.parametrize(
    ("model", "exact", "basis"),
    [
        (
            {"n": 20, "dimension": 1},
            {"n": 5},
            "20 lines, against the exact solution of 5 surfaces; ± is one standard error",
        ),
        (
            {"n": 1, "is_theory": True},
            {"n": 5},
            (
                "from the spectrum alone, against the exact solution of 5 surfaces; "
                "± is one standard error"
            ),
        ),
        (
            {"n": 1, "is_theory": True},
            {"n": 1},
            (
                "from the spectrum alone, against the exact solution of a single surface; "
                "a single surface has no scatter: no errors"
            ),
        ),
        (
            {"n": 1},
            {"n": 1},
            (
                "a single surface, against the exact solution of a single surface; "
                "a single surface has no scatter: no errors"
            ),
        ),
        (
            {"n": 8, "dimension": 1},
            {"n": 1, "surface": "file"},
            (
                "8 lines, against the exact solution of one given surface; "
                "± is the standard error of the model alone"
            ),
        ),
        (
            {"n": 1, "surface": "file"},
            {"n": 1, "surface": "file"},
            (
                "one given surface, against the exact solution of one given surface; "
                "nothing in it is random: no errors"
            ),
        ),
    ],
)
def test_it_says_how_many_surfaces_it_rests_on(
    model: dict[str, Any], exact: dict[str, Any], basis: str
) -> None:
    def made(kind: str, n: int, *, is_theory: bool = False, **attributes: Any) -> ModelResult:
        spread = np.linspace(-0.02, 0.02, n) if n > 1 else np.zeros(1)
        result = make(exact_curves(scatter=spread), kind, **attributes)
        known = {k: v for k, v in result.attributes.items() if k != "grid_points"}
        return ModelResult(
            result.label,
            result.kind,
            result.title,
            known if is_theory else result.attributes,
            result.variables,
        )

    [found] = trusted(made("bem", **exact), made("erf09", **model))
    assert found.basis == basis
    errors = [one.estimate.error for one in by_name(found)["area"].deviations]
    assert all(math.isnan(error) for error in errors) == ("no errors" in basis)


def test_another_reference_is_not_called_exact() -> None:
    persson = make(exact_curves(), "persson")
    [found] = trusted(contender(np.zeros(2)), persson, reference="persson")
    assert by_name(found)["area"].range_text.startswith(
        "within 10 % of the reference’s contact area"
    )
    assert "against persson" in found.basis
