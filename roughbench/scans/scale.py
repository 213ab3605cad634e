"""The scale of a scan, size and unit: what its file says, and what is said of it."""

from __future__ import annotations

import math

from roughbench.errors import SurfaceError
from roughbench.scans.image import Image
from roughbench.units import in_words

_AGREEMENT = 1e-6
"""Largest relative difference between what the file says and what is given beside it."""
_ASPECT_AGREEMENT = 1e-2
"""The same for the shape of pixels, which coordinates of few digits give less exactly."""


def settled_size(
    image: Image, given: tuple[float, float] | None, unit: float | None, name: str
) -> tuple[float, float]:
    """Return the size along (y, x), in m, from the file or as given."""
    for size, who in ((image.size, "the file says"), (given, "size: says")):
        if size is not None and not all(0.0 < side < math.inf for side in size):
            raise SurfaceError(
                f"{name}: {who} {_both(size)}, which is no size of an image; it must be "
                "positive"
            )
    if image.size is None:
        if given is None:
            raise SurfaceError(_missing_keys(image, unit, name))
        _check_aspect(image, given, name)
        return given
    if given is not None and _differ(image.size, given):
        raise SurfaceError(
            f"{name}: the file says that the image is {_both(image.size)} large (x, y), size: "
            f"says {_both(given)}; leave size: out, or correct the file"
        )
    return image.size


def settled_unit(image: Image, given: float | None, name: str) -> float:
    """Return metres per unit of the heights, from the file or as given."""
    if given is not None and not 0.0 < given < math.inf:
        raise SurfaceError(f"{name}: unit: must be a positive length, got {given:g} m")
    if image.unit is None:
        if given is None:
            raise SurfaceError(_missing_keys(image, given, name, size_is_known=True))
        return given
    if given is not None and _differ((image.unit,), (given,)):
        raise SurfaceError(
            f"{name}: the file says that one unit of the heights is {_said(image.unit)}, "
            f"unit: says {_said(given)}; leave unit: out, or correct the file"
        )
    return image.unit


def _missing_keys(
    image: Image, unit: float | None, name: str, *, size_is_known: bool = False
) -> str:
    parts, keys = [], []
    if not size_is_known:
        parts.append("the size of the image")
        keys.append("size: [10 um, 10 um] (x, y)")
    if image.unit is None and unit is None:
        parts.append("the unit of the heights")
        keys.append("unit: nm")
    it = "them" if len(keys) > 1 else "it"
    return (
        f"{name}: the file does not say {' and '.join(parts)}; give {it}: {' and '.join(keys)}"
    )


def _check_aspect(image: Image, size: tuple[float, float], name: str) -> None:
    """Refuse a size that does not fit to the coordinates of the points."""
    if image.aspect is None:
        return
    rows, columns = image.values.shape
    aspect = (size[0] / rows) / (size[1] / columns)
    if abs(aspect / image.aspect - 1.0) > _ASPECT_AGREEMENT:
        raise SurfaceError(
            f"{name}: its coordinates have pixels {image.aspect:.6g} times as high as wide, "
            f"with size: {_both(size)} they would be {aspect:.6g} times as high; correct size:"
        )


def _differ(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return any(abs(a / b - 1.0) > _AGREEMENT for a, b in zip(one, other, strict=True))


def _both(size: tuple[float, float]) -> str:
    """Say a size as specs do, x first."""
    return f"[{_said(size[1])}, {_said(size[0])}]"


def _said(length: float) -> str:
    """Say a length in m with the digits that must agree."""
    return in_words(length, "m", digits=9)
