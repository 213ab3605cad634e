"""Pressure and gap of a state as files: NumPy's .npz, and .vti for ParaView and VisIt.

Both are compressed. The .vti is VTK's XML image: points where the heights are, x along the
rows, each array in blocks of zlib in the appended part
(`VTK XML formats <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>`_).
"""

from __future__ import annotations

import io
import os
import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import StoreError
from roughbench.neighbours import PressedFields, fields_of
from roughbench.outputs import Kind, write_output
from roughbench.results import ModelResult

_COMMENT = b"roughbench field"
_BLOCK = 1 << 20
_MARK = "<!-- roughbench field -->"
FIELD_FILES = {
    ".npz": Kind("field", lambda _, tail: tail.endswith(_COMMENT)),
    ".vti": Kind("field", lambda head, _: _MARK.encode() in head),
}
"""By suffix."""


def save_fields(
    solved: Any,
    path: str | os.PathLike[str],
    *,
    length: float | tuple[float, ...] | None = None,
    modulus: float | None = None,
) -> Path:
    """Write pressure and gap of a state into a compressed file.

    Parameters
    ----------
    solved : object
        A state of :func:`roughbench.solve_contact`, or whatever
        :func:`roughbench.neighbours.fields_of` reads.
    path : path
        Ends in ``.npz`` (``pressure``, ``gap``, ``y``, ``x``, ``nominal_pressure``,
        ``mean_separation``, ``modulus``) or ``.vti`` (the same over the points of an image).
        A file that is there is replaced, if roughbench wrote it as such.
    length, modulus
        As for :func:`~roughbench.neighbours.fields_of`.

    Returns
    -------
    Path
        ``path``.

    Raises
    ------
    SolverError
        If there are no fields.
    StoreError
        If the name ends otherwise, or the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import roughbench as rb
    >>> heights = 0.01 * np.cos(2 * np.pi * np.arange(64) / 64)
    >>> state = rb.solve_contact(heights, 0.005)
    >>> path = save_fields(state, tempfile.mkdtemp() + "/state.npz")
    >>> bool((np.load(path)["pressure"] == state.pressure).all())
    True
    """
    return write_fields(fields_of(solved, length=length, modulus=modulus), path)


def write_fields(
    fields: PressedFields,
    path: str | os.PathLike[str],
    more: Mapping[str, float | str] | None = None,
) -> Path:
    """Write fields, and further numbers and texts (in a .vti numbers only), by name."""
    suffix = Path(path).suffix.lower()
    if suffix not in FIELD_FILES:
        raise StoreError(f"{Path(path).name}: fields are written as .npz or .vti; name one")
    numbers = {
        "nominal_pressure": fields.nominal_pressure,
        "mean_separation": fields.mean_separation,
        "modulus": fields.modulus,
        **(more or {}),
    }
    data = _npz(fields, numbers) if suffix == ".npz" else _vti(fields, numbers)
    return write_output(data, path, FIELD_FILES[suffix])


def saved_fields(
    result: ModelResult,
) -> Iterator[tuple[str, PressedFields, dict[str, float | str]]]:
    """Yield the fields that a run kept of a model: what they are called, they, and more.

    Without units pressures are p/E* and the modulus is 1; with them all is in SI.
    """
    if "field_pressure" not in result:
        return
    axes = [axis for axis in ("y", "x") if axis in result]
    places = [np.asarray(result[axis], float) for axis in axes]
    size = tuple(float(one[1] - one[0]) * one.size for one in places)
    for k, realization in enumerate(result["field_realization"].tolist()):
        nominal = float(result["field_nominal_pressure"][k])
        more: dict[str, float | str] = {
            "realization": float(realization),
            "given_pressure": nominal,
            "status": float(result["field_status"][k]),
            "pressure_unit": result.units("field_pressure"),
            "length_unit": result.units("field_gap"),
        }
        pressure = np.asarray(result["field_pressure"][k], float)
        gap = np.asarray(result["field_gap"][k], float)
        found = PressedFields(pressure, gap, size, result.modulus or 1.0)
        yield f"{realization}-{nominal:.6g}", found, more


def _places(fields: PressedFields) -> dict[str, NDArray[np.float64]]:
    axes = ("y", "x")[-fields.pressure.ndim :]
    return {
        axis: side / n * np.arange(n)
        for axis, side, n in zip(axes, fields.size, fields.pressure.shape, strict=True)
    }


def _npz(fields: PressedFields, numbers: Mapping[str, float | str]) -> bytes:
    arrays: dict[str, Any] = {"pressure": fields.pressure, "gap": fields.gap}
    arrays |= _places(fields) | {name: np.array(value) for name, value in numbers.items()}
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    with zipfile.ZipFile(file, "a") as archive:
        archive.comment = _COMMENT
    return file.getvalue()


def _vti(fields: PressedFields, numbers: Mapping[str, float | str]) -> bytes:
    rows, columns = np.atleast_2d(fields.pressure).shape
    height, width = (1.0, *fields.size)[-2:]
    extent = f"0 {columns - 1} 0 {rows - 1} 0 0"
    spacing = f"{width / columns!r} {height / rows!r} 1"
    appended = io.BytesIO()

    def array(name: str, values: NDArray[np.float64], more: str = "") -> str:
        offset = appended.tell()
        appended.write(_in_blocks(np.ascontiguousarray(values, "<f8").tobytes()))
        return (
            f'<DataArray type="Float64" Name={quoteattr(name)} {more}format="appended" '
            f'offset="{offset}"/>\n'
        )

    scalars = "".join(
        array(name, np.array([value], float), 'NumberOfTuples="1" ')
        for name, value in numbers.items()
        if not isinstance(value, str)
    )
    points = array("pressure", fields.pressure) + array("gap", fields.gap)
    head = (
        f'<?xml version="1.0"?>\n{_MARK}\n<VTKFile type="ImageData" version="1.0" '
        'byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor">\n'
        f'<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="{spacing}">\n'
        f"<FieldData>\n{scalars}</FieldData>\n"
        f'<Piece Extent="{extent}">\n<PointData Scalars="pressure">\n{points}</PointData>\n'
        '</Piece>\n</ImageData>\n<AppendedData encoding="raw">\n_'
    )
    return head.encode() + appended.getvalue() + b"\n</AppendedData>\n</VTKFile>\n"


def _in_blocks(data: bytes) -> bytes:
    """Return data as VTK has it compressed: numbers of blocks and bytes, then the blocks."""
    blocks = [zlib.compress(data[i : i + _BLOCK]) for i in range(0, len(data), _BLOCK)]
    sizes = [len(blocks), _BLOCK, len(data) % _BLOCK, *map(len, blocks)]
    return struct.pack(f"<{len(sizes)}Q", *sizes) + b"".join(blocks)
