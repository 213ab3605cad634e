"""Small files of topographies, written without the readers that are under test."""

from __future__ import annotations

import zipfile
from pathlib import Path

import gwyfile
import numpy as np
from numpy.typing import NDArray

from roughbench.scans.image import FloatArray

_MAIN = """<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>SUR</FeatureType>
    <Axes>
      <CX><AxisType>I</AxisType><DataType>D</DataType>
        <Increment>{dx!r}</Increment><Offset>0</Offset></CX>
      <CY><AxisType>I</AxisType><DataType>D</DataType>
        <Increment>{dy!r}</Increment><Offset>0</Offset></CY>
      <CZ><AxisType>A</AxisType><DataType>{kind}</DataType>
        <Increment>1</Increment><Offset>0</Offset></CZ>
    </Axes>
  </Record1>
  <Record3>
    <MatrixDimension>
      <SizeX>{columns}</SizeX><SizeY>{rows}</SizeY><SizeZ>1</SizeZ>
    </MatrixDimension>
    <DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink>
  </Record3>
  <Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>
</p:ISO5436_2>
"""


def write_x3p(
    path: Path, heights: FloatArray, size: tuple[float, float], *, kind: str = "D"
) -> None:
    """Write heights in m, nan where missing, as ISO 25178-72 lays them out (x runs first).

    ``kind`` is D for float64 and F for float32; ``size`` is (y, x) in m.
    """
    rows, columns = heights.shape
    main = _MAIN.format(
        dx=size[1] / columns, dy=size[0] / rows, columns=columns, rows=rows, kind=kind
    )
    data = heights.astype({"D": "<f8", "F": "<f4"}[kind])
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.xml", main)
        archive.writestr("bindata/data.bin", data.tobytes())


def write_gwy(
    path: Path,
    channels: dict[str, tuple[FloatArray, str]],
    size: tuple[float, float],
    mask: NDArray[np.bool_] | None = None,
) -> None:
    """Write channels, each values and their unit; ``mask`` marks missing ones of the first."""
    container = gwyfile.objects.GwyContainer()
    for place, (title, (values, unit)) in enumerate(channels.items()):
        container[f"/{place}/data/title"] = title
        container[f"/{place}/data"] = gwyfile.objects.GwyDataField(
            np.ascontiguousarray(values),
            xreal=size[1],
            yreal=size[0],
            si_unit_xy=gwyfile.objects.GwySIUnit(unitstr="m"),
            si_unit_z=gwyfile.objects.GwySIUnit(unitstr=unit),
        )
    if mask is not None:
        container["/0/mask"] = gwyfile.objects.GwyDataField(mask.astype(float))
    container.tofile(str(path))


def write_xyz(
    path: Path,
    heights: FloatArray,
    spacing: tuple[float, float],
    order: NDArray[np.int64],
    header: str = "",
) -> None:
    """Write x, y and height of the points that are there, in any order; spacing is (y, x)."""
    rows, columns = np.indices(heights.shape)
    points = np.stack(
        [columns.ravel() * spacing[1], rows.ravel() * spacing[0], heights.ravel()], axis=1
    )[order]
    there = np.isfinite(points[:, 2])
    lines = [" ".join(f"{number:.17g}" for number in point) for point in points[there]]
    path.write_text("\n".join([*([header] if header else []), *lines]) + "\n", encoding="utf-8")
