"""Outputs replace nothing but what roughbench wrote: every command, every kind of file."""

from __future__ import annotations

import os
import shutil
import socket
import stat
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from click.testing import CliRunner, Result

import roughbench as rb
from roughbench import figures
from roughbench.cli import main
from roughbench.outputs import Kind, check_output, write_output
from roughbench.results import ModelResult
from roughbench.runner import driver
from roughbench.runner.assemble import assemble
from roughbench.store import RESULTS, write_results

SPEC = """\
name: small
surface: {H: 0.7, q0: 1.0, q1: 32.0, slope: 0.1}
pressures: [1.0e-3, 1.0e-2]
models: [{kind: persson}]
"""
NOTE = Kind("note", lambda head, tail: head.startswith(b"note") and tail.endswith(b"."))


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a spec and its results; to be copied, not used."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "small.yaml").write_text(SPEC)
    rb.run(folder / "small.yaml", output=folder / "small.h5")
    return folder


@pytest.fixture
def folder(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, blank_figures: None
) -> Path:
    """Return the current folder, with a spec and its results."""
    del blank_figures
    monkeypatch.chdir(tmp_path)
    shutil.copytree(finished, tmp_path, dirs_exist_ok=True)
    return tmp_path


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


OUTPUTS: dict[str, tuple[str, ...]] = {
    "out.h5": ("run", "small.yaml", "-o", "out.h5"),
    "out.log": ("run", "small.yaml", "--log-file", "out.log"),
    "out.html": ("report", "small.h5", "--resamples", "5", "-o", "out.html"),
    "figures/area.pdf": ("plot", "small.h5", "--figure", "area"),
    "figures/area.png": ("plot", "small.h5", "--figure", "area"),
    "tables/main-persson.csv": ("export", "small.h5", "--csv", "tables"),
    "tables/main-persson-states.csv": ("export", "small.h5", "--csv", "tables", "--states"),
}
"""Every file that a command writes under a name of the user's."""
EACH = pytest.mark.parametrize(("name", "command"), OUTPUTS.items(), ids=str)


def foreign_file(path: Path) -> None:
    path.write_text("a thesis")


def foreign_hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["heights"] = np.zeros((4, 4))


def the_spec(path: Path) -> None:
    path.symlink_to(Path("small.yaml").absolute())


def a_folder(path: Path) -> None:
    path.mkdir()


def a_pipe(path: Path) -> None:
    os.mkfifo(path)


def a_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(path))


def a_device(path: Path) -> None:
    path.symlink_to("/dev/null")


def a_circle(path: Path) -> None:
    path.symlink_to(path)


def of_another_kind(path: Path) -> None:
    """Put a figure where results or text go, results where a figure goes."""
    if path.suffix in {".pdf", ".png"}:
        path.write_bytes(Path("small.h5").read_bytes())
    else:
        figure = figures.render(rb.load("small.h5"), "area", path.parent / "source")[0]
        path.write_bytes(figure.read_bytes())


OBSTACLES = (
    foreign_file,
    foreign_hdf5,
    the_spec,
    a_folder,
    a_pipe,
    a_socket,
    a_device,
    a_circle,
    of_another_kind,
)


def state_of(folder: Path) -> dict[str, tuple[int, bytes]]:
    """Return type and content of what is in a folder and, for links, where they lead."""
    found = {}
    for path in sorted(folder.iterdir()):
        status = path.lstat()
        content = b""
        if path.is_symlink():
            content = os.fsencode(path.readlink())
        elif path.is_file():
            content = path.read_bytes()
        found[path.name] = (status.st_mode, content)
    return found


@EACH
def test_nothing_else_is_ever_replaced(
    folder: Path, name: str, command: tuple[str, ...]
) -> None:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    spec = (folder / "small.yaml").read_bytes()
    for number, make in enumerate(OBSTACLES):
        make(path)
        before = state_of(path.parent)
        done = invoke(*command)
        assert done.exit_code == 1, make
        assert f"cannot write {name}: " in done.stderr
        assert "fault of roughbench" not in done.stderr
        assert state_of(path.parent) == before, make  # nothing beside it either
        assert (folder / "small.yaml").read_bytes() == spec
        path.rename(folder / f"obstacle {number}")


@EACH
def test_what_roughbench_wrote_is_replaced_and_keeps_its_mode(
    folder: Path, name: str, command: tuple[str, ...]
) -> None:
    assert invoke(*command).exit_code == 0
    path = folder / name
    first = path.read_bytes()
    path.chmod(0o640)
    assert invoke(*command, *(("--force",) if command[0] == "run" else ())).exit_code == 0
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert path.read_bytes().startswith(first[:8])


@EACH
def test_an_empty_file_is_filled(folder: Path, name: str, command: tuple[str, ...]) -> None:
    """As ``mktemp`` leaves it: nothing is lost."""
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.touch(0o600)
    assert invoke(*command).exit_code == 0
    assert path.stat().st_size > 0
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@EACH
def test_a_symbolic_link_is_followed_and_stays(
    folder: Path, name: str, command: tuple[str, ...]
) -> None:
    path, target = folder / name, folder / "elsewhere" / "real"
    path.parent.mkdir(exist_ok=True)
    target.parent.mkdir()
    path.symlink_to(target)
    for _ in range(2):  # to a new file, and to one of ours
        assert invoke(*command).exit_code == 0
        assert path.is_symlink()
        assert target.is_file()
        assert [entry.name for entry in target.parent.iterdir()] == ["real"]
    target.write_text("a thesis")
    assert invoke(*command).exit_code == 1
    assert target.read_text() == "a thesis"
    target.unlink()
    target.parent.rmdir()
    done = invoke(*command)
    assert done.exit_code == 1
    assert "that folder is not there; make it" in done.stderr


def test_heights_are_never_replaced_not_even_those_in_results(folder: Path) -> None:
    """Results files are HDF5, so a run may read its heights from one."""
    heights = np.random.default_rng(1).standard_normal((4, 8))
    results = rb.load("small.h5")
    persson = results["main"]["persson"]
    shape = dict.fromkeys(("area", "separation", "stiffness", "energy"), heights)
    shape |= {"status": np.zeros((4, 8), np.int32), "pressure": np.arange(1.0, 9.0)}
    model = type(persson)("p", "persson", "P", persson.attributes, shape)
    write_results(type(results)({"main": {"p": model}}, "", "", "h"), folder / "h.h5")
    (folder / "h.yaml").write_text(
        "surface: {kind: file, path: 'h.h5:/main/p/area', length: 10.0}\n"
        "pressures: [0.1]\nmodels: [{kind: bem}]\n"
    )
    before = (folder / "h.h5").read_bytes()
    (folder / "link.h5").symlink_to("h.h5")
    os.link("h.h5", "hard.h5")
    for output in ("h.h5", "./h.h5", "link.h5", "hard.h5"):
        done = invoke("run", "h.yaml", "-o", output, "--force")
        assert done.exit_code == 1
        assert f"cannot write {Path(output)}: the same run needs it" in done.stderr
    assert (folder / "h.h5").read_bytes() == before


def test_log_and_results_are_two_files(folder: Path) -> None:
    done = invoke("run", "small.yaml", "-o", "new.h5", "--log-file", "./new.h5")
    assert done.exit_code == 1
    assert "cannot write new.h5: the same run needs it otherwise" in done.stderr
    assert not (folder / "new.h5").exists()


def test_a_file_that_appears_during_the_run_stays(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def meanwhile(*arguments: Any) -> ModelResult:
        (folder / "new.h5").write_text("a thesis")
        return assemble(*arguments)

    monkeypatch.setattr("roughbench.runner.publication.assemble", meanwhile)
    done = invoke("run", "small.yaml", "-o", "new.h5")
    assert done.exit_code == 3  # the tasks are kept
    assert "no results file that roughbench wrote" in done.stderr
    assert (folder / "new.h5").read_text() == "a thesis"


@pytest.mark.parametrize("damage", ["cut", "head", "tail", "middle", 10, 100, 400, 1000])
def test_a_damaged_results_file_is_still_ours(folder: Path, damage: str | int) -> None:
    path = folder / "small.h5"
    whole = path.read_bytes()
    data = bytearray(whole)
    if damage == "cut":
        del data[-500:]
    elif isinstance(damage, int):
        del data[damage:]
    else:
        place = {"head": 0, "middle": len(data) // 2, "tail": len(data) - 60}[damage]
        data[place : place + 50] = bytes(50)
    path.write_bytes(data)
    assert invoke("run", "small.yaml").exit_code == 0
    assert path.read_bytes() == whole
    if isinstance(damage, int) and damage <= 100:  # nothing says whose it was
        path.rename(folder / "other.h5").write_bytes(data)
        done = invoke("run", "small.yaml", "-o", "other.h5")
        assert done.exit_code == 1
        assert (folder / "other.h5").read_bytes() == data


@pytest.mark.parametrize("length", [246, 249])
def test_the_longest_names_are_written(folder: Path, length: int) -> None:
    name = "x" * (length - 3) + ".h5"
    assert invoke("run", "small.yaml", "-o", name).exit_code == 0
    assert rb.load(folder / name)
    page = "y" * 250 + ".html"
    done = invoke("report", name, "-o", page, "--resamples", 5)
    assert (done.exit_code, done.stdout) == (0, f"{page}\n")


@pytest.mark.parametrize("length", [250, 255, 256, 5000])
def test_longer_ones_are_refused_before_anything_is_computed(
    folder: Path, length: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driver, "_compute", lambda *_: pytest.fail("it computes"))
    done = invoke("run", "small.yaml", "-o", "x" * (length - 3) + ".h5")
    assert done.exit_code == 1
    assert "File name too long; choose a shorter name" in done.stderr
    assert sorted(entry.name for entry in folder.iterdir()) == [
        "small.h5",
        "small.h5.rbrun",
        "small.yaml",
    ]


@pytest.mark.parametrize("letter", ["\n", "\x1b", "\u202e", "\u2028"])
def test_names_that_do_not_print_are_refused(folder: Path, letter: str) -> None:
    for kind in (NOTE, RESULTS):
        with pytest.raises(rb.StoreError, match="its name holds the ") as caught:
            check_output(folder / f"a{letter}b", kind)
        assert letter not in str(caught.value)


def test_both_ends_of_a_large_file_are_looked_at(tmp_path: Path) -> None:
    path = tmp_path / "note"
    write_output(b"note" + bytes(300_000) + b".", path, NOTE)
    write_output(b"note.", path, NOTE)
    path.write_bytes(b"note" + bytes(300_000))
    with pytest.raises(rb.StoreError, match="no note that roughbench wrote; choose another"):
        write_output(b"note.", path, NOTE)
    assert path.stat().st_size == 300_004
    assert [entry.name for entry in tmp_path.iterdir()] == ["note"]
