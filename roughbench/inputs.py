"""Numbers and arrays as callers give them: what is refused, and what it is told."""

from __future__ import annotations

import math
import numbers
import operator
import reprlib
from decimal import Decimal
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench import memory
from roughbench.errors import RoughbenchError, SolverError

Refusal = type[RoughbenchError]
Numbers = NDArray[Any]

# -- one of several ------------------------------------------------------------------------


def exactly_one(error: Refusal = SolverError, **given: object) -> None:
    """Refuse anything but one argument that is not None.

    Raises
    ------
    RoughbenchError
        Of the class ``error``, with the names of the arguments.

    Examples
    --------
    >>> exactly_one(pressure=None, force=2.0)
    >>> exactly_one(area=1.0, force=2.0)
    Traceback (most recent call last):
        ...
    roughbench.errors.SolverError: give exactly one of area and force, got area and force
    """
    named = [name for name, value in given.items() if value is not None]
    if len(named) != 1:
        *others, last = given
        raise error(
            f"give exactly one of {', '.join(others)} and {last}, got "
            + (" and ".join(named) or "none of them")
        )


# -- one number ----------------------------------------------------------------------------


def real_number(value: object, name: str, error: Refusal = SolverError) -> float:
    """Return a real number as a float.

    Raises
    ------
    RoughbenchError
        Of the class ``error``, naming the argument: for None, texts, sequences, truth
        values, complex and masked numbers.

    Examples
    --------
    >>> real_number(np.float32(0.5), "length")
    0.5
    >>> real_number("1 um", "length")
    Traceback (most recent call last):
        ...
    roughbench.errors.SolverError: length must be a number, got '1 um'
    """
    number = _scalar(value)
    if not _is_real(number):
        raise error(f"{name} must be a number, got {reprlib.repr(value)}")
    try:
        return float(number)  # type: ignore[arg-type]
    except OverflowError:
        raise error(
            f"{name} must be a number that float64 can hold, got {reprlib.repr(value)}"
        ) from None


def positive_number(value: object, name: str, error: Refusal = SolverError) -> float:
    """Return a positive, finite number as a float; else as :func:`real_number`."""
    number = real_number(value, name, error)
    if not 0.0 < number < math.inf:
        raise error(f"{name} must be a positive number, got {number}")
    return number


def whole_number(value: object, name: str, least: int = 1, error: Refusal = SolverError) -> int:
    """Return a whole number of at least ``least`` as an int; 2.0 is none."""
    number = _scalar(value)
    if isinstance(number, bool | np.bool_) or not isinstance(number, numbers.Integral):
        raise error(f"{name} must be a whole number, got {reprlib.repr(value)}")
    if number < least:
        raise error(f"{name} must be at least {least}, got {number}")
    return operator.index(number)


def _scalar(value: object) -> object:
    """Take a number out of an array without dimensions."""
    return value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value


def _is_real(value: object) -> bool:
    return isinstance(value, numbers.Real | Decimal) and not isinstance(value, bool)


# -- arrays --------------------------------------------------------------------------------


def real_array(
    values: ArrayLike, name: str, error: Refusal = SolverError, *, kinds: str = "uif"
) -> Numbers:
    """Return real numbers as an array of the type that they have, without looking at them.

    A masked array is taken for what it holds, if none of its points is masked.

    Parameters
    ----------
    values : array_like
    name : str
        What they are, in the plural.
    error : type of RoughbenchError
    kinds : str
        Kinds of numbers that will do, as :attr:`numpy.dtype.kind` names them.

    Raises
    ------
    RoughbenchError
        Of the class ``error``: for masked points, and for anything but real numbers.
    """
    masked, size = _count_masked(values)
    if masked:
        raise error(
            f"{name} must not be masked, got {masked} of {size} masked; fill or crop them "
            "first: what stands behind the mask is no measurement"
        )
    try:
        array = np.asarray(values)
    except ValueError as fault:
        raise error(f"{name} must be a rectangular array: {fault}") from fault
    if array.dtype.kind == "O" and array.size and all(map(_is_real, array.flat)):
        array = array.astype(np.float64)
    if array.dtype.kind not in kinds:
        raise error(f"{name} must be real numbers, got dtype {array.dtype}")
    return array


def float_array(
    values: ArrayLike, name: str, error: Refusal = SolverError, *, kinds: str = "uif"
) -> NDArray[np.float64]:
    """Return real numbers as float64, copied only if need be; see :func:`real_array`."""
    with np.errstate(over="ignore"):  # of wider floats; infinity is refused as such
        return real_array(values, name, error, kinds=kinds).astype(np.float64, copy=False)


def _count_masked(values: object) -> tuple[int, int]:
    """Masked points, and all points, of masked arrays, also within lists."""
    if isinstance(values, np.ma.MaskedArray):
        if values.dtype.names is not None:  # no numbers at all: refused for that
            return 0, 0
        return int(np.count_nonzero(values.mask)), values.size
    if isinstance(values, list | tuple):
        counts = [
            _count_masked(part)
            for part in values
            if isinstance(part, list | tuple | np.ma.MaskedArray)
        ]
        return sum(count for count, _ in counts), sum(size for _, size in counts)
    return 0, 0


# -- heights -------------------------------------------------------------------------------

BYTES_PER_POINT = 72
"""Of memory that a model takes which does not iterate; measured: 70 (winkler)."""

_WORTH_ASKING = 1 << 26
"""Bytes; to ask the system for its memory takes as long as a short curve."""

LARGEST_ROUNDING = 0.003
"""Most that rounding may be of the differences between neighbours, both as rms values.

Measured on rough surfaces whose heights were rounded (256² and 512² points, p = 0.003 to
0.03 E*): at 0.003 area and stiffness move by less than 0.1 %, at 0.01 by up to 0.3 %, at 0.1
by up to 1.5 %, at 0.3 by 8 %."""

_BLOCK = 1 << 20


def check_heights(
    heights: Numbers,
    fault: str = "heights must be finite",
    error: Refusal = SolverError,
    *,
    per_point: int = BYTES_PER_POINT,
) -> None:
    """Refuse heights that no model can compute with, whatever it makes of them.

    Parameters
    ----------
    heights : ndarray of real numbers, shape (n,) or (n, m)
        As they were given: a type with fewer digits must not have been widened yet.
    fault : str
        What to say of heights that are not finite.
    error : type of RoughbenchError
    per_point : int
        Bytes of memory that will be needed for each; 0 where that was checked before.

    Raises
    ------
    RoughbenchError
        Of the class ``error``: if they are too many for the memory, before any is looked at;
        if heights are not finite, if the sum of their squares would
        leave the range of float64, or if they are stored too coarsely for what they show,
        as roughness on a large mean in float32 is.
    """
    if heights.size == 0:
        return
    wanted = per_point * heights.size
    if wanted > _WORTH_ASKING:
        memory.check(
            wanted,
            f"{heights.size} heights need about {memory.gigabytes(wanted)}",
            lambda room: f"{room // per_point} points would fit",
            error,
        )
    with np.errstate(invalid="ignore"):
        low, high = float(heights.min()), float(heights.max())  # nan passes through both
    if not (math.isfinite(low) and math.isfinite(high)):
        place = np.unravel_index(int(np.argmin(np.isfinite(heights))), heights.shape)
        raise error(
            f"{fault}, got {heights[place]} at index {tuple(map(int, place))}; fill or crop "
            "missing points first"
        )
    spread = high - low
    largest = math.sqrt(np.finfo(np.float64).max / heights.size) / 4.0
    if spread != 0.0 and not _SMALLEST < spread < largest:
        raise error(
            f"heights between {low:g} and {high:g} are out of the range of float64, in which "
            f"their squares are added up: highest and lowest must be {_SMALLEST:g} to "
            f"{largest:.0e} apart; choose another unit of length"
        )
    if spread > 0.0 and heights.dtype.kind == "f":
        _check_digits(heights, max(-low, high), spread, error)


_SMALLEST = 1e-153
"""Its square is still a float64 of all digits."""


def _check_digits(heights: Numbers, top: float, spread: float, error: Refusal) -> None:
    """Refuse heights whose rounding is a large part of what neighbours differ by."""
    dtype, shape = heights.dtype, heights.shape
    # From the lowest point to the highest lead at most Σn steps, so the differences cannot
    # be smaller than this: heights of float64 hardly ever need a closer look.
    least = spread / math.sqrt(float(sum(shape)) * heights.size)
    if _rounding(top, heights) <= LARGEST_ROUNDING * least:
        return
    rows = heights.reshape(shape[0], -1)
    step = max(1, _BLOCK // rows.shape[1])
    total = squares = differences = 0.0
    enough = (_rounding(top, heights) / (LARGEST_ROUNDING * top)) ** 2 * heights.size
    for first in range(0, shape[0], step):
        h = rows[first : first + step + 1].astype(np.float64)
        h /= top
        differences += float(np.square(np.diff(h, axis=0)).sum())
        h = h[:step]
        differences += float(np.square(np.diff(h, axis=1)).sum())
        if differences >= enough:  # whatever the rest is: mostly after the first block
            return
        total += float(h.sum())
        squares += float(np.square(h).sum())
    difference = top * math.sqrt(differences / heights.size)
    # The last digit of most heights, not of the highest.
    rounding = _rounding(top * math.sqrt(squares / heights.size), heights)
    if rounding <= LARGEST_ROUNDING * difference:
        return
    remedy = "subtract the mean before they are stored"
    if dtype.itemsize < 8:
        remedy += (
            f" as {dtype}, or convert them to float64 to compute with the digits that are left"
        )
    raise error(
        f"heights of {dtype} with a mean of {top * total / heights.size:.6g} are too coarse: "
        f"neighbours differ by {difference:.2g} (rms), {rounding:.2g} of it from rounding, "
        f"which may be {LARGEST_ROUNDING:.1%} at most (that moves the area by 0.1 %); {remedy}"
    )


def _rounding(size: float, heights: Numbers) -> float:
    """Rms difference between neighbours that the rounding of numbers of this size makes."""
    spacing = float(np.spacing(np.asarray(size, heights.dtype)))
    return spacing * math.sqrt(heights.ndim / 6.0)
