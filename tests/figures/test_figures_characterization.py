"""The picture of a characterized scan: what is on its axes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import StepPatch

import roughbench as rb
from roughbench.errors import StoreError
from roughbench.figures.characterization import check_picture, draw, draw_picture
from roughbench.figures.style import publication_style
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator


def heights() -> np.ndarray:
    law = self_affine(hurst=0.7, q_min=1e6, q_rolloff=4e6, q_max=32e6, rms_slope=0.1)
    return make_surface(law, 128, 2e-6 * np.pi, realization_generator(0, 0))


def test_map_spectrum_and_distribution() -> None:
    found = rb.characterize(heights(), size=2e-6 * np.pi, edges="periodic", detrend="mean")
    with publication_style():
        chart, spectrum, distribution, bar = draw(found).axes
    assert chart.get_xlabel() == "$x$ (µm)"
    assert bar.get_ylabel() == "height (nm)"
    assert chart.get_images()[0].get_extent() == pytest.approx(
        (0.0, 6.283, 6.283, 0.0), abs=1e-3
    )
    q, law = next(
        line for line in spectrum.get_lines() if np.size(line.get_xdata()) == 200
    ).get_data()
    assert found.fit is not None
    exact = found.fit.spectrum().psd_2d(np.asarray(q) * 1e6) * 1e36
    assert np.asarray(law) == pytest.approx(exact, rel=1e-9)
    assert spectrum.get_xlabel() == "wavevector $q$ (1/µm)"
    patch = distribution.patches[0]
    assert isinstance(patch, StepPatch)
    density, edges, _ = patch.get_data()
    area = np.nansum(density * np.diff(edges))
    assert area == pytest.approx(1.0, abs=1e-6)


def test_without_a_law_and_with_holes(tmp_path: Path) -> None:
    noise = 1e-9 * np.random.default_rng(0).standard_normal((64, 96))
    noise[3:9, 4:7] = np.nan
    found = rb.characterize(noise, size="1 um, 2 um")
    for name in ("a.png", "a.pdf"):
        drawn = draw_picture(found, tmp_path / name)
        first = drawn.read_bytes()
        assert draw_picture(found, tmp_path / name).read_bytes() == first  # the same bytes


def test_what_cannot_be_a_picture_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match=r"\.png, \.pdf or \.svg"):
        check_picture(tmp_path / "a.jpeg")
    (tmp_path / "a.png").write_bytes(b"mine")
    with pytest.raises(StoreError, match="choose another name"):
        check_picture(tmp_path / "a.png")
