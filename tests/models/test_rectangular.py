"""Cells that are no square: a surface set beside itself is the same contact per area.

``length`` is the period along the first axis and pixels are square, so that n × m heights
have a cell of length × length·m/n.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.figures.spectrum import ring_average
from roughbench.models import MODELS
from roughbench.models.base import FloatArray, Sample
from roughbench.observables import OBSERVABLES, of_state
from roughbench.planning.samples import make_sample
from roughbench.report.warnings import FEWEST_CONTACT_POINTS
from roughbench.spec import load_spec
from roughbench.spectrum import measured_spectrum, self_affine
from roughbench.surface import make_surface, realization_generator, rms_height_and_slope

L = 2.0
N = 32
Q0 = 2.0 * math.pi / L
SPECTRUM = self_affine(hurst=0.7, q_min=Q0, q_rolloff=2.0 * Q0, q_max=8.0 * Q0, rms_slope=0.1)
PRESSURES = np.array([1e-4, 1e-3, 1e-2, 3e-2])
QUANTITIES = ("area", "separation", "stiffness", "energy")

H = make_surface(SPECTRUM, N, L, realization_generator(1, 0))
BESIDE = {
    "n × 2n": (np.tile(H, (1, 2)), L),
    "2n × n": (np.tile(H, (2, 1)), 2.0 * L),
    "n × 3n, transposed": (np.ascontiguousarray(np.tile(H, (1, 3)).T), 3.0 * L),
    "transposed": (np.ascontiguousarray(H.T), L),
}


def make(kind: str, **options: Any) -> Any:
    return MODELS[kind](**options)


def curve(kind: str, heights: FloatArray, length: float, **options: Any) -> Any:
    return make(kind, **options).curve(Sample(heights, length), PRESSURES)


@pytest.mark.parametrize("cell", list(BESIDE))
@pytest.mark.parametrize(
    ("kind", "options", "tolerance"),
    [
        ("bem", {"tolerance": 1e-9}, 1e-7),
        ("winkler", {}, 1e-10),
        ("gw", {"summits": "counted"}, 1e-10),
        ("gw_elliptic", {"summits": "counted"}, 1e-10),
    ],
)
def test_a_surface_beside_itself_is_the_same_contact_per_area(
    kind: str, options: dict[str, Any], tolerance: float, cell: str
) -> None:
    wanted, found = curve(kind, H, L, **options), curve(kind, *BESIDE[cell], **options)
    for name in QUANTITIES:
        np.testing.assert_allclose(
            getattr(found, name), getattr(wanted, name), rtol=tolerance, err_msg=name
        )


@pytest.mark.parametrize("cell", ["n × 2n", "2n × n"])
def test_one_asperity_carries_the_load_of_the_whole_cell(cell: str) -> None:
    """At half the pressure the load on twice the area is the same, and so is the contact."""
    heights, length = BESIDE[cell]
    wanted = make("hertz_top").curve(Sample(H, L), PRESSURES)
    found = make("hertz_top").curve(Sample(heights, length), PRESSURES / 2.0)
    np.testing.assert_allclose(2.0 * found.area, wanted.area, rtol=1e-10)
    np.testing.assert_allclose(2.0 * found.stiffness, wanted.stiffness, rtol=1e-10)
    np.testing.assert_allclose(2.0 * found.energy, wanted.energy, rtol=1e-10)
    np.testing.assert_allclose(found.separation, wanted.separation, rtol=1e-10)


def test_the_typical_top_is_that_of_the_area_of_the_cell() -> None:
    """L × 4L has as many summits as 2L × 2L, and the same load at the same pressure."""
    model = make("hertz_top", radius="spectrum")
    square = model.curve(Sample(None, 2.0 * L, SPECTRUM), PRESSURES)
    oblong = model.curve(Sample(None, L, SPECTRUM, area=4.0 * L * L), PRESSURES)
    for name in QUANTITIES:
        np.testing.assert_allclose(getattr(oblong, name), getattr(square, name), rtol=1e-14)


@pytest.mark.parametrize(
    "kind", ["persson", "bgt", "gw", "gw_elliptic", "winkler", "hertz_top"]
)
def test_theories_do_not_care_which_axis_is_the_first(kind: str) -> None:
    options = {"winkler": {"heights": "gaussian"}, "hertz_top": {"radius": "spectrum"}}
    model = make(kind, **options.get(kind, {}))
    heights = H[: N // 2] - H[: N // 2].mean()
    curves = [
        model.curve(Sample(None, length, measured_spectrum(h, length), L * L / 2.0), PRESSURES)
        for h, length in ((heights, L / 2.0), (heights.T, L))
    ]
    for name in QUANTITIES:
        np.testing.assert_allclose(
            getattr(curves[0], name), getattr(curves[1], name), rtol=1e-10, err_msg=name
        )


@pytest.mark.parametrize("cell", list(BESIDE))
def test_measures_of_the_heights(cell: str) -> None:
    heights, length = BESIDE[cell]
    np.testing.assert_allclose(
        rms_height_and_slope(heights, length), rms_height_and_slope(H, L), rtol=1e-10
    )
    measured = measured_spectrum(heights, length)
    assert measured.rms_height == pytest.approx(SPECTRUM.rms_height, rel=0.3)
    assert measured.rms_height == pytest.approx(measured_spectrum(H, L).rms_height, rel=1e-12)
    # The shells are as wide as 2π over the longest side: the second moment sees them.
    assert measured.rms_slope == pytest.approx(measured_spectrum(H, L).rms_slope, rel=1e-2)


@pytest.mark.parametrize("cell", list(BESIDE))
def test_observables_of_fields(cell: str) -> None:
    heights, length = BESIDE[cell]
    cells = heights.size / H.size
    fields = []
    for h, side in ((H, L), (heights, length)):
        state = rb.solve_contact(h, 0.003, length=side, threads=1, tolerance=1e-10)
        fields.append(of_state(state, side, SPECTRUM))
    for name, observable in OBSERVABLES.items():
        wanted, found = (observable(field) for field in fields)
        for key, value in wanted.scalars.items():
            per_cell = {"number": cells, "perimeter": cells, "mean_area": 1.0 / cells}
            factor = (per_cell | {"largest_area": 1.0 / cells}).get(key, 1.0)
            np.testing.assert_allclose(
                found.scalars[key],
                factor * value,
                rtol=1e-6,
                atol=1e-12,
                err_msg=f"{name} {key}",
            )
        if name.endswith("_pdf"):
            np.testing.assert_allclose(found.values, wanted.values, rtol=1e-9)


def test_the_periodogram_in_the_figure_of_spectra() -> None:
    heights = np.tile(H, (1, 2))
    q, power = ring_average(Sample(heights, L, SPECTRUM))
    turned_q, turned = ring_average(Sample(heights.T, 2.0 * L, SPECTRUM))
    # Modes on the edge of the half plane count with their mirror images, 1 of 8 in the worst
    # ring; with the area of a square cell one of the two would be 4 times the other.
    np.testing.assert_allclose(turned_q, q, rtol=0.01)
    np.testing.assert_allclose(turned, power, rtol=0.13)


@pytest.mark.parametrize("axis", [0, 1])
def test_heights_from_a_file(tmp_path: Path, axis: int) -> None:
    """Results say both numbers of points; spectra know the area of the cell."""
    heights = np.tile(H, (2, 1) if axis == 0 else (1, 2))
    np.save(tmp_path / "h.npy", heights)
    length = 2.0 * L if axis == 0 else L
    results = rb.run(
        {
            "name": "rectangle",
            "surface": {"kind": "file", "path": str(tmp_path / "h.npy"), "length": length},
            "pressures": [1e-3, 1e-2],
            "models": [{"kind": "bem"}, {"kind": "persson"}],
        },
        threads=1,
    )
    attributes = results["main"]["bem"].attributes
    assert (attributes["grid_points"], attributes["grid_columns"]) == heights.shape
    assert "grid_columns" not in results["main"]["persson"].attributes
    assert results["main"]["bem"]["area"][0, 1] * heights.size > FEWEST_CONTACT_POINTS


@pytest.mark.parametrize("axis", [0, 1])
def test_a_theory_gets_the_area_of_the_cell(tmp_path: Path, axis: int) -> None:
    np.save(tmp_path / "h.npy", np.tile(H, (2, 1) if axis == 0 else (1, 2)))
    spec = load_spec(
        {
            "surface": {
                "kind": "file",
                "path": str(tmp_path / "h.npy"),
                "length": 2.0 * L if axis == 0 else L,
            },
            "pressures": [1e-3],
            "models": [{"kind": "hertz_top", "radius": "spectrum"}],
        }
    )
    sample = make_sample(spec.surface, spec.models[0], 1, 0)
    assert sample.heights is None
    assert sample.nominal_area == pytest.approx(2.0 * L * L, rel=1e-15)
