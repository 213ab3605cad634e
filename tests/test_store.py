"""The results file: layout, round trip, atomic commit, and refusal of everything else."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hypothesis_numpy

from roughbench import store
from roughbench.errors import StoreError
from roughbench.outputs import check_output
from roughbench.results import Array, Attribute, ModelResult, Results
from roughbench.seal import seal
from roughbench.store import load, write_results
from roughbench.store.checks import check_sealed
from roughbench.variables import dimensions

PRESSURES = np.array([1e-3, 1e-2, 0.1])


def model_result(
    label: str = "bem", n_realizations: int = 2, shift: float = 0.0
) -> ModelResult:
    shape = (n_realizations, len(PRESSURES))
    values = np.arange(float(np.prod(shape))).reshape(shape) + shift
    stiffness = values.copy()
    stiffness[-1, -1] = np.inf
    status = np.zeros(shape, np.int32)
    status[0, 1] = 2
    return ModelResult(
        label=label,
        kind="bem",
        title="Exact (BEM)",
        attributes={"length": 6.25, "grid": 8, "rms_height": 0.5, "ends": "périodique"},
        variables={
            "pressure": PRESSURES,
            "area": values,
            "separation": values,
            "stiffness": stiffness,
            "energy": values,
            "status": status,
            "iterations": np.full(shape, 7, np.int64),
            "rms_height": np.full(n_realizations, 0.5),
            "rms_slope": np.full(n_realizations, 0.1),
            "area_mean": values.mean(axis=0),
            "n_converged": np.array([2, 1, 2]),
            "stiffness_harmonic": np.ones(3),
        },
    )


def results(shift: float = 0.0) -> Results:
    return Results(
        experiments={
            "qr=8": {"zz": model_result("zz", shift=shift), "aa": model_result("aa", 5)},
            "qr=1": {"bem": model_result()},
        },
        spec_text="name: größe\n",
        spec_sha256="0" * 64,
        name="sample",
    )


def assert_equal(one: Results, other: Results) -> None:
    assert (one.name, one.spec_text, one.spec_sha256) == (
        other.name,
        other.spec_text,
        other.spec_sha256,
    )
    assert list(one) == list(other)
    for experiment in one:
        assert list(one[experiment]) == list(other[experiment])
    for (_, a), (_, b) in zip(one.models(), other.models(), strict=True):
        assert (a.label, a.kind, a.title) == (b.label, b.kind, b.title)
        assert dict(a.attributes) == dict(b.attributes)
        assert {k: type(v) for k, v in a.attributes.items()} == {
            k: type(v) for k, v in b.attributes.items()
        }
        assert list(a) == list(b)
        for name in a:
            assert a[name].dtype == b[name].dtype
            np.testing.assert_array_equal(a[name], b[name])


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return write_results(results(), tmp_path / "sample.h5")


def test_load_returns_what_was_written(path: Path) -> None:
    assert_equal(load(path), results())


@given(
    values=hypothesis_numpy.arrays(
        st.sampled_from([np.float64, np.float32]),
        hypothesis_numpy.array_shapes(min_dims=2, max_dims=2, max_side=4),
        elements=st.floats(width=32, allow_nan=True, allow_infinity=True),
    ),
    attributes=st.dictionaries(
        st.text("abcdef", min_size=1),
        st.text(st.characters(exclude_categories=["C", "Zl", "Zp"]))
        | st.integers(-(2**63), 2**63 - 1)
        | st.floats(allow_nan=False),
    ),
)
@settings(max_examples=50, deadline=None)
def test_round_trip(
    tmp_path_factory: pytest.TempPathFactory, values: Array, attributes: Mapping[str, Attribute]
) -> None:
    variables = {
        "pressure": np.arange(1.0, values.shape[1] + 1.0),
        "area": values,
        "status": np.zeros(values.shape, np.int32),
    }
    before = Results({"main": {"m": ModelResult("m", "k", "T", attributes, variables)}}, "", "")
    target = tmp_path_factory.mktemp("trip") / "r.h5"
    assert_equal(load(write_results(before, target)), before)


def test_layout_is_the_published_one(path: Path) -> None:
    with h5py.File(path) as file:
        assert dict(file.attrs) == {
            "format": "roughbench",
            "format_version": 1,
            "name": "sample",
            "spec": "name: größe\n",
            "spec_sha256": "0" * 64,
        }
        group = file["qr=8/zz"]
        assert group.attrs["kind"] == "bem"
        assert group.attrs["length"] == 6.25
        for name, data in group.items():
            assert data.fletcher32
            assert data.dtype in (np.float64, np.int64, np.int32)
            assert data.attrs["units"]
            assert data.attrs["long_name"]
            scales = [axis[0].name.rpartition("/")[2] for axis in data.dims if len(axis)]
            assert scales == ([] if data.is_scale else list(dimensions(name)))
        assert group["status"].dtype == np.int32
        assert group["status"].attrs["flag_values"].tolist() == [0, 1, 2, 3]
        meanings = group["status"].attrs["flag_meanings"]
        assert meanings == "converged stagnated max_iterations not_finite"
        units = {
            name: group[name].attrs["units"] for name in ("separation", "stiffness", "area")
        }
        assert units == {"separation": "length", "stiffness": "1/length", "area": "1"}
        assert group["area_mean"].attrs["long_name"] == "real contact area A/A0, mean"


def test_opens_in_xarray_with_named_dimensions(path: Path) -> None:
    with xarray.open_dataset(path, group="qr=8/aa", engine="h5netcdf") as data:
        assert dict(data.sizes) == {"realization": 5, "pressure": 3}
        assert data["area"].dims == ("realization", "pressure")
        assert data["area_mean"].dims == ("pressure",)
        assert data["rms_slope"].dims == ("realization",)
        assert data["pressure"].values.tolist() == PRESSURES.tolist()
        assert data["area"].sel(realization=4, pressure=0.1).item() == 14.0
        assert data["separation"].attrs["units"] == "length"
        assert data.attrs["title"] == "Exact (BEM)"


def test_bytes_depend_on_the_results_alone(tmp_path: Path) -> None:
    one = write_results(results(), tmp_path / "one.h5").read_bytes()
    time.sleep(1.1)  # HDF5 keeps times in seconds
    other = write_results(results(), tmp_path / "a longer name.h5").read_bytes()
    assert one == other
    assert one != write_results(results(shift=1.0), tmp_path / "one.h5").read_bytes()


def test_counts_states_that_did_not_converge(path: Path) -> None:
    model = load(path)["qr=8"]["aa"]
    assert (model.n_unconverged, model.n_states, model.n_realizations) == (1, 15, 5)
    assert "area" in model
    assert "area_raw" not in model


# -- commit --------------------------------------------------------------------------------


def test_replaces_an_existing_file(path: Path) -> None:
    write_results(results(shift=9.0), path)
    assert_equal(load(path), results(shift=9.0))
    assert [entry.name for entry in path.parent.iterdir()] == ["sample.h5"]


@pytest.mark.parametrize("step", ["fsync", "replace"])
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failed_commit_leaves_the_old_file(
    path: Path, monkeypatch: pytest.MonkeyPatch, step: str, error: BaseException
) -> None:
    def fail(*_: object) -> None:
        raise error

    if step == "fsync":
        monkeypatch.setattr(os, "fsync", fail)
    else:
        monkeypatch.setattr(Path, "replace", fail)
    expected = StoreError if isinstance(error, OSError) else KeyboardInterrupt
    with pytest.raises(expected, match="No space left" if expected is StoreError else None):
        write_results(results(shift=9.0), path)
    monkeypatch.undo()
    assert_equal(load(path), results())
    assert [entry.name for entry in path.parent.iterdir()] == ["sample.h5"]


WRITER = """
import sys, pathlib
sys.path.insert(0, sys.argv[2])
from test_store import results
from roughbench.store import write_results
print("ready", flush=True)
for shift in range(10**9):
    write_results(results(shift=float(shift)), pathlib.Path(sys.argv[1]))
"""


def test_a_killed_writer_leaves_a_whole_file(path: Path) -> None:
    here = Path(__file__).parent
    root = Path(store.__file__).parents[2]
    for _ in range(3):
        with subprocess.Popen(
            [sys.executable, "-c", WRITER, path, here],
            stdout=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": str(root)},
        ) as writer:
            assert writer.stdout is not None
            try:
                writer.stdout.readline()
                for _ in range(20):  # a reader meanwhile sees whole files only
                    assert list(load(path)) == ["qr=8", "qr=1"]
            finally:
                writer.kill()
        assert list(load(path)) == ["qr=8", "qr=1"]


def test_refuses_places_that_it_cannot_write_to(tmp_path: Path) -> None:
    with pytest.raises(
        StoreError, match=r"cannot write .*No such file .* choose another place with -o"
    ):
        write_results(results(), tmp_path / "missing" / "r.h5")
    with pytest.raises(StoreError, match="it is a folder"):
        check_output(tmp_path, store.RESULTS)
    assert check_output(tmp_path / "missing" / "r.h5", store.RESULTS).name == "r.h5"


def test_asks_for_permission_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write anywhere
    with pytest.raises(StoreError, match="no permission to write in"):
        check_output(tmp_path / "r.h5", store.RESULTS)


def test_refuses_types_that_the_file_does_not_know(tmp_path: Path) -> None:
    broken = model_result()
    broken = ModelResult(
        "bem", "bem", "", {}, {**broken.variables, "flag": np.ones((2, 3), bool)}
    )
    with pytest.raises(StoreError, match="flag has type bool; store it as"):
        write_results(Results({"main": {"bem": broken}}, "", ""), tmp_path / "r.h5")
    assert list(tmp_path.iterdir()) == []


# -- refusals ------------------------------------------------------------------------------


def test_refuses_what_is_no_results_file(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="no such file; run its spec again"):
        load(tmp_path / "missing.h5")
    with pytest.raises(StoreError, match="is a folder"):
        load(tmp_path)
    os.mkfifo(tmp_path / "pipe.h5")  # to open it would wait for ever
    with pytest.raises(StoreError, match="is no regular file"):
        load(tmp_path / "pipe.h5")
    assert store.whose(tmp_path / "pipe.h5") is None
    text = tmp_path / "text.h5"
    text.write_text("not HDF5")
    with pytest.raises(StoreError, match="not an HDF5 file"):
        load(text)
    other = tmp_path / "other.h5"
    with h5py.File(other, "w") as file:
        file["x"] = 1.0
    with pytest.raises(StoreError, match="not written by roughbench"):
        load(other)


def _newer(file: h5py.File) -> None:
    file.attrs["format_version"] = 3


def _no_spec(file: h5py.File) -> None:
    del file.attrs["spec"]


def _no_status(file: h5py.File) -> None:
    del file["qr=1/bem/status"]


def _flat_status(file: h5py.File) -> None:
    del file["qr=1/bem/status"]
    file["qr=1/bem/status"] = np.zeros(3, np.int32)


def _wrong_shape(file: h5py.File) -> None:
    del file["qr=1/bem/area"]
    file["qr=1/bem/area"] = np.zeros((3, 2))


def _dataset_for_group(file: h5py.File) -> None:
    file["qr=1/extra"] = 1.0


def _array_attribute(file: h5py.File) -> None:
    file["qr=1/bem"].attrs["grid"] = [1, 2]


def _strings(file: h5py.File) -> None:
    del file["qr=1/bem/area"]
    file["qr=1/bem/area"] = "text"


def _huge(file: h5py.File) -> None:
    del file["qr=1/bem/area"]
    file["qr=1"]["bem"].create_dataset("area", shape=(2, 10**13), dtype="f8", chunks=(1, 1000))


def _external_link(file: h5py.File) -> None:
    file["qr=1/bem/secret"] = h5py.ExternalLink("/etc/passwd", "/")


def _soft_link(file: h5py.File) -> None:
    file["qr=1/again"] = h5py.SoftLink("/qr=1/bem")


def _external_storage(file: h5py.File) -> None:
    del file["qr=1/bem/area"]
    file["qr=1/bem"].create_dataset(
        "area", shape=(2, 3), dtype="f8", external=[("/etc/passwd", 0, h5py.h5f.UNLIMITED)]
    )


def _virtual(file: h5py.File) -> None:
    del file["qr=1/bem/area"]
    layout = h5py.VirtualLayout((2, 3), "f8")
    layout[:] = h5py.VirtualSource("other.h5", "x", (2, 3))
    file["qr=1/bem"].create_virtual_dataset("area", layout)


def _many_names(file: h5py.File) -> None:
    for number in range(50):
        file[f"qr=1/bem/again{number}"] = file["qr=1/bem/area"]


def _many_groups(file: h5py.File) -> None:
    file["qr=1/again"] = file["qr=1/bem"]


def _never_written(file: h5py.File) -> None:
    """Each of them might be in the file, all of them cannot."""
    for number in range(50):
        file["qr=1/bem"].create_dataset(f"more{number}", shape=(2, 1000), dtype="f8")


def _wide_chunks(file: h5py.File) -> None:
    del file["qr=1/bem/area"]
    wide = {"maxshape": (None, None), "chunks": (1, 10**8), "compression": "gzip"}
    file["qr=1/bem"].create_dataset("area", shape=(2, 3), dtype="f8", **wide)


def _wide_attribute(file: h5py.File) -> None:
    file["qr=1/bem"].attrs["grid"] = np.zeros(1000)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_many_names, "again0 stands in it under two names"),
        (_many_groups, "again stands in it under two names"),
        (_never_written, "more.* claims 16000 bytes, the file has .* in all"),
        (_wide_chunks, r"area has chunks of \(1, 100000000\) for \(2, 3\)"),
        (_wide_attribute, r"an attribute grid of shape \(1000,\)"),
        (_newer, "format version 3, newer than 2; upgrade roughbench"),
        (_no_spec, "damaged .*spec.*run its spec again"),
        (_no_status, "damaged .*lacks status"),
        (_flat_status, "damaged .*status must have two dimensions, got 1"),
        (_wrong_shape, r"damaged .*area must have the shape \(2, 3\), got \(3, 2\)"),
        (_dataset_for_group, "damaged .*extra should be a group"),
        (_array_attribute, r"damaged .*an attribute grid of shape \(2,\)"),
        (_strings, "damaged .*of object"),
        (_huge, "damaged .*claims 160000000000000 bytes"),
        (_external_link, "secret is a link to another place"),
        (_soft_link, "again is a link to another place"),
        (_external_storage, "area keeps its values in another file"),
        (_virtual, "area keeps its values in another file"),
    ],
)
def test_refuses_a_changed_file(
    path: Path, change: Callable[[h5py.File], Any], message: str
) -> None:
    with h5py.File(path, "a") as file:
        change(file)
    with pytest.raises(StoreError, match=r"its content does not match|or cut short"):
        load(path)
    path.write_bytes(seal(path.read_bytes()))  # as only a forger would
    with pytest.raises(StoreError, match=message) as caught:
        load(path)
    assert str(path) in str(caught.value)


PLACES = {
    "experiment": b"EXPERIMENT",
    "label": b"LABELLABEL",
    "variable": b"VARIABLE_X",
    "attribute": b"ATTRIBUTES",
}


def crafted(path: Path, place: str, name: str) -> Path:
    """Write results with a name that no HDF5 library would give, by a change of the bytes.

    The groups are of HDF5's old kind, which has no checksums.
    """
    model = model_result()
    with h5py.File(path, "w") as file:
        file.attrs.update(format="roughbench", format_version=1, name="n", spec="s")
        file.attrs["spec_sha256"] = "0"
        group = file.create_group("EXPERIMENT/LABELLABEL")
        group.attrs.update(kind="bem", title="T", ATTRIBUTES=1.0)
        for variable, values in model.variables.items():
            group[variable] = values
        group["VARIABLE_X"] = model["area"]
    placeholder = PLACES[place]
    data = path.read_bytes()
    new = name.encode().ljust(len(placeholder), b"X") if name else placeholder
    assert data.count(placeholder) == 1
    assert len(new) == len(placeholder)
    path.write_bytes(seal(data.replace(placeholder, new)))
    return path


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    "name", ["/etc/a", "../a", "a/b", "a\nb", "a\x1b[2J", "\u202ea", "=1+1", "+1", "-1", "@A"]
)
def test_refuses_names_that_mean_something_elsewhere(
    tmp_path: Path, place: str, name: str
) -> None:
    assert load(crafted(tmp_path / "good.h5", place, "")).name == "n"
    path = crafted(tmp_path / "bad.h5", place, name)
    with pytest.raises(
        StoreError, match=r"damaged \(.* is none that roughbench gives"
    ) as caught:
        load(path)
    assert str(caught.value).isprintable()


def test_texts_are_escaped_where_they_do_not_print(tmp_path: Path) -> None:
    model = model_result()
    evil = "a\x1b[2J\u202eb\nc"
    model = ModelResult(
        "bem", evil, evil, {"heights": evil, "plain": "größe ξ"}, model.variables
    )
    path = tmp_path / "r.h5"
    write_results(Results({"main": {"bem": model}}, f"name: x # {evil}\n", evil, evil), path)
    loaded = load(path)
    found = loaded["main"]["bem"]
    escaped = "a\\x1b[2J\\u202eb\\nc"
    assert (loaded.name, loaded.spec_sha256, found.kind, found.title) == (escaped,) * 4
    assert dict(found.attributes) == {"heights": escaped, "plain": "größe ξ"}
    assert loaded.spec_text == "name: x # a\\x1b[2J\\u202eb\nc\n"  # a text has lines


def test_a_small_file_costs_little_memory(tmp_path: Path) -> None:
    """One array under many names."""
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as file:
        file.attrs.update(format="roughbench", format_version=1, name="n", spec="s")
        file.attrs["spec_sha256"] = "0"
        group = file.create_group("main/bem")
        group.attrs.update(kind="bem", title="T")
        group["area"] = np.zeros((100, 1000))
        for number in range(20_000):
            group[f"a{number}"] = group["area"]
    path.write_bytes(seal(path.read_bytes()))
    assert path.stat().st_size < 3e6  # and 16 GB, if every link were read
    tracemalloc.start()
    with pytest.raises(StoreError, match="stands in it under two names"):
        load(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 4 * path.stat().st_size + 10e6


def test_the_checksum_takes_no_memory(tmp_path: Path) -> None:
    """Read in blocks; all of a file at once, thrice, before."""
    values = np.zeros((1, 2_000_000))
    variables = {"pressure": values[0], "status": values.astype(np.int32)}
    big = Results({"main": {"m": ModelResult("m", "k", "T", {}, variables)}}, "", "")
    target = write_results(big, tmp_path / "big.h5")
    tracemalloc.start()
    check_sealed(target)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < target.stat().st_size / 5


def test_refuses_a_cut_file(path: Path) -> None:
    data = path.read_bytes()
    for length in range(0, len(data), 997):
        path.write_bytes(data[:length])
        with pytest.raises(StoreError, match=r"damaged|cut short|not an HDF5"):
            load(path)


def test_flipped_bits_in_the_values_are_found(path: Path) -> None:
    data = bytearray(path.read_bytes())
    values = model_result()["area"].tobytes()
    place = data.find(values)
    assert place > 0
    data[place + 20] ^= 1
    path.write_bytes(data)
    with pytest.raises(StoreError, match="damaged"):
        load(path)
    path.write_bytes(seal(bytes(data)))  # HDF5 has its own checksum
    with pytest.raises(StoreError, match="damaged"):
        load(path)


@settings(max_examples=500, deadline=None)
@given(data=st.data())
def test_a_damaged_file_is_refused_or_right(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    if not _image:
        _image.append((tmp_path_factory.mktemp("fuzz") / "r.h5", store.image(results())))
    path, original = _image[0]
    damaged = bytearray(original)
    first = data.draw(st.integers(0, len(damaged) - 1))
    kind = data.draw(st.sampled_from(["bytes", "cut", "append", "zeros", "move"]))
    if kind == "bytes":
        for offset in data.draw(st.lists(st.integers(0, 300), min_size=1, max_size=8)):
            damaged[(first + offset) % len(damaged)] = data.draw(st.integers(0, 255))
    elif kind == "cut":
        del damaged[first:]
    elif kind == "append":
        damaged += data.draw(st.binary(min_size=1, max_size=100))
    elif kind == "zeros":
        damaged[first : first + 4096] = bytes(len(damaged[first : first + 4096]))
    else:
        damaged = damaged[first:] + damaged[:first]
    path.write_bytes(damaged)
    if damaged == original:
        assert_equal(load(path), results())
        return
    with pytest.raises(StoreError) as caught:
        load(path)
    assert str(caught.value).startswith(f"{path}: ")


_image: list[tuple[Path, bytes]] = []
