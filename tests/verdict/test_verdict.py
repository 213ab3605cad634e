"""Claims on synthetic results whose laws are known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.errors import StoreError
from roughbench.results import ModelResult, Results
from roughbench.verdict import Outcome, Verdict, judge
from roughbench.verdict.claims import CLAIMS
from tests.fits.lawful import HEIGHT, LENGTH, U0, P, lawful, make

H, F, U, N = Outcome.HOLDS, Outcome.FAILS, Outcome.UNDECIDED, Outcome.NOT_TESTED
SURFACE = {"q_min": 1.0, "below_rolloff": "rolloff", "seed": 1, "amplitude": "fixed"}
SCATTER = np.array([-0.02, -0.01, 0.0, 0.01, 0.02])
Curves = dict[str, NDArray[np.float64]]


def curves(**changes: Any) -> Curves:
    """Return lawful curves, A, ū and K times the given factors."""
    values = lawful(SCATTER)
    values["separation"] = np.maximum(values["separation"], 1e-3 * HEIGHT)
    for name, factor in changes.items():
        values[name] = values[name] * factor
    return values


def shifted(factor: float, **changes: Any) -> Curves:
    """Return curves that need so many times the pressure for the same mean separation."""
    values = curves(**changes)
    more = lawful(SCATTER)["separation"] + U0 * math.log(factor)
    values["separation"] = np.maximum(more, 1e-3 * HEIGHT)
    return values


def model(values: Curves, kind: str = "bem", **more: Any) -> ModelResult:
    attributes: dict[str, Any] = SURFACE | more
    return make(values, kind, **attributes)


def results(*models: ModelResult) -> Results:
    return Results({"main": {m.label: m for m in models}}, "no spec", "")


def judged(*experiments: Results) -> dict[str, Verdict]:
    sources = [(f"file{k}.h5", one) for k, one in enumerate(experiments)]
    return {verdict.key: verdict for verdict in judge(sources, resamples=50)}


def test_every_claim_is_there_once_with_all_that_a_reader_needs() -> None:
    verdicts = judge([("one", results(model(curves())))], resamples=20)
    assert [verdict.key for verdict in verdicts] == [claim.key for claim in CLAIMS]
    assert not any(verdict.contender for verdict in verdicts)
    assert len({claim.key for claim in CLAIMS}) == len(CLAIMS)
    for verdict in verdicts:
        assert verdict.place
        assert verdict.claim.endswith(".")
        assert verdict.rule
        wanted = verdict.outcome == N or verdict.key == "three-regions"  # its third is missing
        assert bool(verdict.remedy) == wanted


def test_the_exact_laws_hold() -> None:
    found = judged(results(model(curves())))
    assert found["area-linear"].outcome == H
    assert found["kappa"].outcome == H
    assert found["separation-logarithmic"].outcome == H
    assert found["finite-size-exponent"].outcome == H
    assert found["finite-size-prefactor"].outcome == F  # 2.3
    [theta] = found["finite-size-prefactor"].measurements
    assert theta.value == pytest.approx(2.3, rel=0.01)
    assert 0 < theta.error < 0.1
    # The rise to full contact is missing: nothing is said of all three regions.
    assert found["three-regions"].outcome == U


def test_alpha_is_held_against_one() -> None:
    for factor, outcome in ((1.25, H), (0.5, F)):  # 0.5, 0.2
        found = judged(results(model(curves(separation=factor))))["alpha"]
        assert found.outcome == outcome, found.measurements


def test_the_third_region_completes_the_stiffness() -> None:
    steep = np.where(P > 1e-2, (P / 1e-2) ** 2, 1.0)
    assert judged(results(model(curves(stiffness=steep))))["three-regions"].outcome == H


@pytest.mark.parametrize(
    ("kind", "key", "quantity", "within", "beyond"),
    [
        ("persson", "area-persson", "area", H, F),
        ("persson", "stiffness-persson", "stiffness", H, F),
        ("foundation", "area-foundation", "area", F, H),
        ("foundation", "stiffness-foundation", "stiffness", F, H),
        ("gw", "asperities", "area", F, H),
        ("gw_elliptic", "asperities", "area", F, H),
    ],
)
@pytest.mark.parametrize("upwards", [True, False])
def test_models_are_held_against_the_exact_solution(
    kind: str, key: str, quantity: str, within: Outcome, beyond: Outcome, *, upwards: bool
) -> None:
    for factor, outcome in ((1.3, within), (2.5, beyond), (1.75, U)):
        scale = factor if upwards else 1.0 / factor
        other = model(curves(**{quantity: scale}), kind)
        found = judged(results(model(curves()), other))[key]
        [measured] = found.measurements
        assert measured.value == pytest.approx(factor)
        assert found.outcome == outcome, (factor, measured)


@pytest.mark.parametrize("upwards", [True, False])
def test_separations_are_held_against_each_other_by_their_pressures(*, upwards: bool) -> None:
    """ū at equal pressure differs by a tenth, whatever the factor: it says nothing."""
    for factor, follows, is_far in ((1.3, H, F), (1.75, U, U), (2.6, F, H)):
        scale = factor if upwards else 1.0 / factor
        models = [
            model(shifted(100 * scale), kind) for kind in ("persson", "foundation", "winkler")
        ]
        found = judged(results(model(shifted(100)), *models))
        assert found["separation-persson"].outcome == follows
        at_pressure, at_separation = found["separation-persson"].measurements
        assert at_pressure.value < 1.3
        assert at_separation.value == pytest.approx(factor, rel=0.08)
        assert found["separation-foundation"].outcome == is_far
        assert found["coupling-separation"].outcome == is_far


def test_each_quantity_says_for_itself_whether_coupling_is_the_reason() -> None:
    other = model(curves(area=4.0, stiffness=1.1), "winkler")
    found = judged(results(model(curves()), other))
    kinds = ("area", "separation", "stiffness")
    assert [found[f"coupling-{name}"].outcome for name in kinds] == [H, F, F]
    found = judged(results(model(curves())))
    assert [found[f"coupling-{name}"].outcome for name in kinds] == [N, N, N]


def test_a_coupled_line_clears_the_dimension() -> None:
    exact, line = model(curves()), model(shifted(1.2, area=5.0), "line")
    found = judged(results(exact, line))
    kinds = ("area", "separation", "stiffness")
    assert [found[f"dimension-{name}"].outcome for name in kinds] == [F, H, H]


def test_other_pressures_are_said_to_be_the_reason() -> None:
    exact = model(curves())
    other = model(curves(), "foundation")
    other.variables["pressure"] = P * 1.01  # type: ignore[index]
    [measured] = judged(results(exact, other))["area-foundation"].measurements
    assert measured.outcome == N
    assert measured.note == "its pressures are not those of the exact solution"


@pytest.mark.parametrize(
    "options", [{"gamma": 1.0}, {"area_gamma": 0.5}, {"finite_size": "blend", "theta": 2.3}]
)
def test_the_theory_is_the_papers(options: dict[str, Any]) -> None:
    """Fitted variants may stand beside it, but are not what the paper speaks of."""
    variant = model(curves(area=3.0, stiffness=3.0), "persson", **({"gamma": 0.45} | options))
    found = judged(results(model(curves()), variant))
    assert found["area-persson"].outcome == N
    assert found["stiffness-persson"].outcome == N


def test_the_foundation_closes_early() -> None:
    exact = curves()
    exact["area"] = np.broadcast_to(np.minimum(P / 0.02, 1.0), exact["area"].shape)
    early, late = dict(exact), dict(exact)
    early["area"] = np.broadcast_to(np.minimum(P / 0.001, 1.0), exact["area"].shape)
    found = judged(results(model(exact), model(early, "foundation")))["closing-foundation"]
    assert found.outcome == H
    assert found.measurements[0].value == pytest.approx(20, rel=1e-6)
    found = judged(results(model(exact), model(late, "foundation")))["closing-foundation"]
    assert found.outcome == F


def test_experiments_are_compared_where_one_property_differs() -> None:
    flat, zero = model(curves()), model(curves(area=1.1), below_rolloff="cutoff")
    found = judged(results(flat), results(zero))["below-rolloff"]
    assert found.outcome == H
    assert found.measurements[0].value == pytest.approx(1.1)
    assert found.measurements[0].where == "file1.h5: main/bem"
    far = model(curves(area=1.5), below_rolloff="cutoff")
    assert judged(results(flat), results(far))["below-rolloff"].outcome == F
    # Another slope, seed or resolution, and they are not the same surfaces.
    for other in ({"rms_slope": 0.2}, {"seed": 2}, {"grid_points": 256}):
        alien = model(curves(), below_rolloff="cutoff", **other)
        assert judged(results(flat), results(alien))["below-rolloff"].outcome == N


def test_kappa_is_compared_over_the_rolloff() -> None:
    one, same = model(curves(), q_rolloff=1.0), model(curves(), q_rolloff=8.0)
    other = model(curves(area=1.3), q_rolloff=8.0)
    assert judged(results(one), results(same))["area-rolloff"].outcome == H
    narrow = model(curves(area=1.3), q_rolloff=8.0, q_max=128.0)
    wide = model(curves(), q_rolloff=1.0, q_max=128.0)
    [measured] = judged(results(wide), results(narrow))["area-rolloff"].measurements
    assert (measured.outcome, measured.note) == (N, "q₁ is less than 32 q_r")
    found = judged(results(one), results(other))["area-rolloff"]
    assert found.outcome == F
    assert found.measurements[0].what == "κ(q_r = 8) / κ(q_r = 1)"
    assert found.measurements[0].value == pytest.approx(1.3)


@pytest.mark.parametrize(("power", "exact", "foundation"), [(0.0, H, F), (-1.0, F, H)])
def test_sizes_show_in_the_pressure_at_a_separation(
    power: float, exact: Outcome, foundation: Outcome
) -> None:
    """ū = u0 ln(p0 L^s/p): the curve of a larger cell is shifted along the pressures."""
    experiments = []
    for scale in (1.0, 2.0, 4.0):
        values = curves()
        shift = values["separation"][2] / np.log(0.04 / P) * power * math.log(scale)
        values["separation"] = values["separation"] + shift
        size: dict[str, Any] = {"length": LENGTH * scale, "grid_points": 512 * scale}
        experiments.append(results(model(values, **size), model(values, "foundation", **size)))
    found = judged(*experiments)
    for key, outcome in (("size-exact", exact), ("size-foundation", foundation)):
        [measured] = found[key].measurements
        assert measured.value == pytest.approx(power, abs=0.02)
        assert found[key].outcome == outcome


def test_single_surfaces_say_nothing_of_sizes() -> None:
    experiments = []
    for scale in (1.0, 2.0):
        values = lawful(np.zeros(1))
        values["separation"] = np.maximum(values["separation"], 1e-3 * HEIGHT)
        size: dict[str, Any] = {"length": LENGTH * scale, "grid_points": 512 * scale}
        experiments.append(results(model(values, **size)))
    [measured] = judged(*experiments)["size-exact"].measurements
    assert measured.value == pytest.approx(0.0, abs=0.02)
    assert measured.outcome == U


def test_correlations_need_observables() -> None:
    def observed(kind: str, stress: float, contact: float) -> ModelResult:
        one = model(curves(), kind)
        extra = {}
        for name, value in (("stress", stress), ("contact", contact)):
            extra[f"{name}_spectrum_exponent_mean"] = np.full(P.shape, value)
            extra[f"{name}_spectrum_exponent_sem"] = np.full(P.shape, 0.03)
        return ModelResult(kind, kind, kind, one.attributes, {**one.variables, **extra})

    off = results(observed("bem", -1.6, -1.8))
    off["main"]["bem"].variables["area_mean"] = np.full(P.shape, 0.5)  # type: ignore[index]
    [measured] = judged(off)["stress-correlation"].measurements
    assert measured.outcome == N
    lost = observed("bem", -1.6, -1.8)
    lost.variables["area_mean"][0] = math.nan  # no state converged there
    assert judged(results(lost))["stress-correlation"].outcome == H
    keys = ("stress-correlation", "overlap-correlation", "overlap-stress")
    found = judged(results(observed("bem", -1.6, -1.8), observed("winkler", -3.4, -2.6)))
    assert [found[key].outcome for key in keys] == [H, H, H]
    found = judged(results(observed("bem", -1.2, -1.8), observed("winkler", -2.9, -2.3)))
    assert [found[key].outcome for key in keys] == [F, F, F]
    found = judged(results(model(curves()), model(curves(), "winkler")))
    assert [found[key].outcome for key in keys] == [N, N, N]


def test_the_foundation_may_have_the_laws_it_should_lack() -> None:
    other = model(curves(), "foundation")
    found = judged(results(model(curves()), other))
    assert found["finite-size-foundation"].outcome == H
    assert found["stiffness-foundation-linear"].outcome == F


def test_a_bent_curve_has_no_region_however_wide_its_band() -> None:
    """K/p stays within ±20 % over a decade or more, but its slope is 1 at one place only."""
    bent = np.exp(0.12 * np.log(P / 1e-4) ** 2) * (P / P[0]) ** 0
    values = curves()
    values["stiffness"] = np.broadcast_to(P / 0.002 * bent, values["stiffness"].shape)
    found = judged(results(model(curves()), model(values, "foundation")))
    [measured] = found["stiffness-foundation-linear"].measurements
    # The decade from 4 to 14 of the pressures about 1e-4 ends at 0.6 decades from it.
    assert measured.value == pytest.approx(math.exp(0.12 * (0.6 * math.log(10)) ** 2), rel=0.01)
    assert found["stiffness-foundation-linear"].outcome == H


def test_scatter_leaves_claims_undecided() -> None:
    wild = lawful(np.array([-0.6, 0.9, -0.4, 0.1, 0.2]))
    found = judged(results(model(wild)))["kappa"]
    assert found.outcome == U
    assert found.measurements[0].error > 0.2


def test_a_single_surface_decides_nothing_and_says_so() -> None:
    one = lawful(np.zeros(1))
    [measured] = judged(results(model(one)))["kappa"].measurements
    assert measured.outcome == U
    assert math.isnan(measured.error)
    assert measured.note == "a single surface: no error"
    [measured] = judged(results(model(one, surface="file")))["kappa"].measurements
    assert measured.outcome == H  # measured heights are what they are


def test_the_reference_may_be_named() -> None:
    both = results(model(curves()), model(curves(area=3.0), "winkler"))
    found = {v.key: v for v in judge([("a", both)], reference="winkler", resamples=20)}
    assert found["kappa"].measurements[0].value == pytest.approx(6.0, rel=0.01)
    # Where there is no such model the first exact solver stands in, for all claims.
    alone = results(model(curves()), model(curves(area=3.0), "foundation"))
    sources = [("a", both), ("b", alone)]
    found = {v.key: v for v in judge(sources, reference="winkler", resamples=20)}
    assert [m.where for m in found["kappa"].measurements] == ["a: main/winkler", "b: main/bem"]
    assert found["area-foundation"].measurements[0].value == pytest.approx(3.0)
    with pytest.raises(StoreError, match="no model is named 'gw'; choose one of bem, winkler"):
        judge([("a", both)], reference="gw")


def test_heights_from_a_file_have_no_theory() -> None:
    bare = model(curves())
    kept = ("rms_height", "rms_slope", "length")
    measured = ModelResult(
        "bem", "bem", "bem", {k: bare.attributes[k] for k in kept}, bare.variables
    )
    found = judged(results(measured))
    assert found["kappa"].outcome == H
    assert found["finite-size-prefactor"].outcome == N
    assert found["rolloff-decades"].outcome == N
    assert bare.attributes["rms_height"] == HEIGHT
