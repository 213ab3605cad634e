"""Every place where numbers and arrays come in, and what each refuses to take."""

from __future__ import annotations

import math
import tracemalloc
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench import inputs
from roughbench.errors import RoughbenchError, SolverError, SurfaceError
from roughbench.inputs import (
    check_heights,
    float_array,
    positive_number,
    real_array,
    whole_number,
)
from roughbench.models.base import CompleteCurve
from roughbench.models.foundation import foundation_curve, full_contact_pressure
from roughbench.models.gw import counted_gw_curve
from roughbench.models.gw_elliptic import counted_elliptic_curve
from roughbench.models.hertz_top import asperity_of_heights
from roughbench.models.line import single_contact_stiffness
from roughbench.models.persson import persson_curve, self_consistent_area
from roughbench.models.winkler import gaussian_winkler_curve, winkler_curve
from roughbench.observables import of_springs
from roughbench.spectrum import measured_spectrum, mode_power, self_affine
from roughbench.surface import make_surface, realization_generator

N = 16
WAVE = 0.01 * np.cos(2 * math.pi * np.arange(N) / N)
LINE = WAVE
SURFACE = WAVE[:, None] + WAVE
SPECTRUM = self_affine(hurst=0.7, q_min=1, q_rolloff=2, q_max=4, rms_slope=0.1)

TAKES_HEIGHTS: dict[str, tuple[np.ndarray[Any, Any], Callable[[Any], object]]] = {
    "solve_contact": (SURFACE, lambda h: rb.solve_contact(h, 1e-3)),
    "solve_contact, line": (LINE, lambda h: rb.solve_contact(h, 1e-3)),
    "solve_curve": (SURFACE, lambda h: rb.solve_curve(h, [1e-3])),
    "solve_curve, line": (LINE, lambda h: rb.solve_curve(h, [1e-3])),
    "foundation": (LINE, lambda h: foundation_curve(h, [1e-3], 1.0)),
    "full_contact_pressure": (LINE, lambda h: full_contact_pressure(h, 1.0)),
    "winkler": (SURFACE, lambda h: winkler_curve(h, [1e-3], 1.0)),
    "gw": (SURFACE, lambda h: counted_gw_curve(h, [1e-3], 1.0)),
    "gw_elliptic": (SURFACE, lambda h: counted_elliptic_curve(h, [1e-3], 1.0)),
    "hertz_top": (SURFACE, lambda h: asperity_of_heights(h, 1.0)),
    "measured_spectrum": (SURFACE, lambda h: measured_spectrum(h, 1.0)),
    "mode_power": (SURFACE, mode_power),
    "of_springs": (SURFACE, lambda h: of_springs(h, 1e-3, 1.0, 1.0, SPECTRUM)),
}
TAKES_PRESSURES: dict[str, Callable[[Any], object]] = {
    "solve_curve": lambda p: rb.solve_curve(SURFACE, p),
    "foundation": lambda p: foundation_curve(LINE, p, 1.0),
    "winkler": lambda p: winkler_curve(SURFACE, p, 1.0),
    "persson": lambda p: persson_curve(SPECTRUM, p),
    "self_consistent_area": lambda p: self_consistent_area(p, 0.45),
}
heights_everywhere = pytest.mark.parametrize(
    ("heights", "take"), TAKES_HEIGHTS.values(), ids=TAKES_HEIGHTS
)
CHECKS_SIZES = {name: case for name, case in TAKES_HEIGHTS.items() if name != "mode_power"}
pressures_everywhere = pytest.mark.parametrize(
    "take", TAKES_PRESSURES.values(), ids=TAKES_PRESSURES
)


# -- masks ---------------------------------------------------------------------------------


@heights_everywhere
def test_masked_heights_are_refused_with_their_number(
    heights: np.ndarray[Any, Any], take: Callable[[Any], object]
) -> None:
    """The bad value behind the mask carried all of the load once."""
    bad = heights.copy()
    bad.flat[[3, 5]] = 1e3
    masked = np.ma.masked_greater(bad, 1.0)
    message = rf"heights must not be masked, got 2 of {heights.size} masked; fill or crop"
    with pytest.raises((SolverError, SurfaceError), match=message):
        take(masked)


@heights_everywhere
def test_a_mask_that_hides_nothing_is_no_matter(
    heights: np.ndarray[Any, Any], take: Callable[[Any], object]
) -> None:
    for mask in (False, np.zeros(heights.shape, bool)):
        take(np.ma.masked_array(heights, mask))


def test_masks_within_lists_are_seen() -> None:
    rows = [np.ma.masked_array(row, mask=False) for row in SURFACE]
    assert rb.solve_contact(rows, 1e-3).pressure.shape == SURFACE.shape
    rows[2][1] = np.ma.masked
    with pytest.raises(SolverError, match=rf"got 1 of {SURFACE.size} masked"):
        rb.solve_contact(rows, 1e-3)
    with pytest.raises(SolverError, match="heights must not be masked, got 1 of 1 masked"):
        foundation_curve([0.0, np.ma.masked], [1e-3], 1.0)  # type: ignore[arg-type]


@pressures_everywhere
def test_masked_pressures_are_refused(take: Callable[[Any], object]) -> None:
    take(np.ma.masked_array([1e-3, 2e-3], mask=False))
    with pytest.raises(SolverError, match="pressures must not be masked, got 1 of 2 masked"):
        take(np.ma.masked_array([1e-3, 2e-3], mask=[False, True]))


def test_masked_numbers_are_refused() -> None:
    with pytest.raises(SolverError, match="pressure must be a number, got masked"):
        rb.solve_contact(SURFACE, np.ma.masked)  # type: ignore[arg-type]
    with pytest.raises(SolverError, match="widths must not be masked, got 1 of 2"):
        single_contact_stiffness(np.ma.masked_invalid([0.5, np.nan]), 1.0)


# -- what is no number ---------------------------------------------------------------------

NO_NUMBERS: list[Any] = [
    *(None, "1.0", "1 um", b"1", (1.0, 1.0), [1.0], {}, True, np.True_, 1 + 0j, object),
    *(np.array([1.0]), np.array([]), np.complex128(1), np.datetime64("2026-01-01"), rb),
]


@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
@pytest.mark.parametrize("name", ["length", "modulus", "tolerance"])
def test_options_that_are_no_numbers_are_named(name: str, value: Any) -> None:
    if name == "length" and isinstance(value, tuple):
        return  # the two sides of a cell
    for solve in (
        lambda: rb.solve_contact(SURFACE, 1e-3, **{name: value}),
        lambda: rb.solve_curve(SURFACE, [1e-3], **{name: value}),
    ):
        with pytest.raises(SolverError, match=f"^{name} must be a number, (got|or .*, got) "):
            solve()


@pytest.mark.parametrize("value", [*NO_NUMBERS[1:], 2.0, 1.5], ids=repr)
@pytest.mark.parametrize("name", ["threads", "max_iterations"])
def test_options_that_are_no_whole_numbers_are_named(name: str, value: Any) -> None:
    for solve in (
        lambda: rb.solve_contact(SURFACE, 1e-3, **{name: value}),
        lambda: rb.solve_curve(SURFACE, [1e-3], **{name: value}),
    ):
        with pytest.raises(SolverError, match=f"^{name} must be a whole number, got "):
            solve()
    with pytest.raises(SolverError, match=r"^max_iterations must be a whole number, got None"):
        rb.solve_contact(SURFACE, 1e-3, max_iterations=None)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
def test_other_numbers_are_named_as_well(value: Any) -> None:
    calls: dict[str, Callable[[], object]] = {
        "pressure": lambda: rb.solve_contact(SURFACE, value),
        "the length of the cell": lambda: foundation_curve(LINE, [1e-3], value),
        "the springs' modulus": lambda: winkler_curve(SURFACE, [1e-3], value),
        "the rms height": lambda: gaussian_winkler_curve(value, [1e-3], 1.0),
        "reach": lambda: asperity_of_heights(SURFACE, 1.0, value),
        "gamma": lambda: persson_curve(SPECTRUM, [1e-3], value),
        "length": lambda: measured_spectrum(SURFACE, value),
    }
    if value is None:  # as if it were not given
        with pytest.raises(SolverError, match="give exactly one of pressure, separation and"):
            calls.pop("pressure")()
    for name, call in calls.items():
        with pytest.raises(RoughbenchError, match=f"^{name} must be a number, got "):
            call()


@pytest.mark.parametrize(
    "value", ["mixed ", None, True, 1, ("mixed",), ["double"], np.array(["mixed", "double"])]
)
def test_precisions_that_are_none(value: Any) -> None:
    with pytest.raises(SolverError, match="precision must be 'mixed' or 'double', got "):
        rb.solve_contact(SURFACE, 1e-3, precision=value)


@pressures_everywhere
@pytest.mark.parametrize(
    ("value", "message"),
    [
        (["0.1", "0.2"], "pressures must be real numbers, got dtype <U3"),
        ("0.1", "pressures must be real numbers, got dtype <U3"),
        ([None, 0.1], "pressures must be real numbers, got dtype object"),
        ([True], "pressures must be real numbers, got dtype bool"),
        ([0.1 + 1j], "pressures must be real numbers, got dtype complex128"),
        (np.array([0.1 + 0j]), "pressures must be real numbers, got dtype complex128"),
        ([[0.1], [0.1, 0.2]], "pressures must be a rectangular array"),
        (None, "pressures must be real numbers, got dtype object|one of pressures, forces"),
    ],
)
def test_pressures_that_are_none(
    take: Callable[[Any], object], value: Any, message: str
) -> None:
    with pytest.raises(SolverError, match=message):
        take(value)


@pytest.mark.parametrize(
    "value",
    [
        2,
        2.0,
        np.float32(2),
        np.int8(2),
        np.array(2.0),
        Fraction(2),
        Decimal(2),
        np.longdouble(2),
    ],
    ids=repr,
)
def test_numbers_of_all_kinds_will_do(value: Any) -> None:
    assert positive_number(value, "length") == 2.0
    assert type(positive_number(value, "length")) is float
    assert float_array([value, 1], "pressures").tolist() == [2.0, 1.0]
    one = rb.solve_contact(SURFACE, value, length=value, modulus=value, threads=1)
    other = rb.solve_contact(SURFACE, 2.0, length=2.0, modulus=2.0, threads=1)
    np.testing.assert_array_equal(one.pressure, other.pressure)


@pytest.mark.parametrize("value", [2, np.int64(2), np.uint8(2), np.array(2)], ids=repr)
def test_whole_numbers_of_all_kinds_will_do(value: Any) -> None:
    assert whole_number(value, "threads") == 2
    assert type(whole_number(value, "threads")) is int


@pytest.mark.parametrize("value", [0, -1.0, math.inf, math.nan])
def test_numbers_out_of_range(value: float) -> None:
    with pytest.raises(SolverError, match="length must be a positive number, got "):
        positive_number(value, "length")
    with pytest.raises(SolverError, match="length must be a number that float64 can hold"):
        positive_number(10**400, "length")
    with pytest.raises(SolverError, match="threads must be at least 1, got 0"):
        whole_number(0, "threads")


def test_long_arguments_do_not_flood_the_message() -> None:
    with pytest.raises(SolverError) as caught:
        positive_number([0.1] * 10**6, "length")
    assert len(str(caught.value)) < 100


# -- heights -------------------------------------------------------------------------------


@heights_everywhere
def test_complex_heights_keep_their_imaginary_part_from_nobody(
    heights: np.ndarray[Any, Any], take: Callable[[Any], object]
) -> None:
    with pytest.raises(RoughbenchError, match="must be real numbers, got dtype complex"):
        take(heights + 0.1j)
    with pytest.raises(RoughbenchError, match="heights must be real numbers, got dtype <U"):
        take(heights.astype(str))


@pytest.mark.parametrize(("heights", "take"), CHECKS_SIZES.values(), ids=CHECKS_SIZES)
@pytest.mark.parametrize("size", [1e308, 1e160, 1e-160])
def test_heights_beyond_the_range_of_float64_are_refused(
    heights: np.ndarray[Any, Any], take: Callable[[Any], object], size: float
) -> None:
    """±1e308 gave nan, and the status CONVERGED."""
    with pytest.raises(RoughbenchError, match=r"out of the range of float64.* unit of length"):
        take(np.sign(heights) * size)


@pytest.mark.parametrize("power", [-150, -20, 0, 20, 150])
@pytest.mark.parametrize("name", ["foundation", "winkler"])
def test_springs_in_any_unit_of_length(name: str, power: int) -> None:
    def curve(unit: float) -> CompleteCurve:
        if name == "foundation":
            return foundation_curve(LINE * unit, [1e-3, 1.0], unit)
        return winkler_curve(SURFACE * unit, [1e-3, 1.0], 1.0 / unit)

    unit = 10.0**power
    one, other = curve(1.0), curve(unit)
    np.testing.assert_allclose(other.area, one.area, rtol=1e-12)
    np.testing.assert_allclose(other.separation, one.separation * unit, rtol=1e-9)
    np.testing.assert_allclose(other.stiffness, one.stiffness / unit, rtol=1e-9)
    np.testing.assert_allclose(other.energy, one.energy * unit, rtol=1e-9)


@pytest.mark.parametrize(
    ("call", "quantity"),
    [
        (lambda: foundation_curve([0.0, 1.0], [1e200], 1.0), "energy"),
        (lambda: foundation_curve([0.0, 1.0, 1.0], [1e300], 1e-308), "stiffness"),
        (lambda: winkler_curve([0.0, 1.0], [1e300], 1e-100), "energy"),
    ],
)
def test_springs_say_where_they_overflow(
    call: Callable[[], CompleteCurve], quantity: str
) -> None:
    with pytest.raises(SolverError, match=f"the ({quantity}) leaves the range of float64"):
        call()


@pytest.mark.parametrize(
    "options", [{"length": 1e-300, "modulus": 1e100}, {"modulus": 1e-307}, {"length": 1e306}]
)
def test_units_beyond_the_range_of_float64_are_refused(options: dict[str, Any]) -> None:
    with pytest.raises(SolverError, match="results leave the range of float64; choose units"):
        rb.solve_contact(SURFACE, 1e-3, **options)


def test_arrays_are_not_copied_without_need() -> None:
    assert real_array(SURFACE, "heights") is SURFACE
    assert float_array(SURFACE, "heights") is SURFACE
    masked = np.ma.masked_array(SURFACE, mask=False)
    assert np.shares_memory(real_array(masked, "heights"), SURFACE)


# -- digits --------------------------------------------------------------------------------

ROUGH = make_surface(
    self_affine(hurst=0.7, q_min=1, q_rolloff=4, q_max=32, rms_slope=0.1),
    128,
    2 * math.pi,
    realization_generator(0, 0),
)


@pytest.mark.parametrize("mean", [0.0, 1.0, -100.0])
def test_the_mean_of_float32_heights_is_subtracted_in_float64(mean: float) -> None:
    """The answer is that of the same heights in float64, and near that of the unrounded."""
    single = (ROUGH + mean).astype(np.float32)
    states = [
        rb.solve_contact(h, 3e-3, length=2 * math.pi, threads=1)
        for h in (single, single.astype(np.float64), ROUGH)
    ]
    np.testing.assert_array_equal(states[0].pressure, states[1].pressure)
    assert states[0].mean_separation == states[1].mean_separation
    assert states[0].area_fraction == pytest.approx(states[2].area_fraction, rel=1e-3)
    assert states[0].stiffness() == pytest.approx(states[2].stiffness(), rel=1e-3)


@pytest.mark.parametrize(
    ("dtype", "mean"), [("f2", 1.0), ("f4", 1e3), ("f4", -1e4), ("f8", 1e12), (">f4", 1e4)]
)
def test_digits_that_are_not_there_are_asked_for(dtype: str, mean: float) -> None:
    """Float32 with a mean of 1e3 was wrong by 0.9 %, in silence."""
    for heights, take in (
        (ROUGH, lambda h: rb.solve_contact(h, 1e-3)),
        (ROUGH[0], lambda h: foundation_curve(h, [1e-3], 1.0)),
        (ROUGH, lambda h: measured_spectrum(h, 1.0)),
    ):
        coarse = (heights + mean).astype(dtype)
        with pytest.raises(RoughbenchError) as caught:
            take(coarse)
        told = str(caught.value)
        assert f"with a mean of {coarse.mean(dtype=float):.6g} are too coarse" in told
        assert "subtract the mean before they are stored" in told
        assert ("convert them to float64" in told) == (dtype != "f8")
        if dtype != "f8":  # the way out that the message names
            take(coarse.astype(np.float64))


@pytest.mark.parametrize("dtype", ["f2", "f4"])
@pytest.mark.parametrize(
    "heights",
    [
        np.zeros((64, 64)) + 1e3,
        np.eye(64),
        np.where(np.arange(64) % 8 < 4, 0.0, 1.0)[:, None] + np.zeros(64),
        np.where(np.arange(64) % 8 < 4, 0.0, 1.0) + np.zeros((64, 1)),
        np.indices((64, 64)).sum(axis=0) % 7.0,
        np.arange(64.0 * 64).reshape(64, 64) == 77,
        np.cos(2 * math.pi * np.arange(64) / 64),
    ],
    ids=["flat", "diagonal", "grooves", "columns", "steps", "spike", "line"],
)
def test_digits_that_suffice_are_not_asked_for(
    heights: np.ndarray[Any, Any], dtype: str
) -> None:
    check_heights(heights.astype(dtype))
    check_heights(np.asarray(heights, np.float64))


def test_digits_are_judged_block_by_block(monkeypatch: pytest.MonkeyPatch) -> None:
    coarse = (ROUGH + 1e3).astype(np.float32)
    told = []
    for block in (1 << 20, 128, 300, 1):
        monkeypatch.setattr(inputs, "_BLOCK", block)
        for heights in (coarse, coarse.ravel()):
            with pytest.raises(SolverError) as caught:
                check_heights(heights)
            told.append(str(caught.value))
    assert set(told[2:]) == set(told[:2])


def test_judging_digits_takes_no_second_field() -> None:
    """At 16384² points a copy in float64 would be 2.1 GB."""
    heights = np.resize(ROUGH, (2048, 2048)).astype(np.float32)
    tracemalloc.start()
    check_heights(heights)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 0.8 * 8 * heights.size
