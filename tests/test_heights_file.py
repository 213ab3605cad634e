"""Heights from files: what comes back, and a message for each fault."""

from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.heights_file import load_heights

GOOD = np.random.default_rng(0).standard_normal((6, 4)) + 2.0


def save(folder: Path, array: Any, **options: Any) -> Path:
    path = folder / "heights.npy"
    np.save(path, array, **options)
    return path


def save_hdf5(folder: Path, **datasets: Any) -> Path:
    path = folder / "heights.h5"
    with h5py.File(path, "w") as file:
        for name, data in datasets.items():
            file[name] = data
    return path


# What comes back --------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", ["<f8", ">f8", "<f4", "f2", "<i2", "u1", "longdouble"])
@pytest.mark.parametrize("shape", [(24,), (6, 4)])
@pytest.mark.parametrize("kind", ["npy", "hdf5"])
def test_heights_come_back_as_they_are(
    tmp_path: Path, dtype: str, shape: tuple[int, ...], kind: str
) -> None:
    array = (16 * np.abs(GOOD)).round().reshape(shape).astype(dtype)
    if kind == "npy":
        heights = load_heights(save(tmp_path, array))
    else:
        heights = load_heights(f"{save_hdf5(tmp_path, h=array)}:/h")
    assert heights.dtype == np.float64
    assert heights.dtype.isnative
    assert heights.flags.c_contiguous
    np.testing.assert_array_equal(heights, array.astype(float))


def test_fortran_order_and_the_mean_are_kept_apart_from_the_layout(tmp_path: Path) -> None:
    heights = load_heights(save(tmp_path, np.asfortranarray(GOOD)))
    np.testing.assert_array_equal(heights, GOOD)
    assert heights.flags.c_contiguous


def test_relative_paths_start_from_the_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save(tmp_path, GOOD)
    save_hdf5(tmp_path, h=GOOD)
    np.testing.assert_array_equal(load_heights("heights.npy", tmp_path), GOOD)
    np.testing.assert_array_equal(load_heights("heights.h5:/h", str(tmp_path)), GOOD)
    monkeypatch.chdir(tmp_path)
    np.testing.assert_array_equal(load_heights(Path("heights.npy")), GOOD)


def test_datasets_in_groups_behind_soft_links_and_compressed(tmp_path: Path) -> None:
    path = tmp_path / "heights.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("a/b/h", data=GOOD, chunks=(3, 2), compression="gzip")
        file["short"] = h5py.SoftLink("/a/b/h")
        file["a/up"] = h5py.SoftLink("b")
        file["hard"] = file["a/b/h"]
    for name in ("a/b/h", "/a//b/h", "short", "a/up/h", "hard"):
        np.testing.assert_array_equal(load_heights(f"{path}:/{name}"), GOOD)


def test_a_colon_in_the_folder_is_no_dataset(tmp_path: Path) -> None:
    folder = tmp_path / "12:30"
    folder.mkdir()
    np.testing.assert_array_equal(load_heights(save(folder, GOOD)), GOOD)
    np.testing.assert_array_equal(load_heights(f"{save_hdf5(folder, h=GOOD)}:/h"), GOOD)


# Faults of the values -----------------------------------------------------------------------


def holes(*places: tuple[int, ...]) -> NDArray[np.float64]:
    array = GOOD.copy()
    for place in places:
        array[place] = np.nan
    return array


FAULTS: list[tuple[Any, str]] = [
    (holes((4, 1)), r"1 of 24 heights are not finite, the first at index \[4, 1\]"),
    (holes((2, 3), (5, 0)), r"2 of 24 .* index \[2, 3\]; fill or cut"),
    (np.where(np.arange(9) == 7, -np.inf, 0.0), r"1 of 9 .* index \[7\]"),
    (GOOD.astype(complex), "must be real numbers, got the type complex128; save them"),
    (GOOD > 0, "got the type bool"),
    (np.float64(1.0), r"one dimension \(a line\) or two \(a surface\), got the shape \(\)"),
    (np.zeros((4, 4, 4)), r"got the shape \(4, 4, 4\)"),
    (np.zeros(3), r"at least 4 points per side, got the shape \(3,\)"),
    (np.zeros((8, 2)), r"at least 4 points per side, got the shape \(8, 2\)"),
    (np.zeros(0), "at least 4 points per side"),
]


@pytest.mark.parametrize(("array", "message"), FAULTS)
@pytest.mark.parametrize("kind", ["npy", "hdf5"])
def test_each_fault_of_the_values_has_its_message(
    tmp_path: Path, array: Any, message: str, kind: str
) -> None:
    npy = kind == "npy"
    name = str(save(tmp_path, array)) if npy else f"{save_hdf5(tmp_path, h=array)}:/h"
    with pytest.raises(SurfaceError, match=message) as caught:
        load_heights(name)
    assert str(caught.value).startswith(f"{name}: ")


def test_text_times_and_records_are_no_heights(tmp_path: Path) -> None:
    record = np.zeros(8, [("x", float), ("h", float)])
    for array in (np.array(["1.0"] * 8), np.zeros(8, "M8[s]"), record):
        with pytest.raises(SurfaceError, match="must be real numbers"):
            load_heights(save(tmp_path, array))
    path = save_hdf5(tmp_path, text=["1.0"] * 8, record=record)
    for name in ("text", "record"):
        with pytest.raises(SurfaceError, match="must be real numbers"):
            load_heights(f"{path}:/{name}")


@pytest.mark.parametrize("attribute", ["_FillValue", "missing_value"])
def test_points_that_a_file_marks_as_missing_are_refused(
    tmp_path: Path, attribute: str
) -> None:
    """As netCDF writes masked arrays; a fill value may well look like a height."""
    array = GOOD.copy()
    array[2, 1] = array[4, 3] = -9.0
    path = save_hdf5(tmp_path, h=array, whole=GOOD, odd=GOOD)
    with h5py.File(path, "a") as file:
        file["h"].attrs[attribute] = np.array([-9.0])
        file["whole"].attrs[attribute] = -9.0
        file["odd"].attrs[attribute] = "none"
    message = rf"2 of 24 heights are marked as missing \({attribute} = -9\); fill or cut"
    with pytest.raises(SurfaceError, match=message):
        load_heights(f"{path}:/h")
    for name in ("whole", "odd"):
        np.testing.assert_array_equal(load_heights(f"{path}:/{name}"), GOOD)


@pytest.mark.parametrize("kind", ["npy", "hdf5"])
def test_heights_stored_too_coarsely_are_refused(tmp_path: Path, kind: str) -> None:
    def name_of(array: NDArray[np.floating]) -> str:
        if kind == "npy":
            return str(save(tmp_path, array))
        return f"{save_hdf5(tmp_path, h=array)}:/h"

    fine = (GOOD + 1e3).astype(np.float32)
    np.testing.assert_array_equal(load_heights(name_of(fine)), fine.astype(float))
    name = name_of((GOOD + 1e6).astype(np.float32))
    with pytest.raises(SurfaceError, match="heights of float32 with a mean of 1e") as caught:
        load_heights(name)
    assert str(caught.value).startswith(f"{name}: ")


# Faults of .npy files -------------------------------------------------------------------------


def test_pickles_are_not_loaded(tmp_path: Path) -> None:
    path = save(tmp_path, np.array([1.0, None] * 4, object), allow_pickle=True)
    with pytest.raises(SurfaceError, match=r"Object arrays cannot be loaded.*numpy\.save"):
        load_heights(path)


@pytest.mark.parametrize("content", [b"", b"1.0 2.0\n", b"\x93NUMPY\x01\x00", b"PK\x03\x04"])
def test_what_is_no_npy_file_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "heights.npy"
    path.write_bytes(content)
    with pytest.raises(SurfaceError, match=r"not a \.npy file of numbers"):
        load_heights(path)


def test_truncated_files_are_refused(tmp_path: Path) -> None:
    path = save(tmp_path, GOOD)
    path.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(SurfaceError, match=r"not a \.npy file of numbers"):
        load_heights(path)


@pytest.mark.parametrize("name", ["none.npy", "none.h5:/h", "folder.npy", "folder.npy:/h"])
def test_missing_files_say_where_paths_start(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder.npy").mkdir()
    with pytest.raises(SurfaceError, match="no such file; relative paths start from") as caught:
        load_heights(name, tmp_path)
    assert str(tmp_path) in str(caught.value)
    assert "did you mean" not in str(caught.value)


def test_the_file_that_was_probably_meant_is_named(tmp_path: Path) -> None:
    save(tmp_path, GOOD).rename(tmp_path / "plate.npy")
    with pytest.raises(
        SurfaceError, match=r"no such file \(did you mean 'plate\.npy'\?\); rel"
    ):
        load_heights("plaet.npy", tmp_path)


@pytest.mark.parametrize("name", ["heights.txt", "heights.h5", "heights", "h.h5:h"])
def test_other_names_say_what_is_needed(tmp_path: Path, name: str) -> None:
    with pytest.raises(SurfaceError, match=r"as in file\.h5:/heights"):
        load_heights(name, tmp_path)


# Faults of HDF5 files -----------------------------------------------------------------------


def test_missing_datasets_say_what_there_is(tmp_path: Path) -> None:
    path = save_hdf5(tmp_path, **{"a/h": GOOD, "b": GOOD})
    for name, message in {
        "h": "no dataset h in /; it holds a, b",
        "a/x": "no dataset x in /a; it holds h",
        "b/h": "no dataset b in /; it holds a, b",
        "a": "/a is a group, not a dataset; it holds h",
        "": "/ is a group, not a dataset; it holds a, b",
    }.items():
        with pytest.raises(SurfaceError, match=message):
            load_heights(f"{path}:/{name}")


def test_empty_groups_types_and_datasets(tmp_path: Path) -> None:
    path = tmp_path / "heights.h5"
    with h5py.File(path, "w") as file:
        file.create_group("nothing")
        file["type"] = np.dtype("f8")
        file["null"] = h5py.Empty("f8")
    for name, message in {
        "nothing": "it holds nothing",
        "nothing/h": "no dataset h in /nothing; it holds nothing",
        "type": "no dataset type",
        "null": "got the shape None",
    }.items():
        with pytest.raises(SurfaceError, match=message):
            load_heights(f"{path}:/{name}")


def test_what_is_no_hdf5_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "heights.h5").write_bytes(b"1.0 2.0\n")
    with pytest.raises(SurfaceError, match=r"heights\.h5 is not a readable HDF5 file"):
        load_heights("heights.h5:/h", tmp_path)


def test_links_out_of_the_file_are_refused_without_following_them(tmp_path: Path) -> None:
    """Straight, within the path, and behind a soft link; the target does not even exist."""
    path = tmp_path / "heights.h5"
    with h5py.File(path, "w") as file:
        file["out"] = h5py.ExternalLink("other.h5", "/h")
        file["a/out"] = h5py.ExternalLink("other.h5", "/a")
        file["soft"] = h5py.SoftLink("/a/out/h")
    for name in ("out", "a/out/h", "soft"):
        with pytest.raises(SurfaceError, match=r"out is a link to another file.*other\.h5:/"):
            load_heights(f"{path}:/{name}")


def test_data_outside_the_file_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "heights.h5"
    (tmp_path / "raw.bin").write_bytes(GOOD.tobytes())
    layout = h5py.VirtualLayout(GOOD.shape, float)
    layout[:] = h5py.VirtualSource("other.h5", "h", GOOD.shape)
    with h5py.File(path, "w") as file:
        file.create_dataset(
            "external", GOOD.shape, float, external=[(str(tmp_path / "raw.bin"), 0, 192)]
        )
        file.create_virtual_dataset("virtual", layout)
    for name in ("external", "virtual"):
        with pytest.raises(SurfaceError, match="keeps its data in other files"):
            load_heights(f"{path}:/{name}")


def test_links_in_circles_and_into_nothing(tmp_path: Path) -> None:
    path = tmp_path / "heights.h5"
    with h5py.File(path, "w") as file:
        file["a"] = h5py.SoftLink("/b")
        file["b"] = h5py.SoftLink("/a")
        file["dangling"] = h5py.SoftLink("/gone")
    with pytest.raises(SurfaceError, match="the links of /a go in circles"):
        load_heights(f"{path}:/a")
    with pytest.raises(SurfaceError, match="no dataset gone"):
        load_heights(f"{path}:/dangling")


def test_damaged_chunks_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "heights.h5"
    with h5py.File(path, "w") as file:
        data = file.create_dataset("h", data=GOOD, chunks=GOOD.shape, fletcher32=True)
        offset = data.id.get_chunk_info(0).byte_offset
    raw = bytearray(path.read_bytes())
    raw[offset + 3] ^= 1
    path.write_bytes(bytes(raw))
    with pytest.raises(SurfaceError, match="the dataset cannot be read"):
        load_heights(f"{path}:/h")


# Files that claim more than they hold ---------------------------------------------------------


def test_a_header_that_claims_more_than_the_file_has(tmp_path: Path) -> None:
    path = tmp_path / "heights.npy"
    with path.open("wb") as file:
        header = {"descr": "<f8", "fortran_order": False, "shape": (100_000, 100_000)}
        np.lib.format.write_array_header_1_0(file, header)
        file.write(bytes(1000))
    tracemalloc.start()
    with pytest.raises(SurfaceError, match=r"take 80000000000 bytes, it has 1000"):
        load_heights(path)
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, r"parts .* were never written \(8000000000 bytes are declared, 0 stored\)"),
        ({"chunks": (10, 100)}, "were never written"),
        ({"chunks": (10, 100), "compression": "gzip"}, "were never written"),
    ],
)
def test_heights_that_were_never_written(
    tmp_path: Path, options: dict[str, Any], message: str
) -> None:
    """They would read as zeros."""
    path = tmp_path / "heights.h5"
    with h5py.File(path, "w") as file:
        data = file.create_dataset("h", shape=(10_000, 100_000), dtype="f8", **options)
        if options:
            data[:10, :100] = 1.0
    tracemalloc.start()
    with pytest.raises(SurfaceError, match=message):
        load_heights(f"{path}:/h")
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()


def test_chunks_that_are_larger_than_the_heights(tmp_path: Path) -> None:
    path = tmp_path / "heights.h5"
    with h5py.File(path, "w") as file:
        options = {"chunks": (100_000,), "maxshape": (None,), "compression": "gzip"}
        data = file.create_dataset("h", shape=(8,), dtype="f8", **options)
        data[:] = np.arange(8.0)
    with h5py.File(path, "a") as file:
        stored = file["h"].id.get_storage_size()
    assert stored > 800_000 / 1032  # deflate cannot do more
    assert load_heights(f"{path}:/h").tolist() == list(range(8))
    with h5py.File(path, "w") as file:
        zeros = np.zeros((1000, 1000), np.int32)
        file.create_dataset(
            "h", data=zeros, chunks=zeros.shape, scaleoffset=0, compression="gzip"
        )
    with pytest.raises(SurfaceError, match="claim to be 4000000 bytes of heights; save them"):
        load_heights(f"{path}:/h")


def test_long_lists_of_names_are_cut_and_escaped(tmp_path: Path) -> None:
    path = tmp_path / "heights.h5"
    with h5py.File(path, "w") as file:
        for number in range(1000):
            file[f"a\x1b{number:04}\n"] = 1.0
    with pytest.raises(SurfaceError, match="and 992 more") as caught:
        load_heights(f"{path}:/h")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 300


def test_what_the_system_says_is_passed_on(tmp_path: Path) -> None:
    for name in (f"{'x' * 300}.npy", f"{'x' * 300}.h5:/h"):
        with pytest.raises(SurfaceError, match="cannot be read: File name too long; choose a"):
            load_heights(name, tmp_path)
