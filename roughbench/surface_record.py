"""What results remember of a measured surface that was pressed, in SI units."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.spectrum import self_affine

FloatArray = NDArray[np.float64]

MOST_POINTS = 256
"""Points of the recorded map per side: enough for a picture of it."""


class RecordedStep(NamedTuple):
    """One step of the preparation, and the surface after it.

    Attributes
    ----------
    name, text : str
        Of the step, and what it did, in one line.
    points : tuple of int
        Rows and columns.
    Sq, Sdq : float
        Rms height (m) and rms gradient.
    """

    name: str
    text: str
    points: tuple[int, ...]
    Sq: float
    Sdq: float


PREFIX = "surface_"
"""Of its variables and attributes, in the group of an experiment's first model."""

_ARRAYS = ("surface_map", "surface_q", "surface_psd", "surface_height", "surface_density")
DESCRIBED = {
    "surface_y": (("surface_y",), "m", "position along y in the map of the surface"),
    "surface_x": (("surface_x",), "m", "position along x in the map of the surface"),
    "surface_q": (("surface_q",), "1/m", "wavevectors of the surface's spectrum"),
    "surface_height": (("surface_height",), "m", "heights"),
    "surface_map": (("surface_y", "surface_x"), "m", "heights as pressed, thinned to a map"),
    "surface_psd": (("surface_q",), "m^4", "power spectrum C2D of the surface"),
    "surface_density": (("surface_height",), "1/m", "probability density of the heights"),
}
"""Dimensions, unit and description of its arrays in a file, dimension scales first."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceRecord:
    """A surface as it was pressed, small enough to be kept beside the curves.

    Attributes
    ----------
    heights : ndarray of float64, shape (n, m)
        At most :data:`MOST_POINTS` per side, thinned from those that were pressed; m.
    size : (float, float)
        Of the pressed cell along y (rows) and x (columns), m.
    spectrum : (ndarray of float64, ndarray of float64), shape (K,)
        Wavevectors q (1/m), ascending, and the radially averaged C2D (m⁴).
    fit : mapping of str to float, or None
        The self-affine law of the spectrum: ``H``, ``q0``, ``qr``, ``q1`` (1/m), ``slope``
        and their errors, ``H_error`` and so on; None where no such law fits.
    height_density : (ndarray of float64, ndarray of float64), shape (B,)
        Middle of each bin (m), ascending and equally wide, and the probability density of
        the heights in it (1/m).
    steps : sequence of RecordedStep
        From the file to the pressed surface; the first is as read.
    parameters : mapping of str to float
        The surface in numbers, SI: ``Sa``, ``Sq``, ``Ssk``, ``Sku``, ``Sdq``, ``Sdr`` …
    warnings : sequence of str
        What makes an answer doubtful: one sentence each.
    source : str
        Name of the file.
    """

    heights: FloatArray
    size: tuple[float, float]
    spectrum: tuple[FloatArray, FloatArray]
    fit: Mapping[str, float] | None
    height_density: tuple[FloatArray, FloatArray]
    steps: Sequence[RecordedStep]
    parameters: Mapping[str, float]
    warnings: Sequence[str]
    source: str = ""

    def arrays(self) -> dict[str, FloatArray]:
        """Return its arrays by the names that they have in a file."""
        found = (self.heights, *self.spectrum, *self.height_density)
        arrays = dict(zip(_ARRAYS, found, strict=True))
        for axis, n, side in zip("yx", self.heights.shape, self.size, strict=True):
            arrays[f"surface_{axis}"] = side / n * np.arange(n, dtype=np.float64)
        return {name: arrays[name] for name in DESCRIBED}

    def attributes(self) -> dict[str, str | float]:
        """Return the rest of it, as attributes of a file know it."""
        texts = {
            "steps": [[*step[:2], [*step.points], *step[3:]] for step in self.steps],
            "fit": None if self.fit is None else dict(self.fit),
            "parameters": dict(self.parameters),
            "warnings": [*self.warnings],
            "source": self.source,
        }
        found: dict[str, str | float] = {
            f"{PREFIX}{name}": json.dumps(value, ensure_ascii=False, allow_nan=False)
            for name, value in texts.items()
        }
        sides = zip(("size_y", "size_x"), self.size, strict=True)
        return found | {f"{PREFIX}{name}": side for name, side in sides}

    @classmethod
    def of(
        cls, arrays: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]
    ) -> SurfaceRecord:
        """Return the record that :meth:`arrays` and :meth:`attributes` were made of.

        Raises
        ------
        ValueError, KeyError, TypeError
            If they were not.
        """
        heights, q, psd, height, density = (
            np.asarray(arrays[name], np.float64) for name in _ARRAYS
        )
        if heights.ndim != 2 or q.shape != psd.shape or height.shape != density.shape:
            raise ValueError("the record of the surface has arrays of other shapes")
        said = {
            name: json.loads(str(attributes[f"{PREFIX}{name}"]))
            for name in ("steps", "fit", "parameters", "warnings", "source")
        }
        steps = tuple(
            RecordedStep(str(name), str(text), (*map(int, points),), float(Sq), float(Sdq))
            for name, text, points, Sq, Sdq in said["steps"]
        )
        fit = said["fit"]
        return cls(
            heights=heights,
            size=(
                float(attributes[f"{PREFIX}size_y"]),
                float(attributes[f"{PREFIX}size_x"]),
            ),
            spectrum=(q, psd),
            fit=None if fit is None else _numbers(fit),
            height_density=(height, density),
            steps=steps,
            parameters=_numbers(said["parameters"]),
            warnings=tuple(map(str, said["warnings"])),
            source=str(said["source"]),
        )


def _numbers(values: Mapping[str, Any]) -> dict[str, float]:
    return {str(name): float(value) for name, value in values.items()}


def fitted_spectrum(
    fit: Mapping[str, float] | None,
) -> tuple[FloatArray, FloatArray] | None:
    """Return q (1/m) and C2D (m⁴) of the self-affine law, from q0 to q1; None without one."""
    if fit is None:
        return None
    try:
        law = self_affine(
            hurst=fit["H"],
            q_min=fit["q0"],
            q_rolloff=max(fit["qr"], fit["q0"]),
            q_max=fit["q1"],
            rms_slope=fit["slope"],
        )
    except SurfaceError:  # a fit may end at H = 1, which is no self-affine law
        return None
    q = np.repeat(law.edges, 2)[1:-1]
    power = np.repeat(law.prefactors, 2) * q ** -np.repeat(law.exponents, 2)
    return q, power
