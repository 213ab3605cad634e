"""Doors to other codes; against the codes themselves: make compare-conventions."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench import neighbours

ROOT = Path(rb.__file__).parents[1]
HEIGHTS = np.arange(12.0).reshape(3, 4)


def test_every_line_of_the_page_is_checked_and_every_check_has_a_line() -> None:
    page = (ROOT / "docs" / "conventions.md").read_text(encoding="utf-8")
    script = (ROOT / "scripts" / "peers" / "conventions.py").read_text(encoding="utf-8")
    first = [row.split("|")[1] for row in page.splitlines() if row.startswith("| `")]
    described = set(re.findall(r"`((?:st|cm|tamaas|aspher)-[\w-]+)`", " ".join(first)))
    checked = set(re.findall(r'"((?:st|cm|tamaas|aspher)-[\w-]+)"', script))
    for code in re.findall(r'case\.apart\("(\w+)"', script):
        checked |= {f"{code}-{end}" for end in re.findall(r'f"\{key\}-([\w-]+)"', script)}
    assert described == checked
    assert len(checked) > 20


class Topography:
    """As SurfaceTopography's: the first axis is x."""

    is_periodic, unit = True, "nm"
    physical_sizes: Any = (8.0, 3.0)

    def __init__(self, heights: Any = HEIGHTS.T) -> None:
        self._heights = heights

    def heights(self) -> Any:
        return self._heights


class System:
    """As ContactMechanics', of which a free half-space is padded."""

    offset = 0.5

    def __init__(self, force: Any, disp: Any) -> None:
        self.force, self.disp = force, disp
        self.surface = Topography()
        self.surface.is_periodic = False  # of no account: its system says what happens
        self.substrate = SimpleNamespace(young=2.0)


class Model(dict[str, Any]):
    """As Tamaas'."""

    traction, displacement = HEIGHTS, HEIGHTS
    system_size, E_star = (3.0, 8.0), 2.0


def test_heights_are_turned() -> None:
    surface = neighbours.surface_of(Topography())
    np.testing.assert_array_equal(surface.heights, HEIGHTS)
    assert (surface.size, surface.unit) == ((3.0, 8.0), "nm")
    assert surface.heights.flags.c_contiguous


def test_a_topography_and_back() -> None:
    pytest.importorskip("SurfaceTopography")
    for heights, size in ((HEIGHTS, (3.0, 8.0)), (HEIGHTS[0], (5.0,))):
        made = neighbours.topography(heights, size, "um")
        found = neighbours.surface_of(made)
        np.testing.assert_array_equal(found.heights, heights)
        assert (found.size, found.unit) == (size, "um")
    assert neighbours.topography(HEIGHTS, 3.0).physical_sizes == (4.0, 3.0)  # square points


def test_which_heights_are_refused() -> None:
    open_ended = Topography()
    open_ended.is_periodic = False
    for bad, message in (
        (HEIGHTS, "ndarray has no heights.* arrays need no door"),
        (Topography(np.ma.masked_less(HEIGHTS, 2.0)), "2 of 12 heights are missing; fill them"),
        (Topography(HEIGHTS[0]), "no regular grid"),
        (open_ended, "not periodic, .*: mirror or taper it first"),
    ):
        with pytest.raises(rb.SurfaceError, match=message):
            neighbours.surface_of(bad)


def test_fields_of_a_system_are_turned_and_cut() -> None:
    force, disp = np.zeros((8, 6)), np.full((8, 6), 20.0)
    force[1, 2] = 4.0
    found = neighbours.fields_of(System(force, disp))
    assert found.pressure[2, 1] == 4.0 / 2.0  # a point is 2 × 1
    np.testing.assert_array_equal(found.gap, 20.0 - HEIGHTS - 0.5)
    assert (found.size, found.modulus, found.area_fraction_raw) == ((3.0, 8.0), 2.0, 1 / 12)
    assert found.nominal_pressure == pytest.approx(2.0 / 12)
    with pytest.raises(rb.SolverError, match="not solved: call its minimize_proxy"):
        neighbours.fields_of(System(None, None))


def test_fields_of_a_model_stay_as_they_lie() -> None:
    found = neighbours.fields_of(Model(gap=HEIGHTS + 1.0))
    np.testing.assert_array_equal(found.pressure, HEIGHTS)
    assert (found.mean_separation, found.size, found.modulus) == (6.5, (3.0, 8.0), 2.0)
    with pytest.raises(rb.SolverError, match="no field gap: solve it with PolonskyKeerRey"):
        neighbours.fields_of(Model())
    volume = Model(gap=HEIGHTS)
    volume.traction = np.zeros((3, 4, 3))
    with pytest.raises(rb.SolverError, match=r"shape \(3, 4, 3\): only models of normal"):
        neighbours.fields_of(volume)


def test_fields_of_a_result_and_of_a_state() -> None:
    result = SimpleNamespace(pressure=HEIGHTS, gap=HEIGHTS)
    found = neighbours.fields_of(result, length=2.0, modulus=3.0)
    assert (found.size, found.modulus) == ((2.0, 2.0), 3.0)
    with pytest.raises(rb.SolverError, match="does not know its cell: give length"):
        neighbours.fields_of(result)
    with pytest.raises(rb.SolverError, match="a list is no state of roughbench"):
        neighbours.fields_of([1.0])
    with pytest.raises(rb.SolverError, match="must be of one shape"):
        neighbours.fields_of(SimpleNamespace(pressure=HEIGHTS, gap=HEIGHTS[0]), length=1.0)
    wave = 0.01 * np.cos(2 * np.pi * np.arange(64) / 64)
    state = rb.solve_contact(wave, 0.005, length=2.0)
    ours = neighbours.fields_of(state)
    assert ours.mean_separation == pytest.approx(state.mean_separation, rel=1e-6)
    assert (ours.size, ours.area_fraction_raw) == ((2.0,), state.area_fraction_raw)
    again = rb.solve_contact(wave, 0.005, length=2.0, start=ours.pressure)
    assert again.iterations <= state.iterations


def test_arguments_for_aspher() -> None:
    heights = np.zeros((256, 256))
    heights[0, 1] = 1.0
    found = neighbours.aspher_arguments(heights, 2.0, 0.01, 3.0)
    assert found["gap"][1] == -1.0
    assert (found["grid_size"], found["coarsest"], found["domain_size"]) == (256, 64, 2.0)
    assert (found["p_nominal"], found["E_star"]) == (0.01, 3.0)
    assert neighbours.aspher_arguments(np.zeros((30, 30)), 1.0, 0.1)["coarsest"] == 30
    for heights, length in ((HEIGHTS, 1.0), (np.zeros((4, 4)), (1.0, 2.0))):
        with pytest.raises(rb.SolverError, match="ASPHER solves squares"):
            neighbours.aspher_arguments(heights, length, 0.01)


@pytest.mark.parametrize("package", ["SurfaceTopography", "ContactMechanics", "tamaas"])
def test_without_a_code_its_objects_cannot_be_made(
    monkeypatch: pytest.MonkeyPatch, package: str
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    make: dict[str, Any] = {
        "SurfaceTopography": neighbours.topography,
        "ContactMechanics": neighbours.contactmechanics_system,
        "tamaas": neighbours.tamaas_model,
    }
    with pytest.raises(rb.RoughbenchError, match=f"{package} is not installed: pip install"):
        make[package](HEIGHTS, 1.0)
    with pytest.raises(rb.SolverError, match="must have 2 sides"):
        make[package](HEIGHTS, (1.0,))
    with pytest.raises(rb.SolverError, match="a line or a surface"):
        make[package](np.zeros((2, 2, 2)), 1.0)
