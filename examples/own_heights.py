"""Contact of heights of your own: area, separation and stiffness over the pressure.

    python examples/own_heights.py [HEIGHTS.npy LENGTH]

HEIGHTS.npy holds a square array of heights on one period, LENGTH its side in the same unit.
Without it, a surface of this script's own is pressed.
"""

from __future__ import annotations

import sys

import numpy as np

import roughbench as rb
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator


def main(arguments: list[str]) -> None:
    """Press the heights and print the curve."""
    if arguments:
        heights, length = np.load(arguments[0]), float(arguments[1])
    else:
        length = 2.0 * np.pi
        spectrum = self_affine(hurst=0.7, q_min=1.0, q_rolloff=4.0, q_max=16.0, rms_slope=0.1)
        heights = make_surface(spectrum, 64, length, realization_generator(1, 0))
    pressures = np.geomspace(1e-3, 0.1, 5)  # in units of the contact modulus E*
    curve = rb.solve_curve(heights, pressures, length=length)
    print("  p/E*       A/A0       ū        K/E*    status")
    for row in zip(
        pressures, curve.area, curve.separation, curve.stiffness, curve.status, strict=True
    ):
        print("{:8.1e}  {:8.4f}  {:8.5f}  {:8.3f}  {:4d}".format(*row))


if __name__ == "__main__":
    main(sys.argv[1:])
