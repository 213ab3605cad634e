"""What the results file looks like, whoever reads or writes it: versions, marks, shapes."""

from __future__ import annotations

import io
from collections.abc import Mapping

import h5py

from roughbench.outputs import ENDS, Kind
from roughbench.results import Array
from roughbench.seal import has_mark
from roughbench.variables import compare_shape

FORMAT = "roughbench"
FORMAT_VERSION = 2
"""2: with dimensions beside realization and pressure. Files without any are written as 1,
which older versions read."""
MADE_WITH = "made_with"
"""Attribute that says with what the file, or a group, was made: a mapping as JSON. One only: of
more than eight attributes HDF5 keeps the names far from the beginning of the file, where
:func:`is_results` looks for them."""
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_ATTRIBUTES = (b"format_version", b"spec_sha256")
_END_ADDRESS = slice(28, 36)
"""Where an HDF5 file says how long it is."""
_BEFORE_ATTRIBUTES = 512
"""Bytes at the beginning that hold nothing of anybody."""


def is_results(head: bytes, tail: bytes) -> bool:
    """Whether a file is one of ours, perhaps damaged at one end."""
    if has_mark(io.BytesIO(tail)):
        return True
    return head.startswith(HDF5_SIGNATURE) and all(word in head for word in _ATTRIBUTES)


def is_stump(head: bytes) -> bool:
    """Whether a file is the first bytes of an HDF5 file, too few to tell whose."""
    if not head.startswith(HDF5_SIGNATURE) or len(head) == ENDS:
        return False
    claimed = int.from_bytes(head[_END_ADDRESS], "little")
    return len(head) < _BEFORE_ATTRIBUTES or len(head) < claimed


RESULTS = Kind("results file", is_results)
RESULTS_OR_STUMP = Kind("results file", lambda h, t: is_results(h, t) or is_stump(h))
"""What a run directory lets be replaced that knows of results: also their first bytes."""


def check_shapes(variables: Mapping[str, Array | h5py.Dataset], where: str) -> None:
    """Refuse arrays whose shape does not fit those of ``status``: (realizations, pressures)."""
    shape = variables["status"].shape
    if len(shape) != 2:
        raise ValueError(f"{where}: status must have two dimensions, got {len(shape)}")
    lengths = dict(zip(("realization", "pressure"), shape, strict=True))
    for name, values in variables.items():
        suits, wanted = compare_shape(name, values.shape, lengths)
        if not suits:
            raise ValueError(
                f"{where}: {name} must have the shape {wanted}, got {values.shape}"
            )
