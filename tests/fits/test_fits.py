"""Fits of curves with known laws, and errors that cover the truth."""

from __future__ import annotations

import math

import numpy as np
import pytest

import roughbench as rb
from roughbench.errors import StoreError
from roughbench.fits import fit
from roughbench.fits.comparisons import fit_departures, fit_factor
from roughbench.fits.resampling import draw_counts, estimate, resampled_means
from roughbench.results import ModelResult
from tests.fits.lawful import (
    CROSSING,
    HEIGHT,
    KAPPA,
    LENGTH,
    P0,
    SHARE,
    THETA,
    U0,
    P,
    collect,
    finite_size,
    lawful,
    make,
)


def test_exact_laws_are_found_exactly() -> None:
    found = fit(collect(make(lawful(np.zeros(3)))))["main"]["bem"]
    assert found["kappa"].value == pytest.approx(KAPPA, rel=1e-12)
    assert found["kappa_from"].is_bound
    # From 0.01 to the next pressure A/p falls to half: linear in ln p, past ±10 % on the way.
    assert 0.01 < found["kappa_to"].value < 0.016
    assert found["u0"].value == pytest.approx(U0, rel=1e-9)
    assert found["alpha"].value == pytest.approx(0.4, rel=1e-9)
    assert found["beta"].value == pytest.approx(P0, rel=1e-9)
    assert found["exponent"].value == pytest.approx(SHARE, rel=1e-9)
    assert found["exponent_expected"].value == pytest.approx(SHARE, rel=1e-12)
    assert found["theta"].value == pytest.approx(THETA, rel=1e-9)
    assert found["u0_from_stiffness"].value == pytest.approx(U0, rel=0.1)
    assert found["alpha_realized"].value == pytest.approx(0.4, rel=1e-9)
    assert found["kappa_decades"].is_bound
    assert found["kappa_decades"].value == pytest.approx(
        math.log10(found["kappa_to"].value / P[0]), rel=1e-9
    )
    assert math.isnan(found["exponent_above"].value)  # K ~ p goes on to the end
    assert found["half_contact"].value == pytest.approx(0.05, rel=1e-9)
    # K/p is p/u0 up to the end, and within ± 20 % from where eq. (10) exceeds it by 1.5.
    start = CROSSING / 1.5 ** (1 / (1 - SHARE))
    assert found["log_from"].value == pytest.approx(start, rel=0.2)
    assert found["log_to"].is_bound
    decades = math.log10(P[-1] / found["log_from"].value)
    assert found["log_decades"].value == pytest.approx(decades, rel=1e-9)
    # Equal realizations leave no doubt.
    assert max(x.error for x in found.values() if not math.isnan(x.error)) < 1e-12


def test_contacts_narrower_than_the_shortest_wave_are_left_out() -> None:
    """With q1 so low that a single contact of this K is narrower, nothing is left."""
    values = lawful(np.zeros(2))
    q_max = 2 * math.pi / (LENGTH**2 * float(finite_size(P)[2])) * 1.01
    all_of_it, some, none = (
        fit(collect(make(values, q_max=q)))["main"]["bem"]["exponent"].value
        for q in (1e9, q_max, 1e-3)
    )
    assert all_of_it == pytest.approx(SHARE)
    assert some == pytest.approx(SHARE)
    assert math.isnan(none)


def test_a_law_that_holds_nowhere_is_not_found() -> None:
    values = {
        "area": P[None, :] ** 0.3,
        "separation": -P[None, :],
        "stiffness": P[None, :] ** 3,
    }
    found = fit(collect(make(values)))["main"]["bem"]
    for name in ("kappa", "u0", "log_decades", "exponent", "theta"):
        assert math.isnan(found[name].value), name
        assert found[name].share == 0.0
        assert not found[name].is_bound


def test_surfaces_without_an_exponent_have_no_theta() -> None:
    result = make(lawful(np.zeros(2)))
    known = {k: v for k, v in result.attributes.items() if k not in ("hurst", "q_rolloff")}
    measured = ModelResult("bem", "bem", "bem", known, result.variables)
    found = fit(collect(measured))["main"]["bem"]
    assert "theta" not in found
    assert found["exponent"].value == pytest.approx(SHARE)


# Departures ---------------------------------------------------------------------------------


def test_departures_are_interpolated_between_pressures() -> None:
    """K/K_ref = (p/1e-3)^0.1: within 10 % from 1e-3·0.9^10 to 1e-3·1.1^10."""
    reference = make(lawful(np.zeros(2)))
    values = {name: reference[name].copy() for name in ("area", "separation", "stiffness")}
    values["stiffness"] = values["stiffness"] * (P / 1e-3) ** 0.1
    found = fit(collect(reference, make(values, "winkler")))["main"]["winkler"]
    for percent in (10, 50):
        low, high = 1 - percent / 100, 1 + percent / 100
        lower = found[f"stiffness_agrees_from_{percent}"]
        upper = found[f"stiffness_agrees_to_{percent}"]
        assert lower.value == pytest.approx(max(1e-3 * low**10, P[0]), rel=0.01)
        assert upper.value == pytest.approx(1e-3 * high**10, rel=0.01)
        assert not lower.is_bound
        assert not upper.is_bound
    assert found["separation_agrees_from_10"].is_bound
    assert found["separation_agrees_to_10"].is_bound


def test_zero_and_infinity_end_an_agreement() -> None:
    p = np.array([1e-3, 1e-2, 1e-1])
    one = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, math.inf], [1.0, math.inf, math.inf]])
    other = np.array([[1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, math.inf, math.inf]])
    (_, _), (end, is_bound) = fit_departures(p, one, other, 0.5)
    # s = (r - 1)/(r + 1) falls to -1 or rises to 1: it passes -1/3 and 1/5 on the way.
    np.testing.assert_allclose(end, [10 ** (-2 + 1 / 3), 10 ** (-2 + 1 / 5), 0.1])
    assert is_bound.tolist() == [False, False, True]


def test_areas_near_full_contact_do_not_count() -> None:
    reference = {"area": np.minimum(20 * P, 1.0)[None, :]}
    other = {"area": np.minimum(2000 * P, 1.0)[None, :]}
    both = {"separation": P[None, :], "stiffness": P[None, :]}
    found = fit(collect(make(reference | both), make(other | both, "foundation")))
    # From p = 0.05 on both are in full contact; before, the ratio falls from 100 to 1/0.9.
    end = found["main"]["foundation"]["area_agrees_to_10"]
    assert math.isnan(end.value) or end.value < 0.05


def test_the_reference_can_be_named() -> None:
    one, other = make(lawful(np.zeros(2)), "persson"), make(lawful(np.zeros(2)), "winkler")
    without = fit(collect(one, other))["main"]
    assert not any("agrees" in name for names in without.values() for name in names)
    named = fit(collect(one, other), reference="persson")["main"]
    assert "area_agrees_to_10" in named["winkler"]
    assert "area_agrees_to_10" not in named["persson"]
    with pytest.raises(
        StoreError, match="no model is named 'gw'; choose one of persson, winkler"
    ):
        fit(collect(one, other), reference="gw")
    with pytest.raises(ValueError, match="at least 2 resamples"):
        fit(collect(one), resamples=1)


def test_factors_are_taken_where_the_reference_is_proportional() -> None:
    """A model twice too soft, which doubles its error outside of the regions."""
    lawfully = lawful(np.zeros(2))
    lawfully["separation"] = np.maximum(lawfully["separation"], 1e-3 * HEIGHT)
    reference = make(lawfully)
    found = fit(collect(reference))["main"]["bem"]
    inside = found["log_from"].value * 1.01 < P
    values = {name: reference[name].copy() for name in ("area", "separation", "stiffness")}
    values["stiffness"] = values["stiffness"] / np.where(inside, 2.0, 4.0)
    values["area"] = values["area"] * np.where(found["kappa_to"].value < P, 9.0, 1.25)
    other = fit(collect(reference, make(values, "winkler")))["main"]["winkler"]
    assert other["stiffness_factor"].value == pytest.approx(2.0)
    assert other["area_factor"].value == pytest.approx(1.25)
    assert other["separation_factor"].value == 1.0
    values["separation"][:, P > 0.09] = 0.0
    closed = fit(collect(reference, make(values, "winkler")))["main"]["winkler"]
    assert closed["separation_factor"].value == 1.0  # closed pressures have no factor
    assert closed["separation_closed"].value == (P > 0.09).sum()
    assert other["separation_closed"].value == 0
    values["separation"][:, P[inside][1] < P] = 0.0
    closed = fit(collect(reference, make(values, "winkler")))["main"]["winkler"]
    assert math.isnan(closed["separation_factor"].value)  # fewer than three are open
    assert closed["separation_closed"].value == inside.sum() - 2


def test_lengths_are_compared_in_units_of_the_realized_heights() -> None:
    values = lawful(np.zeros(2))
    values["separation"] = np.maximum(values["separation"], 1e-3 * HEIGHT)
    reference, taller = make(values), make(values, "winkler")
    taller.variables["rms_height"][:] *= 1.4
    found = fit(collect(reference, taller))["main"]["winkler"]
    assert found["separation_factor"].value == pytest.approx(1.4)
    assert found["stiffness_factor"].value == pytest.approx(1.4)
    assert found["area_factor"].value == 1.0


def test_a_region_without_a_value_has_no_factor() -> None:
    p = np.array([1e-3, 1e-2, 1e-1])
    one, other = np.array([[1.0, math.nan, 2.0]]), np.array([[1.0, 1.0, 1.0]])
    ends = (np.log([1e-3]), np.log([1e-1]))
    mixed = np.array([[2.0, 1.0, 0.5]])  # rms of ln 2, 0, -ln 2
    assert fit_factor(p, mixed, other, ends)[0] == pytest.approx(2 ** math.sqrt(2 / 3))
    assert math.isnan(fit_factor(p, one, other, ends)[0])
    assert math.isnan(fit_factor(p, other, other, (np.array([math.nan]), ends[1]))[0])
    assert fit_factor(p, 2 * other, other, ends)[0] == pytest.approx(2.0)
    assert fit_factor(p, other, 2 * other, ends)[0] == pytest.approx(2.0)


def test_half_contact_and_the_rise_to_full_contact_are_found() -> None:
    values = lawful(np.zeros(2))
    values["area"] = np.broadcast_to(np.minimum(10 * P / 0.1, 1.0), values["area"].shape)
    steep = np.where(P > 1e-3, (P / 1e-3) ** 1.5, 1.0)
    values["stiffness"] = values["stiffness"] * steep
    found = fit(collect(make(values)))["main"]["bem"]
    assert found["half_contact"].value == pytest.approx(5e-3, rel=1e-9)
    assert found["exponent_above"].value == pytest.approx(2.5, rel=1e-6)


def test_one_closed_line_is_no_infinite_stiffness_of_the_factor() -> None:
    reference = make(lawful(np.zeros(4)))
    values = lawful(np.zeros(4))
    values["stiffness"][0, P > 1e-3] = math.inf
    found = fit(collect(reference, make(values, "foundation")))["main"]["foundation"]
    assert 1.0 < found["stiffness_factor"].value < 4 / 3


def test_a_plateau_is_where_the_slope_is_one() -> None:
    values = lawful(np.zeros(2))
    # Slope 1.1 from 1e-7 to 1e-4, then 1.3: both within ±20 % of p somewhere.
    slope = np.where(P < 1e-4, (P / 1e-4) ** 0.1, (P / 1e-4) ** 0.3)
    start = np.where(P < 1e-7, (P / 1e-7) ** -0.4, 1.0)
    values["stiffness"] = np.broadcast_to(P * slope * start, values["stiffness"].shape)
    found = fit(collect(make(values)))["main"]["bem"]
    # The slope over two steps turns over two steps, of 0.2 decades each.
    assert found["plateau_decades"].value == pytest.approx(3.0, abs=0.25)
    assert not found["plateau_decades"].is_bound


@pytest.mark.parametrize("pressures", [[0.01], [0.01, 0.02], [0.5, 1.0, 2.0, 4.0]])
def test_few_pressures_or_full_contact_leave_nothing_to_fit(pressures: list[float]) -> None:
    results = rb.run(
        {
            "surface": {"H": 0.7, "q0": 1.0, "q1": 8.0, "slope": 0.1},
            "pressures": pressures,
            "realizations": 2,
            "models": [{"kind": "bem"}, {"kind": "winkler"}, {"kind": "persson"}],
        }
    )
    found = fit(results, resamples=10)["main"]
    assert math.isnan(found["bem"]["kappa"].value)
    assert math.isnan(found["winkler"]["area_factor"].value)


def test_intervals_of_few_realizations_are_wider() -> None:
    drawn = np.concatenate([[0.0], np.linspace(-1.0, 1.0, 101)])
    many, four = estimate(drawn, count=10**6), estimate(drawn, count=4)
    assert many.error == pytest.approx(0.68, rel=1e-3)
    # √(4/3) · t(0.84, 3)/z(0.84) = 1.155 · 1.189/0.994
    assert four.error == pytest.approx(0.68 * 1.155 * 1.189 / 0.994, rel=2e-3)
    assert four.count == 4


@pytest.mark.parametrize(("value", "sign"), [(2.12, 1.0), (-2.12, -1.0), (1.0, 1.0)])
def test_a_value_lies_within_its_interval(value: float, sign: float) -> None:
    """Resamples that all fall short: it was 2.12 (1.34 to 2.03)."""
    drawn = sign * np.linspace(1.3, 2.0, 101)
    found = estimate(np.concatenate([[value], drawn]))
    assert found.low < value < found.high
    low, high = sorted(sign * np.array([1.412, 1.888]))
    bias = sign * 1.65 - value
    # As far on the other side as if the resamples were pulled to it instead.
    assert found.low == pytest.approx(min(low, low - 2 * bias))
    assert found.high == pytest.approx(max(high, high - 2 * bias))
    assert found.error == pytest.approx((found.high - found.low) / 2)


def test_ranges_of_scattering_curves_hold_their_values() -> None:
    """The widest range shrinks with scatter, and resamples scatter more than the data."""
    rng = np.random.default_rng(7)
    values = lawful(np.zeros(8))
    for name in values:
        values[name] = values[name] * np.abs(1 + 0.15 * rng.normal(size=values[name].shape))
    found = fit(collect(make(values)), resamples=200)["main"]["bem"]
    known = [one for one in found.values() if not math.isnan(one.low)]
    assert len(known) > 10
    assert all(one.low <= one.value <= one.high for one in known)


# The bootstrap ------------------------------------------------------------------------------


def test_resampled_means_are_means_of_the_drawn_realizations(rng: np.random.Generator) -> None:
    values = rng.normal(size=(5, P.size)) + 3
    values[2, 3], values[1, 4] = math.inf, math.nan
    status = np.zeros(values.shape, np.int32)
    status[0, :2] = 2
    status[:, 7] = 1
    result = make({"area": values}, status=status)
    counts = draw_counts(5, 40, 0)
    assert counts.shape == (41, 5)
    assert (counts.sum(axis=1) == 5).all()
    found = resampled_means(result, "area", counts)
    for row, drawn in zip(found, counts.astype(int), strict=True):
        kept = np.repeat(np.arange(5), drawn)
        for k in range(P.size):
            column = values[kept, k][status[kept, k] == 0]
            expected = column.mean() if column.size else math.nan
            np.testing.assert_allclose(row[k], expected, rtol=1e-12)


def test_equal_numbers_of_realizations_are_drawn_together() -> None:
    np.testing.assert_array_equal(draw_counts(7, 10, 3), draw_counts(7, 10, 3))
    assert not np.array_equal(draw_counts(7, 10, 3), draw_counts(7, 10, 4))
    assert draw_counts(1, 10, 0).tolist() == [[1.0]]


def test_models_on_the_same_surfaces_share_their_scatter() -> None:
    """A contender that is always 20 % stiffer leaves the reference with no doubt at all."""
    scatter = np.random.default_rng(1).normal(0, 0.2, 12)
    reference = make(lawful(scatter))
    values = {name: reference[name].copy() for name in ("area", "separation", "stiffness")}
    values["stiffness"] = values["stiffness"] * (P / 1e-3) ** 0.1
    found = fit(collect(reference, make(values, "winkler")), resamples=50)["main"]["winkler"]
    assert found["stiffness_agrees_to_10"].error < 1e-12


def test_what_is_positive_keeps_a_positive_interval() -> None:
    """Widened as it stands, from 1e-4 of the value, it would reach below zero."""
    drawn = np.concatenate([[1.0], np.full(50, 1e-4), np.full(50, 1.1)])
    found = estimate(drawn, count=3)
    assert 0.0 < found.low < 1e-4
    assert found.low == pytest.approx(1e-4 ** ((found.high - 1.0) / 0.1))
    signed = estimate(drawn - 1.0, count=3)  # of either sign, it is widened as before
    assert signed.low < -1.0


def test_estimates_say_how_often_they_exist() -> None:
    rare = estimate(np.array([1.0, 2.0, math.nan, math.nan, math.nan]))
    assert (rare.value, rare.share) == (1.0, 0.25)
    assert math.isnan(rare.error)
    single = estimate(np.array([1.0]))
    assert single.share == 1.0
    assert math.isnan(single.error)


def test_errors_cover_the_truth() -> None:
    """60 ensembles of 30 realizations with known laws: 68 % intervals cover 68 %.

    The covered share has the standard error √(0.68·0.32/60) = 0.06 for one number; the
    percentile bootstrap of 30 realizations covers some 2 % less. Required: 3 standard
    errors around 0.66. An error of half the size would cover 38 %, one of double 95 %.
    """
    rng = np.random.default_rng(20131)
    truth = {"kappa": KAPPA, "u0": U0, "beta": P0, "theta": THETA, "exponent": SHARE}
    covered = dict.fromkeys(truth, 0)
    trials = 60
    for _ in range(trials):
        values = lawful(np.zeros(30))
        for name in ("area", "stiffness"):
            # Each realization: its own level and its own tilt over the pressures.
            level, tilt = rng.normal(0, 0.1, (2, 30, 1))
            values[name] = values[name] * (1 + level + 0.2 * tilt * np.log10(P / 1e-4))
        level, tilt = rng.normal(0, 0.1, (2, 30, 1))
        lift = HEIGHT * (level + 0.3 * tilt * np.log(P / 1e-3))
        values["separation"] = values["separation"] + lift
        found = fit(collect(make(values)), resamples=200)["main"]["bem"]
        for name, value in truth.items():
            covered[name] += found[name].low <= value <= found[name].high
    for name, count in covered.items():
        assert 0.66 - 0.18 < count / trials < 0.66 + 0.18, (name, count / trials)


def test_fits_of_a_run_agree_with_the_theory() -> None:
    """Persson's K ~ p region has u0 = α h of the asymptotes."""
    from roughbench.models.persson import persson_asymptotes
    from roughbench.spectrum import self_affine

    results = rb.run(
        {
            "surface": {"H": 0.7, "q0": 1.0, "qr": 8.0, "q1": 512.0, "slope": 0.1},
            "pressures": {"min": 1e-8, "max": 1e-3, "points": 21},
            "models": [{"kind": "persson"}],
        }
    )
    found = fit(results)["main"]["persson"]
    spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=8, q_max=512, rms_slope=0.1)
    expected = persson_asymptotes(spectrum)
    assert found["alpha"].value == pytest.approx(expected.alpha, rel=0.01)
    assert found["beta"].value == pytest.approx(expected.beta, rel=0.1)
    assert found["kappa"].value == pytest.approx(math.sqrt(8 / math.pi), rel=2e-3)
    assert math.isnan(found["alpha"].error)
