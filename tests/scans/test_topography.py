"""Scans from files: orientation, size, unit, holes, and one line for each fault."""

from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from roughbench import memory
from roughbench.errors import SurfaceError
from roughbench.scans import instruments
from roughbench.scans.image import FloatArray
from roughbench.scans.topography import Scan, read_scan
from tests.scans.writers import write_gwy, write_x3p, write_xyz

ROWS, COLUMNS = 5, 8
SIZE = (5e-6, 16e-6)


def heights_in_metres() -> FloatArray:
    """Return heights without any symmetry, two of them missing."""
    heights = 1e-9 * np.random.default_rng(8).standard_normal((ROWS, COLUMNS))
    heights[1, 6] = heights[4, 0] = np.nan
    return heights


H = heights_in_metres()


def as_npy(folder: Path) -> Scan:
    np.save(folder / "a.npy", H / 1e-10)
    return read_scan("a.npy", folder, size=SIZE, unit=1e-10)


def as_npz(folder: Path) -> Scan:
    np.savez_compressed(folder / "a.npz", other=np.zeros((ROWS, COLUMNS)), z=H / 1e-3)
    return read_scan("a.npz", folder, size=SIZE, unit=1e-3, channel="z")


def as_text(folder: Path) -> Scan:
    header = "Width: 16 µm\nHeight: 5 µm\nValue units: pm"
    np.savetxt(folder / "a.txt", H / 1e-12, fmt="%.17g", header=header, encoding="utf-8")
    return read_scan("a.txt", folder)


def as_csv(folder: Path) -> Scan:
    cells = [["" if np.isnan(h) else repr(float(h) / 1e-9) for h in row] for row in H]
    lines = [";".join(row) for row in cells]
    (folder / "a.csv").write_text("\n".join(lines).replace(".", ","))
    return read_scan("a.csv", folder, size=SIZE, unit=1e-9)


def as_xyz(folder: Path) -> Scan:
    order = np.random.default_rng(1).permutation(H.size)
    header = "# Lateral units: mm\n# Value units: µm"
    write_xyz(folder / "a.xyz", H / 1e-6, (1e-3, 2e-3), order, header)
    return read_scan("a.xyz", folder)


def as_hdf5(folder: Path) -> Scan:
    with h5py.File(folder / "a.h5", "w") as file:
        file["scan/heights"] = H / 1e-2
        file["scan/heights"].attrs["units"] = "cm"
    return read_scan("a.h5:/scan/heights", folder, size=SIZE)


def as_gwy(folder: Path) -> Scan:
    mask = np.isnan(H)
    channels = {"Phase": (H, "deg"), "Height": (np.where(mask, 0.0, H), "m")}
    write_gwy(folder / "a.gwy", channels, SIZE)
    filled = read_scan("a.gwy", folder)
    assert filled.channel == "Height"
    assert filled.missing == 0.0
    heights = filled.heights.copy()
    heights[mask] = np.nan
    return Scan(heights, filled.size)


def as_x3p(folder: Path) -> Scan:
    write_x3p(folder / "a.x3p", H, SIZE)
    return read_scan("a.x3p", folder)


KINDS = [as_npy, as_npz, as_text, as_csv, as_xyz, as_hdf5, as_gwy, as_x3p]


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_file_gives_the_same_heights(tmp_path: Path, kind: Any) -> None:
    scan = kind(tmp_path)
    assert scan.heights.dtype == np.float64
    assert scan.heights.flags.c_contiguous
    np.testing.assert_allclose(scan.heights, H, rtol=1e-12)
    assert scan.size == pytest.approx(SIZE, rel=1e-12)
    assert scan.shape == (ROWS, COLUMNS)
    assert scan.spacing == pytest.approx((1e-6, 2e-6), rel=1e-12)
    assert scan.missing == 2 / 40


def test_single_precision_is_kept_as_it_is(tmp_path: Path) -> None:
    write_x3p(tmp_path / "a.x3p", H, SIZE, kind="F")
    np.testing.assert_array_equal(read_scan(tmp_path / "a.x3p").heights, H.astype("f4"))


def test_a_mask_of_gwyddion_marks_missing_points(tmp_path: Path) -> None:
    mask = np.isnan(H)
    write_gwy(tmp_path / "a.gwy", {"Height": (np.where(mask, 7.0, H), "m")}, SIZE, mask)
    np.testing.assert_allclose(read_scan(tmp_path / "a.gwy").heights, H, rtol=1e-12)


@pytest.mark.parametrize("dtype", ["<f4", ">f8", "<i2", "u1"])
def test_types_of_numbers(tmp_path: Path, dtype: str) -> None:
    counts = np.arange(40).reshape(ROWS, COLUMNS).astype(dtype)
    np.save(tmp_path / "a.npy", np.asfortranarray(counts))
    scan = read_scan("a.npy", tmp_path, size=SIZE, unit=1e-9)
    np.testing.assert_allclose(scan.heights, counts.astype(float) * 1e-9, rtol=1e-15)
    assert scan.heights.flags.c_contiguous


def test_infinite_heights_are_missing_and_noted(tmp_path: Path) -> None:
    heights = H.copy()
    heights[0, 0], heights[0, 1] = np.inf, -np.inf
    np.save(tmp_path / "a.npy", heights)
    scan = read_scan("a.npy", tmp_path, size=SIZE, unit=1.0)
    assert scan.missing == 4 / 40
    assert scan.notes == ("2 infinite heights were taken as missing",)


# Size and unit ----------------------------------------------------------------------------


def test_what_the_file_does_not_say_is_asked_for(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", H)
    both = (
        r"a\.npy: the file does not say the size of the image and the unit of the heights; "
        r"give them: size: \[10 um, 10 um\] \(x, y\) and unit: nm"
    )
    with pytest.raises(SurfaceError, match=both):
        read_scan("a.npy", tmp_path)
    with pytest.raises(SurfaceError, match=r"not say the size of the image; give it: size: \["):
        read_scan("a.npy", tmp_path, unit=1e-9)
    with pytest.raises(
        SurfaceError, match="not say the unit of the heights; give it: unit: nm"
    ):
        read_scan("a.npy", tmp_path, size=SIZE)


def test_what_is_said_twice_must_agree(tmp_path: Path) -> None:
    write_x3p(tmp_path / "a.x3p", H, SIZE)
    close = (SIZE[0] * (1 + 5e-7), SIZE[1])
    assert read_scan("a.x3p", tmp_path, size=close, unit=1.0).size == pytest.approx(SIZE)
    off = (SIZE[0], SIZE[1] * (1 + 2e-6))
    with pytest.raises(
        SurfaceError,
        match=r"file says that the image is \[16 µm, 5 µm\] large \(x, y\), size: says "
        r"\[16\.000032 µm, 5 µm\]",
    ):
        read_scan("a.x3p", tmp_path, size=off)
    with pytest.raises(SurfaceError, match=r"one unit of the heights is 1 m, unit: says 1 nm"):
        read_scan("a.x3p", tmp_path, unit=1e-9)


@pytest.mark.parametrize("size", [(0.0, 1e-6), (1e-6, -1e-6), (np.nan, 1e-6), (np.inf, 1.0)])
def test_a_size_is_positive(tmp_path: Path, size: tuple[float, float]) -> None:
    np.save(tmp_path / "a.npy", H)
    with pytest.raises(SurfaceError, match="no size of an image; it must be positive"):
        read_scan("a.npy", tmp_path, size=size, unit=1.0)


def test_a_unit_is_positive(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", H)
    with pytest.raises(SurfaceError, match="unit: must be a positive length, got -1 m"):
        read_scan("a.npy", tmp_path, size=SIZE, unit=-1.0)


# HDF5 -------------------------------------------------------------------------------------


def save_hdf5(folder: Path, attributes: dict[str, Any], data: Any = H) -> Path:
    path = folder / "a.h5"
    with h5py.File(path, "w") as file:
        file["z"] = data
        file["z"].attrs.update(attributes)
    return path


def test_fill_values_and_packing(tmp_path: Path) -> None:
    counts = np.arange(40, dtype="i2").reshape(ROWS, COLUMNS)
    counts[2, 3] = -999
    path = save_hdf5(
        tmp_path,
        {"_FillValue": np.int16(-999), "scale_factor": 0.5, "add_offset": 3.0, "units": b"nm"},
        counts,
    )
    scan = read_scan(path, size=SIZE)
    wanted = (counts * 0.5 + 3.0) * 1e-9
    wanted[2, 3] = np.nan
    np.testing.assert_allclose(scan.heights, wanted, rtol=1e-14)
    assert scan.channel == "z"


@pytest.mark.parametrize(
    ("attributes", "size"),
    [
        ({"size": 5.0, "size_unit": "µm"}, (5e-6, 5e-6)),
        ({"physical_sizes": [5.0, 5.0], "physical_sizes_units": "um"}, (5e-6, 5e-6)),
        ({"pixel_size": 2.0, "pixel_size_unit": "nm"}, (10e-9, 16e-9)),
        ({"size": [5.0, 8.0], "size_unit": "µm"}, None),  # which one is x?
        ({"size": 5.0}, None),
    ],
)
def test_sizes_in_attributes(
    tmp_path: Path, attributes: dict[str, Any], size: tuple[float, float] | None
) -> None:
    path = save_hdf5(tmp_path, attributes | {"unit": "m"})
    if size is None:
        with pytest.raises(SurfaceError, match="not say the size of the image; give it"):
            read_scan(path)
    else:
        assert read_scan(path).size == pytest.approx(size, rel=1e-12)


@pytest.mark.parametrize("order", [("y", "x"), ("x", "y")])
def test_coordinates_of_netcdf_say_size_and_order(
    tmp_path: Path, order: tuple[str, str]
) -> None:
    xarray = pytest.importorskip("xarray")
    steps = {"y": (ROWS, 1.0), "x": (COLUMNS, 2.0)}
    coordinates = {
        axis: (axis, step * np.arange(n), {"units": "um"}) for axis, (n, step) in steps.items()
    }
    data = xarray.DataArray(H / 1e-9, coords=coordinates, dims=("y", "x"), name="heights")
    data.attrs["units"] = "nm"
    data.transpose(*order).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    scan = read_scan("a.nc", tmp_path)
    np.testing.assert_allclose(scan.heights, H, rtol=1e-12)
    assert scan.size == pytest.approx(SIZE, rel=1e-12)
    assert bool(scan.notes) == (order == ("x", "y"))


def test_one_dataset_of_several_must_be_named(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["a/z"], file["b/z"], file["line"] = H, -H, H[0]
        file["v"] = H
        file["v"].attrs["units"] = "V"
    with pytest.raises(
        SurfaceError,
        match=r"more than one dataset .* it holds a/z \(no unit\), b/z \(no unit\), v \(V\); "
        r"name one, as in .*a\.h5:/a/z, or with channel:",
    ):
        read_scan(path)
    assert read_scan(path, channel="b/z", size=SIZE, unit=1.0).heights[0, 0] == -H[0, 0]
    with pytest.raises(SurfaceError, match=r"channel v \(V\) holds no heights"):
        read_scan(path, channel="v")
    with pytest.raises(SurfaceError, match="in 'V', which is no length"):
        read_scan(f"{path}:/v")
    with pytest.raises(SurfaceError, match="named twice"):
        read_scan(f"{path}:/a/z", channel="b/z")
    with pytest.raises(SurfaceError, match=r"rows and columns, got the shape \(8,\)"):
        read_scan(f"{path}:/line")


def test_data_outside_of_an_hdf5_file_are_refused(tmp_path: Path) -> None:
    save_hdf5(tmp_path, {}).rename(tmp_path / "other.h5")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["z"] = h5py.ExternalLink("other.h5", "/z")
    with pytest.raises(SurfaceError, match="link to another file, which is refused"):
        read_scan("a.h5:/z", tmp_path)
    with pytest.raises(SurfaceError, match="no channel holds heights; it holds none"):
        read_scan("a.h5", tmp_path)


# Instruments ------------------------------------------------------------------------------


def test_channels_are_listed_with_their_units(tmp_path: Path) -> None:
    channels = {"Phase": (H, "deg"), "Trace": (1.0 + H, "m"), "Retrace": (-1.0 - H, "m")}
    write_gwy(
        tmp_path / "a.gwy", {k: (np.nan_to_num(h), u) for k, (h, u) in channels.items()}, SIZE
    )
    assert read_scan("a.gwy", tmp_path).channel == "Trace"
    assert read_scan("a.gwy", tmp_path, channel="Retrace").heights[0, 0] == -1.0 - H[0, 0]
    with pytest.raises(
        SurfaceError, match=r"no channel 'trace'; it holds .*Trace \(m\)"
    ) as caught:
        read_scan("a.gwy", tmp_path, channel="trace")
    assert "Retrace (m)" in str(caught.value)
    assert "did you mean channel: Trace?" in str(caught.value)


def test_without_the_extra_the_error_names_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import builtins

    usual = builtins.__import__

    def without(name: str, *args: Any, **options: Any) -> Any:
        if name.partition(".")[0] == "SurfaceTopography":
            raise ModuleNotFoundError(name)
        return usual(name, *args, **options)

    write_x3p(tmp_path / "a.x3p", H, SIZE)
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(SurfaceError) as caught:
        read_scan("a.x3p", tmp_path)
    assert str(caught.value) == (
        "a.x3p: to read .x3p files of instruments, add their readers: "
        "pip install 'roughbench[scan]'"
    )


def test_built_in_kinds_need_no_extra() -> None:
    import subprocess
    import sys

    code = (
        "import sys, roughbench.scans.topography; "
        "sys.exit('SurfaceTopography' in sys.modules or 'pandas' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_what_the_library_says_becomes_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    import logging
    import warnings

    from SurfaceTopography.IO import X3PReader

    usual = X3PReader.topography

    def talkative(self: Any, **options: Any) -> Any:
        warnings.warn("the scale is\ndoubtful", UserWarning, stacklevel=1)
        warnings.warn("use another function", DeprecationWarning, stacklevel=1)
        logging.getLogger("SurfaceTopography.IO.X3P").warning("and the date %s", "too")
        print("noise")  # noqa: T201
        return usual(self, **options)

    write_x3p(tmp_path / "a.x3p", H, SIZE)
    monkeypatch.setattr(X3PReader, "topography", talkative)
    assert set(read_scan("a.x3p", tmp_path).notes) == {
        "SurfaceTopography: the scale is doubtful",
        "SurfaceTopography: and the date too",
    }
    assert capfd.readouterr() == ("", "")


def test_a_line_scan_is_no_map(tmp_path: Path) -> None:
    from SurfaceTopography import UniformLineScan

    scan = UniformLineScan(np.arange(9.0), 1.0, unit="µm")
    scan.to_netcdf(str(tmp_path / "a.nc"))
    with pytest.raises(SurfaceError, match=r"line scan|no channel holds heights"):
        read_scan("a.nc", tmp_path)


# Damaged and foreign files ------------------------------------------------------------------


def truncated(path: Path, share: float) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])


@pytest.mark.parametrize("share", [0.02, 0.3, 0.7, 0.98])
@pytest.mark.parametrize("kind", [as_npy, as_npz, as_hdf5, as_gwy, as_x3p])
def test_a_truncated_file_is_one_line(tmp_path: Path, kind: Any, share: float) -> None:
    kind(tmp_path)
    (path,) = tmp_path.iterdir()
    truncated(path, share)
    name = path.name + (":/scan/heights" if kind is as_hdf5 else "")
    with pytest.raises(SurfaceError) as caught:
        read_scan(name, tmp_path, size=SIZE if kind is not as_gwy else None, unit=1.0)
    assert str(caught.value).startswith(f"{name}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "suffix",
    [
        *(
            ".npy",
            ".npz",
            ".h5",
            ".txt",
            ".csv",
            ".xyz",
            ".nc",
            ".gwy",
            ".x3p",
            ".al3d",
            ".dat",
        ),
        *(".mnt", ".tiff", ".opd", ".spm", ".mi", ".sur", ".hgt", ".unknown", ""),
    ],
)
@pytest.mark.parametrize("content", ["empty", "noise", "zeros", "prose", "a number"])
def test_a_foreign_file_is_one_line(tmp_path: Path, suffix: str, content: str) -> None:
    path = tmp_path / f"scan{suffix}"
    path.write_bytes(
        {
            "empty": b"",
            "noise": np.random.default_rng(4).bytes(4099),
            "zeros": bytes(4098),
            "prose": b"This is no scan.\nIt is a letter.\n" * 20,
            "a number": b"42\n",
        }[content]
    )
    with pytest.raises(SurfaceError) as caught:
        read_scan(path, size=SIZE, unit=1.0)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600


def said_of(folder: Path, name: str) -> str:
    """Return the error, "" where the file is read: not all damage can be seen."""
    try:
        read_scan(name, folder)
    except SurfaceError as error:
        return str(error)
    return ""


def test_damage_inside_of_a_file_is_no_traceback(tmp_path: Path) -> None:
    rng = np.random.default_rng(11)
    for name, write in (("a.x3p", as_x3p), ("a.gwy", as_gwy)):
        write(tmp_path)
        whole = (tmp_path / name).read_bytes()
        for _ in range(40):
            data = bytearray(whole)
            for place in rng.integers(0, len(data), 4):
                data[place] = rng.integers(0, 256)
            (tmp_path / name).write_bytes(data)
            said = said_of(tmp_path, name)
            assert not said or said.startswith(f"{name}: ")
            assert "\n" not in said


def test_no_pickle_is_ever_opened(tmp_path: Path) -> None:
    array = np.array([[{}] * 4] * 4, dtype=object)
    np.save(tmp_path / "a.npy", array, allow_pickle=True)
    np.savez(tmp_path / "a.npz", a=array)
    for name in ("a.npy", "a.npz"):
        (tmp_path / name).rename(tmp_path / f"{name}.bin")
        for file in (f"{name}.bin",):
            with pytest.raises(SurfaceError):
                read_scan(file, tmp_path)
        (tmp_path / f"{name}.bin").rename(tmp_path / name)
        with pytest.raises(
            SurfaceError, match=r"Object arrays|no array that may be the heights"
        ):
            read_scan(name, tmp_path)


def test_a_built_in_kind_under_another_name_is_said(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.nan_to_num(H))
    (tmp_path / "a.npy").rename(tmp_path / "a.scan")
    with pytest.raises(SurfaceError, match=r"of the kind \.npy; rename it"):
        read_scan("a.scan", tmp_path)


def test_only_regular_files_that_are_there(tmp_path: Path) -> None:
    with pytest.raises(SurfaceError, match="no such file"):
        read_scan("a.x3p", tmp_path)
    (tmp_path / "folder.x3p").mkdir()
    for name in ("folder.x3p", "/dev/zero", "http://localhost/a.x3p"):
        with pytest.raises(SurfaceError, match="no such file"):
            read_scan(name, tmp_path)


@pytest.mark.parametrize("name", ["a.npy", "a.npz", "a.h5", "a.txt", "a.x3p"])
def test_the_memory_is_asked_before_a_file_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    for kind in (as_npy, as_npz, as_hdf5, as_text, as_x3p):
        kind(tmp_path)
    little = memory.AvailableMemory(300, "a small machine")
    monkeypatch.setattr(memory, "available_memory", lambda: little)
    options: dict[str, Any] = {"channel": "z"} if name == "a.npz" else {}
    with pytest.raises(SurfaceError, match=r"to read .* takes .*a small machine"):
        read_scan(name, tmp_path, **options)


def test_a_zip_bomb_is_not_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import zipfile

    for name in ("a.npz", "a.x3p"):
        with (
            zipfile.ZipFile(tmp_path / name, "w", zipfile.ZIP_DEFLATED) as archive,
            archive.open("z.npy", "w") as file,
        ):
            np.lib.format.write_array_header_1_0(
                file, {"descr": "<f8", "fortran_order": False, "shape": (4096, 4096)}
            )
            for _ in range(128):
                file.write(bytes(1 << 20))
    monkeypatch.setattr(
        memory, "available_memory", lambda: memory.AvailableMemory(1 << 25, "a small machine")
    )
    tracemalloc.start()
    try:
        for name in ("a.npz", "a.x3p"):
            with pytest.raises(SurfaceError, match="a small machine"):
                read_scan(name, tmp_path, size=SIZE, unit=1.0)
        assert tracemalloc.get_traced_memory()[1] < 1 << 26
    finally:
        tracemalloc.stop()


def test_the_command_is_the_extra_of_this_package() -> None:
    import tomllib

    project = tomllib.loads(
        (Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8")
    )["project"]
    assert instruments.COMMAND == "pip install 'roughbench[scan]'"
    assert any(
        "SurfaceTopography" in entry for entry in project["optional-dependencies"]["scan"]
    )
