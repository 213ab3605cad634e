"""Fields as .npz and .vti, read back by other means than they were written."""

from __future__ import annotations

import re
import struct
import xml.etree.ElementTree as ET
import zlib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import roughbench as rb
from roughbench.cli import main
from roughbench.results import Results
from roughbench.store import write_results


def read_vti(path: Path) -> tuple[dict[str, str], dict[str, Any]]:
    """Return the attributes of the image, and its arrays by name: z, y, x."""
    data = path.read_bytes()
    place = data.index(b'<AppendedData encoding="raw">')
    start = data.index(b"_", place) + 1
    root = ET.fromstring(data[:place] + b"</VTKFile>")  # noqa: S314  (our own)
    assert root.attrib["header_type"] == "UInt64"
    assert root.attrib["compressor"] == "vtkZLibDataCompressor"
    (image,) = root
    ends = [int(one) for one in image.attrib["WholeExtent"].split()]
    shape = tuple(high - low + 1 for low, high in zip(ends[::2], ends[1::2], strict=True))[::-1]
    arrays = {}
    for one in image.iter("DataArray"):
        at = start + int(one.attrib["offset"])
        count, size, last = struct.unpack_from("<3Q", data, at)
        sizes = struct.unpack_from(f"<{count}Q", data, at + 24)
        at += 24 + 8 * count
        blocks = []
        for number, length in enumerate(sizes):
            blocks.append(zlib.decompress(data[at : at + length]))
            is_last = number == count - 1
            assert len(blocks[-1]) == (last if is_last and last else size)
            at += length
        values = np.frombuffer(b"".join(blocks), "<f8")
        arrays[one.attrib["Name"]] = (
            float(values[0]) if one.get("NumberOfTuples") == "1" else values.reshape(shape)
        )
    return image.attrib, arrays


@pytest.fixture
def pressed(rng: np.random.Generator) -> SimpleNamespace:
    """Return something with fields of more than one block."""
    pressure, gap = rng.random((2, 300, 500))
    return SimpleNamespace(pressure=pressure, gap=gap, size=(3.0, 10.0), modulus=2.0)


def test_npz(pressed: SimpleNamespace, tmp_path: Path) -> None:
    path = rb.save_fields(pressed, tmp_path / "state.npz")
    with np.load(path) as found:
        for name in ("pressure", "gap"):
            np.testing.assert_array_equal(found[name], getattr(pressed, name))
        assert found["x"][1] == 10.0 / 500
        assert found["y"][-1] == pytest.approx(3.0 - 0.01)
        assert found["nominal_pressure"] == pressed.pressure.mean()
        assert found["modulus"] == 2.0
    before = path.read_bytes()
    assert rb.save_fields(pressed, path).read_bytes() == before  # over its own, the same


def test_vti(pressed: SimpleNamespace, tmp_path: Path) -> None:
    path = rb.save_fields(pressed, tmp_path / "state.VTI")
    image, arrays = read_vti(path)
    np.testing.assert_array_equal(arrays["pressure"][0], pressed.pressure)
    np.testing.assert_array_equal(arrays["gap"][0], pressed.gap)
    assert [float(one) for one in image["Spacing"].split()] == [10.0 / 500, 3.0 / 300, 1.0]
    assert arrays["mean_separation"] == pressed.gap.mean()
    pressed.pressure = np.where(pressed.pressure > 0.9, pressed.pressure, 0.0)
    smaller = rb.save_fields(pressed, path)
    assert smaller.stat().st_size < 0.75 * pressed.pressure.nbytes * 2


def test_a_full_block_has_no_rest(tmp_path: Path) -> None:
    line = SimpleNamespace(pressure=np.arange(2.0**17), gap=np.zeros(2**17))
    _, arrays = read_vti(rb.save_fields(line, tmp_path / "line.vti", length=1.0))
    np.testing.assert_array_equal(arrays["pressure"].ravel(), line.pressure)


@pytest.mark.parametrize("suffix", [".npz", ".vti"])
def test_files_of_others_stay(pressed: SimpleNamespace, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"state{suffix}"
    path.write_bytes(b"somebody's")
    with pytest.raises(rb.StoreError, match="no field that roughbench wrote"):
        rb.save_fields(pressed, path)
    with pytest.raises(rb.StoreError, match=r"state.vtk: fields are written as .npz or .vti"):
        rb.save_fields(pressed, tmp_path / "state.vtk")


@pytest.fixture
def kept(small_spec: dict[str, Any]) -> Results:
    small_spec["surface"] |= {"q1": 8.0}
    small_spec |= {
        "models": [{"kind": "winkler", "grid": 32}, {"kind": "foundation", "springs": 64}],
        "realizations": 2,
        "save_fields": {"pressures": [1e-3, 1e-2], "realizations": [1]},
    }
    return rb.run(small_spec)


def test_export(kept: Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_results(kept, "kept.h5")
    done = CliRunner().invoke(main, ["export", "kept.h5", "--vtk", "v", "--npz", "n"])
    assert done.exit_code == 0
    names = [f"main-{m}-1-{p}" for m in ("winkler", "foundation") for p in ("0.001", "0.01")]
    assert done.stdout.split() == [f"n/{n}.npz" for n in names] + [f"v/{n}.vti" for n in names]
    winkler = kept["main"]["winkler"]
    image, arrays = read_vti(Path("v/main-winkler-1-0.01.vti"))
    np.testing.assert_array_equal(arrays["pressure"][0], winkler["field_pressure"][1])
    assert float(image["Spacing"].split()[0]) * 32 == pytest.approx(2 * np.pi)
    assert (arrays["realization"], arrays["given_pressure"]) == (1.0, 0.01)
    with np.load("n/main-foundation-1-0.001.npz") as found:
        line = kept["main"]["foundation"]
        np.testing.assert_array_equal(found["gap"], line["field_gap"][0])
        assert str(found["length_unit"]) == "length"
        assert "y" not in found


def test_what_cannot_be_exported(
    small_spec: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_results(rb.run(small_spec), "small.h5")
    for options, message in (
        (["--vtk", "v"], "no fields; ask for them in the spec, save_fields:"),
        ([], "say what to export and where to: --csv, --npz or --vtk DIR"),
        (["--vtk", "v", "--states"], "--states adds to the tables of --csv DIR"),
    ):
        done = CliRunner().invoke(main, ["export", "small.h5", *options])
        assert done.exit_code == 2 or "no fields" in message
        assert done.exit_code != 0
        assert message in re.sub(r"\s+", " ", done.stderr)
    assert not Path("v").exists()
