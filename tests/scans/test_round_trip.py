"""Known surfaces, tilted and with holes, through every format and back: the law is found."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import roughbench as rb
from roughbench.runner import plan, warnings
from roughbench.scans.spec_text import spec_text
from roughbench.spec import load_spec
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator
from tests.scans.writers import write_gwy, write_x3p, write_xyz

FloatArray = NDArray[np.float64]
SIDE, N = 20e-6, 384
Q0 = 2 * math.pi / SIDE


def spoiled(hurst: float, rolloff: float) -> tuple[FloatArray, float]:
    """Return heights in m with a tilt and holes, and their rms height before."""
    law = self_affine(
        hurst=hurst, q_min=Q0, q_rolloff=rolloff * Q0, q_max=96 * Q0, rms_slope=0.1
    )
    heights = make_surface(law, N, SIDE, realization_generator(0, 0))
    rms = float(heights.std())
    y, x = np.mgrid[:N, :N] * (SIDE / N)
    heights = heights + 0.03 * x - 0.02 * y
    for row, column in np.random.default_rng(1).integers(0, N - 3, (200, 2)):
        heights[row : row + 3, column : column + 3] = np.nan
    return heights, rms


def as_npy(path: Path, heights: FloatArray) -> dict[str, str]:
    np.save(path, 1e6 * heights)
    return {"size": "0.02 mm, 20 um", "unit": "um"}


def as_text(path: Path, heights: FloatArray) -> dict[str, str]:
    header = "Width: 20 µm\nHeight: 20 µm\nValue units: nm"
    np.savetxt(path, 1e9 * heights, delimiter=";", header=header, encoding="utf-8")
    return {}


def as_x3p(path: Path, heights: FloatArray) -> dict[str, str]:
    write_x3p(path, heights, (SIDE, SIDE))
    return {}


def as_gwy(path: Path, heights: FloatArray) -> dict[str, str]:
    missing = np.isnan(heights)
    write_gwy(path, {"Height": (np.nan_to_num(heights), "m")}, (SIDE, SIDE), missing)
    return {}


def as_xyz(path: Path, heights: FloatArray) -> dict[str, str]:
    order = np.random.default_rng(2).permutation(N * N)
    write_xyz(path, 1e10 * heights, (1e6 * SIDE / N,) * 2, order)
    return {"size": "20 um, 20 um", "unit": "angstrom"}


@pytest.mark.parametrize(
    ("name", "write", "hurst", "rolloff"),
    [
        ("scan.npy", as_npy, 0.3, 8.0),
        ("scan.csv", as_text, 0.5, 6.0),
        ("scan.x3p", as_x3p, 0.7, 8.0),
        ("scan.gwy", as_gwy, 0.8, 5.0),
        ("scan.xyz", as_xyz, 0.9, 10.0),
    ],
)
def test_the_law_is_found_again(
    name: str,
    write: Callable[[Path, FloatArray], dict[str, str]],
    hurst: float,
    rolloff: float,
    tmp_path: Path,
) -> None:
    heights, rms = spoiled(hurst, rolloff)
    said = write(tmp_path / name, heights)
    found = rb.characterize(
        tmp_path / name,
        detrend="plane",
        fill=0.05,
        size=said.get("size"),
        unit=said.get("unit"),
    )
    assert found.raw.points == (N, N)
    assert found.raw.size == pytest.approx((SIDE, SIDE), rel=1e-6)
    assert found.raw.missing == pytest.approx(float(np.isnan(heights).mean()), abs=1e-12)
    assert found.fit is not None
    assert found.fit.hurst == pytest.approx(hurst, abs=0.05)
    assert found.fit.rms_slope == pytest.approx(0.1, rel=0.02)
    assert found.prepared.Sq == pytest.approx(rms, rel=0.01)


def test_the_written_spec_is_one(tmp_path: Path) -> None:
    heights, _ = spoiled(0.8, 8.0)
    as_x3p(tmp_path / "scan.x3p", heights)
    found = rb.characterize(tmp_path / "scan.x3p", detrend="plane", fill=0.05, edges="mirror")
    text = spec_text(found, tmp_path)
    assert "path: scan.x3p" in text
    (tmp_path / "scan.yaml").write_text(text, encoding="utf-8")
    cells = plan(load_spec(tmp_path / "scan.yaml"))
    assert dict.fromkeys(cell.experiment for cell in cells) == {"scan": None, "twins": None}
    assert warnings(cells) == []
    known = cells[0].heights
    assert known is not None
    assert known.rms_height == pytest.approx(found.prepared.Sq, rel=1e-12)
