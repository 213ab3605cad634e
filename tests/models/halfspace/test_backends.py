"""The solver with FFTW and with SciPy's transforms: the same within the tolerance."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.models.halfspace.contact import ContactState
from roughbench.transform import backend, fft_backend
from tests.models.halfspace.conftest import Rough

TOLERANCE = 1e-8


@pytest.mark.parametrize(
    ("line", "given"),
    [
        (False, {"pressure": 0.01}),
        (True, {"pressure": 0.01}),
        (False, {"force": 0.05, "boundary": "free"}),
    ],
    ids=["surface", "line", "free"],
)
def test_both_solve_the_same_problem(
    rough: Rough, monkeypatch: pytest.MonkeyPatch, given: dict[str, Any], *, line: bool
) -> None:
    """To the tolerance of the iteration, not to the bit: each state with its certificate."""
    heights = rough(64, line=line)
    states: list[ContactState] = []
    for name in ("pyfftw", "scipy"):
        monkeypatch.setenv("ROUGHBENCH_FFT", name)
        states.append(
            rb.solve_contact(heights, **given, length=2 * np.pi, tolerance=TOLERANCE, threads=1)
        )
    one, other = states
    assert [state.status for state in states] == [rb.Status.CONVERGED] * 2
    assert max(state.certificate.complementarity for state in states) <= TOLERANCE
    assert 0.0 < one.area_fraction < 1.0
    assert other.area_fraction_raw == one.area_fraction_raw
    assert other.area_fraction == pytest.approx(one.area_fraction, rel=1e-6)
    assert other.mean_separation == pytest.approx(one.mean_separation, rel=1e-6)
    assert other.energy == pytest.approx(one.energy, rel=1e-6)
    assert other.stiffness() == pytest.approx(one.stiffness(), rel=1e-5)
    largest = one.pressure.max()
    assert np.abs(other.pressure - one.pressure).max() <= 1e-4 * largest
    assert (other.pressure != one.pressure).any()  # they are two computations


def test_pyfftw_where_it_can_be_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROUGHBENCH_FFT", raising=False)
    backend._fault_of_pyfftw.cache_clear()
    assert fft_backend() == "pyfftw"
    monkeypatch.setenv("ROUGHBENCH_FFT", "scipy")
    assert fft_backend() == "scipy"
    monkeypatch.setenv("ROUGHBENCH_FFT", "numpy")
    with pytest.raises(rb.RoughbenchError, match="must be pyfftw or scipy, or not set; got"):
        fft_backend()


def test_scipy_where_pyfftw_cannot_be_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROUGHBENCH_FFT", raising=False)
    monkeypatch.setitem(sys.modules, "pyfftw", None)
    backend._fault_of_pyfftw.cache_clear()
    try:
        assert fft_backend() == "scipy"
        monkeypatch.setenv("ROUGHBENCH_FFT", "pyfftw")
        with pytest.raises(rb.RoughbenchError, match=r"pip install pyfftw\), or leave"):
            fft_backend()
    finally:
        backend._fault_of_pyfftw.cache_clear()
