"""Surfaces of known H, qr, q1 and slope, spoiled as instruments do it, and characterized."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import roughbench as rb
from roughbench.errors import SurfaceError, UnitError
from roughbench.scans.spec_text import pressures, spec_text
from roughbench.scans.topography import Scan
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator

SIDE = 10e-6
Q0 = 2 * math.pi / SIDE
N = 384


def made(hurst: float, rolloff: float, *, n: int = N, end: float = 96.0) -> np.ndarray:
    """Heights in m, rms slope 0.1; roll-off and end of the spectrum in q0."""
    law = self_affine(
        hurst=hurst, q_min=Q0, q_rolloff=rolloff * Q0, q_max=end * Q0, rms_slope=0.1
    )
    return make_surface(law, n, SIDE, realization_generator(0, 0))


def test_a_clean_surface() -> None:
    heights = made(0.7, 6.0)
    found = rb.characterize(heights, size="10 um", detrend="mean")
    assert found.fit is not None
    assert found.fit.hurst == pytest.approx(0.7, abs=0.01)
    assert found.fit.rms_slope == pytest.approx(0.1, rel=0.01)
    assert found.fit.q_max == pytest.approx(96 * Q0, rel=0.02)
    assert not found.surface.windowed  # the borders meet
    for one in found.profiles:
        assert one is not None
        assert one.hurst == pytest.approx(0.7, abs=0.05)
        assert one.level == pytest.approx(1.0, abs=0.15)
    assert found.prepared.m0 == pytest.approx(found.surface.profile_moments[0], rel=0.02)
    assert found.along_x.profile_moments[1] == pytest.approx(0.005, rel=0.05)


@pytest.mark.parametrize(("hurst", "rolloff"), [(0.3, 8.0), (0.6, 4.0), (0.9, 10.0)])
def test_tilt_and_holes_in_nanometres(tmp_path: Path, hurst: float, rolloff: float) -> None:
    heights = made(hurst, rolloff)
    truth = float(heights.std())
    y, x = np.mgrid[:N, :N] * (SIDE / N)
    spoiled = heights + 0.03 * x - 0.02 * y
    rng = np.random.default_rng(1)
    for row, column in rng.integers(0, N - 3, (250, 2)):
        spoiled[row : row + 3, column : column + 3] = np.nan
    np.save(tmp_path / "scan.npy", 1e9 * spoiled)
    found = rb.characterize(tmp_path / "scan.npy", size="10 um, 10 um", unit="nm")
    assert found.raw.missing == pytest.approx(0.015, abs=0.002)
    assert found.prepared.missing == 0.0
    assert found.prepared.Sq == pytest.approx(truth, rel=0.01)
    assert found.fit is not None
    assert found.fit.hurst == pytest.approx(hurst, abs=0.05)
    assert found.fit.rms_slope == pytest.approx(0.1, rel=0.02)
    assert any("a spec must say fill: 2 %" in text for text in found.warnings)
    assert found.preparation.fill == 0.02


def test_a_crop_is_seen_through_a_window() -> None:
    found = rb.characterize(made(0.7, 12.0, n=1024, end=256.0)[:512, :512], size=SIDE / 2)
    assert found.surface.windowed
    assert found.fit is not None
    assert found.fit.hurst == pytest.approx(0.7, abs=0.05)
    assert found.fit.rms_slope == pytest.approx(0.1, rel=0.02)
    assert any("borders do not meet" in text for text in found.warnings)


def test_rectangular_pixels() -> None:
    found = rb.characterize(made(0.7, 6.0)[:, ::2], size=SIDE, edges="periodic")
    assert found.fit is not None
    assert found.fit.hurst == pytest.approx(0.7, abs=0.05)
    assert found.raw.points == (N, N // 2)
    assert found.prepared.points[0] == found.prepared.points[1]


def test_anisotropy_is_said() -> None:
    law = self_affine(hurst=0.7, q_min=Q0, q_rolloff=4 * Q0, q_max=48 * Q0, rms_slope=0.1)
    heights = make_surface(law, N, SIDE, realization_generator(2, 0))
    found = rb.characterize(heights, size=(2 * SIDE, SIDE))  # drawn out along y
    assert found.prepared.anisotropy == pytest.approx(2.0, rel=0.05)
    assert abs(found.prepared.direction) < 5.0
    assert any("anisotropic" in text for text in found.warnings)


def test_what_is_no_law_is_said() -> None:
    noise = 1e-9 * np.random.default_rng(0).standard_normal((128, 128))
    found = rb.characterize(noise, size="1 um")
    assert found.fit is None
    assert found.to_dict()["fit"] is None
    assert any("no self-affine law fits" in text for text in found.warnings)


def test_the_dictionary_is_strict_json() -> None:
    found = rb.characterize(made(0.7, 6.0), size="10 um", edges="mirror")
    values = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert values["points"] == [2 * N, 2 * N]  # the cell of the mirrored scan
    assert values["size"] == pytest.approx([2 * SIDE, 2 * SIDE])
    assert values["raw"]["points"] == [N, N]
    for name in ("missing", "Sa", "Sq", "Ssk", "Sku", "Sdq", "Sdr"):
        assert isinstance(values[name], float)
        assert isinstance(values["raw"][name], float)
    for name in ("H", "q0", "qr", "q1", "slope"):
        assert values["fit"][name] > 0.0
        assert values["fit"][f"{name}_error"] > 0.0
    assert all(isinstance(text, str) for text in values["warnings"])


def test_sizes_and_units() -> None:
    heights = 1e9 * made(0.7, 6.0, n=192)[:, :96]
    texts = rb.characterize(heights, size="5 um, 10 um", unit="nm")
    numbers = rb.characterize(heights, size=(10e-6, 5e-6), unit=1e-9)
    scan = rb.characterize(Scan(1e-9 * heights, (10e-6, 5e-6)))
    assert texts.prepared == numbers.prepared == scan.prepared
    with pytest.raises(SurfaceError, match="need their size"):
        rb.characterize(heights)
    with pytest.raises(UnitError, match="one length or two"):
        rb.characterize(heights, size="1 um, 2 um, 3 um")
    with pytest.raises(SurfaceError, match="rows and columns"):
        rb.characterize(heights[0], size="1 um")
    heights[3, 4] = np.nan
    with pytest.raises(SurfaceError, match="missing"):
        rb.characterize(heights, size="1 um", unit="nm", fill=0.0)


def test_a_spec_to_start_from(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    path = tmp_path / "data" / "a scan.npy"
    np.save(path, 1e9 * made(0.7, 12.0)[: N // 2, : N // 2])
    found = rb.characterize(path, size="5 um", unit="nm")
    text = spec_text(found, tmp_path, size="5 um", unit="nm")
    assert 'path: "data/a scan.npy"' in text
    assert "size: [5 um, 5 um]" in text
    assert "unit: nm" in text
    assert "detrend: plane" in text
    assert "edges: mirror" in text
    assert "name: a_scan" in text
    low, high = pressures(found.prepared.Sdq, 2.5e9 / 0.75)
    for pressure, area in ((low, 1e-3), (high, 0.3)):
        x = math.sqrt(2.0) * pressure / (2.5e9 / 0.75 * found.prepared.Sdq)
        assert math.erf(x) == pytest.approx(area)
