"""What is refused before heights are read: files that are not there, shapes, sizes."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from roughbench import memory
from roughbench.errors import SurfaceError, explained
from roughbench.text import file_meant, on_one_line

_FEWEST = 4
"""Points per side: fewer carry no wave but the one that alternates from point to point."""


def check_layout(shape: tuple[int, ...] | None, dtype: np.dtype[Any], name: str) -> None:
    """Refuse what is no array of real numbers in one or two dimensions.

    Raises
    ------
    SurfaceError
        Naming the file, the type or shape, and the remedy.
    """
    if dtype.kind not in "fiu":
        raise SurfaceError(
            f"{name}: heights must be real numbers, got the type {dtype}; save them as float64"
        )
    if shape is None or len(shape) not in (1, 2):
        raise SurfaceError(
            f"{name}: heights must have one dimension (a line) or two (a surface), "
            f"got the shape {shape}"
        )
    if min(shape) < _FEWEST:
        raise SurfaceError(
            f"{name}: heights need at least {_FEWEST} points per side, got the shape {shape}"
        )


def check_memory(shape: tuple[int, ...], dtype: np.dtype[Any], name: str) -> None:
    """Refuse what would not fit into memory, as it is in the file and in float64.

    Raises
    ------
    SurfaceError
        Naming the file and what would fit.
    """
    n_points, per_point = math.prod(shape), dtype.itemsize + 8
    memory.check(
        per_point * n_points,
        f"{name}: to read {n_points} heights takes {memory.gigabytes(per_point * n_points)}",
        lambda room: f"{room // per_point} would fit: take a coarser or smaller part",
        SurfaceError,
    )


def check_there(path: Path, name: str) -> None:
    """Refuse what is no regular file that can be read.

    Raises
    ------
    SurfaceError
        Naming the file as ``name``, and the remedy.
    """
    try:
        there = path.is_file()
    except OSError as error:
        raise SurfaceError(f"{name}: cannot be read: {explained(error)}") from error
    if not there:
        raise SurfaceError(
            f"{name}: no such file{_probably(path)}; relative paths start from "
            f"{path.parent.absolute()}"
        )
    if not os.access(path, os.R_OK):
        raise SurfaceError(f"{name}: no permission to read it; check the permissions")


def _probably(path: Path) -> str:
    """Return which file beside it was probably meant, if there is one."""
    near = file_meant(path)
    return f" (did you mean {on_one_line(near)!r}?)" if near else ""
