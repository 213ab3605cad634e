"""Wavelengths in the place of wavevectors, in specs with units."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from roughbench.errors import UnitError
from roughbench.spec.tree import (
    Finding,
    assign,
    show,
)
from roughbench.units import to_si

WAVELENGTHS = {"longest": "q0", "rolloff": "qr", "shortest": "q1"}
"""Key of a wavelength → key of the wavevector 2π/λ."""
OF_WAVES = {
    "longest": "Longest wavelength of the roughness, 2π/q0, with its unit.",
    "rolloff": "Wavelength of the roll-off, 2π/qr, with its unit; default: the longest.",
    "shortest": "Shortest wavelength of the roughness, 2π/q1, with its unit.",
}
"""Key of a wavelength → its description."""


def as_wavevectors(
    surface: Mapping[str, Any],
) -> tuple[list[tuple[str, str, float]], list[Finding]]:
    """Return wavelengths as wavevectors: key, key of the wavevector, value in 1/m."""
    replaced: list[tuple[str, str, float]] = []
    findings = []
    lengths: dict[str, float] = {}
    for key, wavevector in WAVELENGTHS.items():
        if key not in surface or surface.get("kind", "self-affine") != "self-affine":
            continue
        path, value = ("surface", key), surface[key]
        if wavevector in surface:
            message = f"says the same as {wavevector} = 2π/{key}; remove one of them"
            findings.append(Finding(path, message, "key"))
        if not isinstance(value, str):
            if not isinstance(value, (int, float)) or isinstance(value, bool):
                message = f"must be a length, such as '10 um', got {show(value)}"
                findings.append(Finding(path, message))
            replaced.append((key, wavevector, math.nan))
            continue
        try:
            length = to_si(value, "length")
            if not length > 0.0:
                raise UnitError(f"must be greater than 0, got {value!r}")
        except UnitError as error:
            findings.append(Finding(path, error.reason))
            replaced.append((key, wavevector, math.nan))
            continue
        lengths[key] = length
        replaced.append((key, wavevector, 2.0 * math.pi / length))
    findings += _out_of_order(surface, lengths)
    return replaced, findings


def _out_of_order(
    surface: Mapping[str, Any], lengths: Mapping[str, float]
) -> Iterator[Finding]:
    for short, long, allowed in (
        ("rolloff", "longest", "at most"),
        ("shortest", "rolloff", "less than"),
        ("shortest", "longest", "less than"),
    ):
        if short not in lengths or long not in lengths:
            continue
        equal_is_wrong = allowed == "less than"
        if lengths[short] > lengths[long] or (
            equal_is_wrong and lengths[short] == lengths[long]
        ):
            yield Finding(
                ("surface", short),
                f"must be {allowed} {long} = {surface[long]}, got {surface[short]}",
            )
            return


def with_wavevector(
    tree: Mapping[str, Any], old: str, new: str, value: float
) -> Mapping[str, Any]:
    """Return a tree with a wavevector in the place of a wavelength."""
    surface = {key: entry for key, entry in tree["surface"].items() if key != old}
    return dict(assign({**tree, "surface": surface}, ("surface", new), value))
