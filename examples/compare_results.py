"""Compare two results files: the largest deviation of each quantity that both hold.

    python examples/compare_results.py FIRST.h5 SECOND.h5

Deviations are relative, and given in standard errors as well where both have one.
"""

from __future__ import annotations

import sys

import numpy as np

import roughbench as rb


def main(first: str, second: str) -> None:
    """Print a line for every mean that both files hold at the same pressures."""
    one, two = rb.load(first), rb.load(second)
    for experiment, models in one.items():
        for label, model in models.items():
            other = two.get(experiment, {}).get(label)
            if other is None:
                print(f"{experiment}/{label}: only in {first}")
                continue
            if not np.array_equal(model["pressure"], other["pressure"]):
                print(f"{experiment}/{label}: other pressures in {second}")
                continue
            for quantity in ("area", "separation", "stiffness"):
                name = f"{quantity}_mean"
                if name not in model.variables or name not in other.variables:
                    continue
                a, b = model[name], other[name]
                finite = np.isfinite(a) & np.isfinite(b) & (a != 0.0)
                if not finite.any():
                    continue
                a, b = a[finite], b[finite]
                worst = float(np.max(np.abs(b / a - 1.0)))
                error = np.hypot(model[f"{quantity}_sem"], other[f"{quantity}_sem"])[finite]
                known = error > 0.0  # a theory has none
                times = np.abs(b - a)[known] / error[known]
                print(
                    f"{experiment}/{label}: {quantity} {worst:.2e}"
                    + (f", {times.max():.2g} errors" if times.size else "")
                )


if __name__ == "__main__":
    main(*sys.argv[1:])
