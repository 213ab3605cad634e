"""Each check fires where it must and says a number and a remedy; good surfaces are silent."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.scans import border_checks
from roughbench.scans.checks import Doubt, doubts_of
from roughbench.scans.evidence import height_step, steps_between, waves_of
from roughbench.scans.preparation import Preparation, prepare
from roughbench.scans.topography import Scan
from roughbench.spectrum import self_affine
from roughbench.surface import make_profile, make_surface, realization_generator

Heights = NDArray[np.float64]
LENGTH = 2 * np.pi
UM = 1e-6


def surface(
    points: int = 128,
    per_wave: int = 4,
    hurst: float = 0.8,
    rolloff: float = 4.0,
    seed: int = 1,
    **options: Any,
) -> Heights:
    spectrum = self_affine(
        hurst=hurst, q_min=1, q_rolloff=rolloff, q_max=points // per_wave, rms_slope=0.1
    )
    return make_surface(spectrum, points, LENGTH, realization_generator(seed, 0), **options)


def crop_of(heights: Heights) -> Heights:
    rows, columns = heights.shape
    return heights[: rows // 2, : columns // 2].copy()


def names(doubts: list[Doubt], *, wrong: bool = False) -> list[str]:
    return [doubt.check for doubt in doubts if doubt.is_wrong or not wrong]


def one(doubts: list[Doubt], check: str) -> Doubt:
    (found,) = [doubt for doubt in doubts if doubt.check == check]
    assert "\n" not in found.text
    assert any(character.isdigit() for character in found.text)
    return found


# -- silence on good surfaces --------------------------------------------------------------

GOOD = list(itertools.product((64, 128), (4, 8), (0.2, 0.5, 0.8, 0.95), (4.0, 8.0)))


@pytest.mark.parametrize("amplitude", ["fixed", "gaussian"])
@pytest.mark.parametrize(("points", "per_wave", "hurst", "rolloff"), GOOD)
def test_good_surfaces_are_silent(
    points: int, per_wave: int, hurst: float, rolloff: float, amplitude: Any
) -> None:
    if points // per_wave <= rolloff:
        rolloff = 4.0
    for seed in range(3):
        heights = surface(points, per_wave, hurst, rolloff, seed, amplitude=amplitude)
        assert doubts_of(heights, LENGTH) == []


@pytest.mark.parametrize("hurst", [0.2, 0.5, 0.8, 0.95])
def test_at_nyquist_only_the_resolution_is_in_doubt(hurst: float) -> None:
    for rolloff, seed in itertools.product((4.0, 8.0), range(3)):
        doubts = doubts_of(surface(64, 2, hurst, rolloff, seed), LENGTH)
        assert [(doubt.check, doubt.is_wrong) for doubt in doubts] == [("resolution", False)]


@pytest.mark.parametrize("hurst", [0.5, 0.8, 0.95])
@pytest.mark.parametrize("rolloff", [1.0, 2.0])
def test_few_long_waves_are_too_few_bumps_and_nothing_else(
    hurst: float, rolloff: float
) -> None:
    for per_wave, seed in itertools.product((4, 8, 16), range(3)):
        doubts = doubts_of(surface(128, per_wave, hurst, rolloff, seed), LENGTH)
        assert set(names(doubts)) <= {"bumps"}
        assert not names(doubts, wrong=True)


@pytest.mark.parametrize("amplitude", ["fixed", "gaussian"])
@pytest.mark.parametrize("hurst", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("points", [256, 4096])
def test_good_lines_are_silent(points: int, hurst: float, amplitude: Any) -> None:
    for per_wave, seed in itertools.product((4, 8), range(5)):
        spectrum = self_affine(
            hurst=hurst, q_min=1, q_rolloff=24, q_max=points // per_wave, rms_slope=0.1
        )
        line = make_profile(spectrum, points, LENGTH, realization_generator(seed, 1), amplitude)
        assert doubts_of(line, LENGTH) == []


def test_good_scans_are_silent() -> None:
    heights = surface(256) * 10 * UM / LENGTH
    y, x = np.mgrid[-1:1:256j, -1:1:256j]
    tilted = heights + 0.2 * UM * y - 0.1 * UM * x
    tilted[100:104, 30:50] = np.nan
    for edges in ("mirror", "taper"):
        preparation = Preparation("plane", 0.01, edges)
        scan = Scan(tilted, (10 * UM, 10 * UM))
        prepared = prepare(scan, preparation)
        found = doubts_of(
            prepared.heights, prepared.length, raw=scan, preparation=preparation, gap=1e-9
        )
        assert found == []


def test_a_flat_plate_has_no_doubts() -> None:
    assert doubts_of(np.zeros((8, 8)), 1.0) == []


# -- the four cases of which nobody said a word ----------------------------------------------


def test_a_tilt_of_little_more_than_a_degree() -> None:
    heights = surface(256)
    tilted = heights + np.tan(np.radians(1.3)) * np.arange(256) * LENGTH / 256
    found = one(doubts_of(tilted, LENGTH), "tilt")
    assert found.is_wrong
    assert "(1.3°)" in found.text or "(1.2°)" in found.text or "(1.4°)" in found.text
    assert "accept: [tilt]" in found.text
    assert "take the file as kind: scan with detrend: plane" in found.text


def test_nanometres_over_micrometres() -> None:
    found = one(doubts_of(surface() * 1000.0, LENGTH), "unit")
    assert found.is_wrong
    assert "slope of 97.9" in found.text
    assert "(nm over µm would make it 0.0979" in found.text


@pytest.mark.parametrize("hurst", [0.3, 0.5, 0.8])
@pytest.mark.parametrize("rolloff", [2.0, 8.0])
def test_a_crop_of_a_larger_surface(hurst: float, rolloff: float) -> None:
    for seed in range(4):
        cropped = crop_of(surface(256, 4, hurst, rolloff, seed))
        found = one(doubts_of(cropped, LENGTH / 2), "jump")
        assert found.is_wrong
        assert "edges: mirror" in found.text


def test_a_step_at_the_border_and_within() -> None:
    heights = surface()
    height = 5.0 * heights.std()
    half = heights + height * (np.arange(128) >= 50)
    doubts = doubts_of(half, LENGTH)
    assert "jump" in names(doubts, wrong=True)
    assert "between columns 49 and 50" in one(doubts, "step").text
    terrace = heights + height * ((np.arange(128) >= 30) & (np.arange(128) < 70))[:, None]
    doubts = doubts_of(terrace, LENGTH)
    assert not {"jump", "tilt"} & set(names(doubts))
    found = one(doubts, "step")
    assert not found.is_wrong
    assert "between rows" in found.text


# -- each check ----------------------------------------------------------------------------


def as_scan(heights: Heights, preparation: Preparation, **options: Any) -> list[Doubt]:
    """Check heights as a scan in SI units, LENGTH meaning 10 µm."""
    scan = Scan(
        heights * 10 * UM / LENGTH, (10 * UM, 10 * UM * heights.shape[1] / len(heights))
    )
    prepared = prepare(scan, preparation)
    return doubts_of(
        prepared.heights, prepared.length, raw=scan, preparation=preparation, **options
    )


def test_what_is_said_settles_tilt_and_jump() -> None:
    tilted = crop_of(surface(256, rolloff=12.0)) + 0.05 * np.arange(128) * LENGTH / 256
    assert names(as_scan(tilted, Preparation()), wrong=True) == ["tilt", "jump"]
    assert names(as_scan(tilted, Preparation(edges="mirror")), wrong=True) == ["tilt"]
    assert names(as_scan(tilted, Preparation("plane")), wrong=True) == ["jump"]
    for edges in ("periodic", "crop"):
        left = as_scan(tilted, Preparation("plane", edges=edges))
        assert names(left, wrong=True) == []
        assert "edges: mirror has no jump" in one(left, "jump").text
    kept = as_scan(tilted, Preparation("none", edges="mirror"))
    assert names(kept, wrong=True) == []
    assert "tilted by" in one(kept, "tilt").text
    assert as_scan(tilted, Preparation("plane", edges="mirror")) == []
    accepted = as_scan(tilted, Preparation(), accept=["tilt", "jump"])
    assert not {"tilt", "jump"} & set(names(accepted))


def test_a_tilt_says_its_slopes_with_and_without() -> None:
    heights = surface(256)
    y, x = (np.arange(256) * LENGTH / 256 for _ in range(2))
    scan = heights + 0.03 * y[:, None] - 0.05 * x
    text = one(as_scan(scan, Preparation()), "tilt").text
    before, after = (as_read(h) for h in (scan, heights))
    assert "nm/µm along y and -" in text
    # The surface has a plane of its own; the slope of the cell without it is nearly that of
    # the periodic surface.
    with_it, without = (
        float(part.rpartition(" ")[2])
        for part in (text.split(", without")[0], text.split(";")[0])
    )
    assert with_it == pytest.approx(before, rel=0.01)
    assert without == pytest.approx(after, rel=0.05)


def as_read(heights: Heights) -> float:
    """Rms slope of the cell, by differences, across its border too."""
    d = LENGTH / heights.shape[0]
    squares = sum(np.mean((np.roll(heights, -1, axis) - heights) ** 2) for axis in (0, 1))
    return float(np.sqrt(squares)) / d


def test_steep_slopes_are_wrong_in_pascals_and_doubtful_without_units() -> None:
    steep = surface(rolloff=4.0) * 10.0
    plain = one(doubts_of(steep, LENGTH), "slope")
    assert not plain.is_wrong
    assert "above 0.7" in plain.text
    scan = one(as_scan(steep, Preparation("plane", edges="mirror")), "slope")
    assert scan.is_wrong
    assert doubts_of(steep, LENGTH, accept=["slope"]) == []


def test_raw_counts() -> None:
    counts = np.round(surface() / surface().std() * 400.0 + 2000.0)
    found = one(doubts_of(counts, LENGTH), "unit")
    assert found.is_wrong
    assert f"whole numbers from {counts.min():.0f} to {counts.max():.0f}" in found.text
    scan = Scan(counts * 1e-6, (10 * UM, 10 * UM))
    prepared = prepare(scan, Preparation("plane", edges="mirror"))
    found = one(doubts_of(prepared.heights, prepared.length, raw=scan), "unit")
    assert "raw counts" in found.text


def test_flat_beyond_belief() -> None:
    found = one(doubts_of(surface() * 1e-6, LENGTH), "unit")
    assert not found.is_wrong
    assert "would make it 0.0979" in found.text


def test_steps_of_the_instrument() -> None:
    heights = surface()
    difference = np.sqrt(np.mean(np.diff(heights, axis=0) ** 2))
    for share, expected in ((0.03, []), (0.3, ["quantization", "resolution"])):
        step = share * np.sqrt(6.0) * difference
        rounded = step * np.round(heights / step)
        doubts = doubts_of(rounded, LENGTH)
        assert names(doubts) == expected
    text = one(doubts, "quantization").text
    assert f"steps of {step:.3g}" in text
    assert not doubts[0].is_wrong
    wrong = one(doubts_of(rounded, LENGTH, gap=0.5 * step), "quantization")
    assert wrong.is_wrong
    assert f"more than the mean gap at the lowest pressure, {0.5 * step:.3g}" in wrong.text
    assert not names(doubts_of(rounded, LENGTH, gap=2.0 * step), wrong=True)


@pytest.mark.parametrize("hurst", [0.2, 0.5, 0.8])
def test_unresolved_roughness_says_its_share(hurst: float) -> None:
    found = one(doubts_of(surface(128, 2, hurst), LENGTH), "resolution")
    share = float(found.text.partition(": ")[2].partition(" %")[0]) / 100.0
    spectrum = self_affine(hurst=hurst, q_min=1, q_rolloff=4, q_max=64, rms_slope=0.1)
    assert share == pytest.approx(1.0 - spectrum.moment(2, 32.0) / 0.01, abs=0.04)


def test_too_few_bumps() -> None:
    found = one(doubts_of(surface(rolloff=1.0), LENGTH), "bumps")
    assert not found.is_wrong
    assert "mean wavelength" in found.text


def test_lines_are_checked_too() -> None:
    spectrum = self_affine(hurst=0.8, q_min=1, q_rolloff=24, q_max=512, rms_slope=0.1)
    line = make_profile(spectrum, 4096, LENGTH, realization_generator(1, 0))
    x = np.arange(4096) * LENGTH / 4096
    tilted = doubts_of(line + 0.05 * x, LENGTH)
    assert names(tilted, wrong=True) == ["tilt", "jump"]
    assert "tilted by 0.05" in one(tilted, "tilt").text
    assert "jump" in names(doubts_of(line[:2000], LENGTH), wrong=True)
    assert (
        "between points 999 and 1000"
        in one(doubts_of(line + 0.1 * (x >= x[1000]), LENGTH), "step").text
    )
    assert names(doubts_of(line * 1e3, LENGTH), wrong=True) == ["unit"]


def test_those_that_make_it_wrong_come_first() -> None:
    doubts = doubts_of(crop_of(surface(256, 2, rolloff=1.0)) * 1e3, LENGTH / 2)
    flags = [doubt.is_wrong for doubt in doubts]
    assert flags == sorted(flags, reverse=True)
    assert 0 < sum(flags) < len(flags)


# -- what the checks look at ----------------------------------------------------------------


def test_steps_with_missing_points_and_lines(rng: np.random.Generator) -> None:
    heights = rng.normal(size=(100, 80))
    heights[rng.random(heights.shape) < 0.2] = np.nan
    wide = np.pad(heights, ((3, 0), (0, 5)), constant_values=np.nan)
    down = np.diff(heights, axis=0)
    for steps in (steps_between(heights)[0], steps_between(wide)[0]):
        np.testing.assert_allclose(steps.mean, np.nanmean(down, axis=1), rtol=1e-12)
        np.testing.assert_allclose(steps.square, np.nanmean(down**2, axis=1), rtol=1e-12)
        assert steps.border_mean == pytest.approx(np.nanmean(heights[0] - heights[-1]))
    across = np.diff(heights, axis=1)
    np.testing.assert_allclose(
        steps_between(wide)[1].square, np.nanmean(across**2, axis=0), rtol=1e-12
    )


def test_steps_of_nothing() -> None:
    steps = steps_between(np.zeros((4, 4)))[0]
    assert (steps.tilt, steps.jump, steps.added_slope) == (0.0, 0.0, 0.0)
    assert steps_between(np.r_[np.zeros(4), 1.0, 1.0])[0].jump > 2.0


@pytest.mark.parametrize("shape", [(64, 64), (48, 96)])
def test_waves_of_a_single_cosine(shape: tuple[int, int]) -> None:
    y, x = ((np.arange(n) + 0.5) for n in shape)
    heights = np.cos(2 * np.pi * y / 8)[:, None] * np.cos(2 * np.pi * x / 8) + 3.0
    waves = waves_of(heights)
    assert waves.wavelength == pytest.approx(8 / np.sqrt(2), rel=1e-12)
    assert waves.bumps == pytest.approx(shape[0] * shape[1] / 32, rel=1e-12)
    assert waves.last_octave == pytest.approx(0.0, abs=1e-12)


def test_height_steps_are_found_and_not_made_up(rng: np.random.Generator) -> None:
    smooth = surface(64)
    assert height_step(smooth) == 0.0
    assert height_step(np.cos(np.arange(64) * np.pi / 32)[:, None] * np.ones(64)) == 0.0
    assert height_step(np.round(rng.random((64, 64)))) == 0.0  # a pattern of two levels
    for step in (1e-12, 3e-10, 0.25):
        rounded: Heights = step * np.round(rng.normal(size=(256, 256)) * 20.0)
        rounded += 1e3 * step
        rounded[rng.random(rounded.shape) < 0.1] = np.nan
        assert height_step(rounded) == pytest.approx(step, rel=1e-6)


def test_limits_stand_apart_from_what_good_surfaces_reach() -> None:
    """The numbers beside the limits; a smaller sample than the one they were taken from."""
    reached = {"tilt": 0.0, "jump": 0.0, "over": 0.0, "step": 0.0}
    for hurst, rolloff, per_wave, seed in itertools.product(
        (0.2, 0.8, 0.95), (1.0, 8.0), (2, 4, 8), range(4)
    ):
        heights = surface(128, per_wave, hurst, rolloff, seed)
        for steps in steps_between(heights):
            reached["tilt"] = max(reached["tilt"], steps.tilt)
            reached["jump"] = max(reached["jump"], steps.jump)
            reached["over"] = max(reached["over"], steps.jump_over_largest)
            reached["step"] = max(reached["step"], steps.largest[2])
    assert 2.0 < reached["tilt"] < 3.8 < border_checks.TILT
    assert 1.2 < reached["jump"] < 1.9 < border_checks.JUMP
    assert 0.9 < reached["over"] < 1.2 < border_checks.JUMP_OVER_LARGEST
    assert 1.4 < reached["step"] < 2.2 < border_checks.STEP
