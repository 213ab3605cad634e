"""Synthetic results with known laws, for fits and verdicts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.ensemble import summarize
from roughbench.results import ModelResult, Results

FloatArray = NDArray[np.float64]
P = np.geomspace(1e-10, 0.1, 46)
HURST, HEIGHT, SLOPE, LENGTH, ROLLOFF = 0.7, 0.005, 0.1, 2 * math.pi, 8.0
KAPPA, U0, P0, THETA = 2.0, 0.4 * HEIGHT, 0.04, 2.3
SHARE = 1 / (1 + HURST)


def make(
    values: Mapping[str, FloatArray],
    kind: str = "bem",
    label: str = "",
    status: Any = None,
    **more: Any,
) -> ModelResult:
    """Return the results of a model from arrays (realization, pressure)."""
    shape = next(iter(values.values())).shape
    states = np.zeros(shape, np.int32) if status is None else np.asarray(status, np.int32)
    variables: dict[str, Any] = {"pressure": P, "status": states, **values}
    variables["rms_height"] = np.full(shape[0], HEIGHT)
    for name, array in values.items():
        variables[f"{name}_mean"] = summarize(array, states == 0).mean
    attributes: dict[str, Any] = {
        "rms_height": HEIGHT,
        "rms_slope": SLOPE,
        "length": LENGTH,
        "hurst": HURST,
        "q_rolloff": ROLLOFF,
        "q_max": 1e9,
        "grid_points": 512,
    }
    return ModelResult(label or kind, kind, kind, attributes | more, variables)


def collect(*models: ModelResult) -> Results:
    return Results({"main": {model.label: model for model in models}}, "no spec", "")


def finite_size(p: FloatArray) -> FloatArray:
    base = HEIGHT / (LENGTH**2 * ROLLOFF)
    return np.asarray(THETA / HEIGHT * base ** (1 - SHARE) * p**SHARE)


CROSSING = float(P[np.argmin(np.abs(finite_size(P) * U0 / P - 1))])


def lawful(scatter: FloatArray) -> dict[str, FloatArray]:
    """Curves that follow the laws exactly, but for a factor of each realization.

    A = κp/ξ up to p = 0.01, half of it beyond; ū = u0 ln(p0/p); K the larger of p/u0 and
    eq. (10).
    """
    factor = 1.0 + scatter[:, None]
    area = np.where(P < 0.0101, 1.0, 0.5) * KAPPA * P / SLOPE * factor
    separation = np.broadcast_to(U0 * np.log(P0 / P), area.shape) * factor
    stiffness = np.maximum(P / U0, finite_size(P)) * factor
    return {"area": area, "separation": separation, "stiffness": stiffness}
