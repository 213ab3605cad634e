"""How the pressure at one separation goes with the size of the cell, on known curves."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from roughbench.results import ModelResult
from roughbench.verdict.sizes import size_exponent
from tests.fits.lawful import make

FEW = np.geomspace(1e-6, 1e-2, 9)
"""Half a decade apart."""


def cell(length: float, power: float, *, stiffness: bool) -> ModelResult:
    """ū = (ln x)²/100 with x = p L⁻ˢ/p_c below full contact, where the line bends most."""
    with np.errstate(divide="ignore"):
        log_x = np.minimum(np.log(FEW * length**-power / 2e-3), 0.0)
        values = {"separation": log_x**2 / 100.0, "stiffness": -FEW / (log_x / 50.0)}
    if not stiffness:
        del values["stiffness"]
    made = make({k: v[None, :] for k, v in values.items()}, "bem", length=length)
    return replace(made, variables={**made.variables, "pressure": FEW})


@pytest.mark.parametrize("power", [-1.0, 0.0, 0.5])
@pytest.mark.parametrize(("stiffness", "allowed"), [(True, 0.01), (False, 0.05)])
def test_few_pressures_tell_the_power(
    power: float,
    allowed: float,
    *,
    stiffness: bool,
) -> None:
    for middle in (3e-5, 1e-4, 3e-4, 6e-4):
        found = size_exponent(
            [cell(length, power, stiffness=stiffness) for length in (1.0, 2.0)],
            0.5 * middle,
            2.0 * middle,
            resamples=0,
        )
        assert found.value == pytest.approx(power, abs=allowed)


def test_a_separation_that_is_never_reached_has_none() -> None:
    cells = [cell(1.0, 0.0, stiffness=True), cell(1e9, 1.0, stiffness=True)]
    assert math.isnan(size_exponent(cells, 1e-4, 1e-3, resamples=0).value)
