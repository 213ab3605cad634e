"""Compiled loops that are kept: used when they are whole, compiled again when they are not."""

from __future__ import annotations

import ast
import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

import roughbench as rb
from roughbench.models._compiled import compiled
from roughbench.models.compilation import compiling_told


def twice(x: Any) -> Any:
    return 2 * x + 1


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    return tmp_path


def files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.is_file()]


def hits(loop: Any) -> int:
    return sum(loop.stats.cache_hits.values())


def test_a_loop_is_compiled_once(folder: Path) -> None:
    first = compiled()(twice)
    assert (first(3), first(0.5), hits(first)) == (7, 2.0, 0)
    assert len(files(folder)) == 2
    second = compiled()(twice)
    assert (second(3), second(0.5), hits(second)) == (7, 2.0, 2)


def test_a_compilation_is_told(folder: Path) -> None:
    assert folder.exists()
    told: list[bool] = []
    for times in (1, 1):
        with compiling_told(lambda: told.append(True)):
            loop = compiled()(twice)
            loop(3)
            loop(4)
        assert len(told) == times
    compiled()(twice)(0.5)  # nobody listens any more
    assert len(told) == 1


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


def empty(path: Path) -> None:
    path.write_bytes(b"")


def nonsense(path: Path) -> None:
    path.write_bytes(b"\x80\x05nonsense" * 1000)


def folder_instead(path: Path) -> None:
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize("damage", [truncate, empty, nonsense, folder_instead, Path.unlink])
def test_a_damaged_file_is_compiled_again(folder: Path, damage: Callable[[Path], None]) -> None:
    compiled()(twice)(3)
    (path,) = files(folder)
    damage(path)
    second = compiled()(twice)
    assert (second(3), hits(second)) == (7, 0)
    third = compiled()(twice)
    assert (third(3), hits(third)) == (7, path.is_file())  # replaced, where that is possible


def test_no_byte_of_a_file_can_be_wrong(folder: Path, rng: np.random.Generator) -> None:
    compiled()(twice)(3)
    (path,) = files(folder)
    whole = path.read_bytes()
    for place in [0, 40, len(whole) - 1, *rng.integers(0, len(whole), 7)]:
        wrong = bytearray(whole)
        wrong[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(bytes(wrong))
        loop = compiled()(twice)
        assert (loop(3), hits(loop)) == (7, 0)


def test_files_of_another_type_are_not_used(folder: Path) -> None:
    loop = compiled()(twice)
    loop(3)
    (integer,) = files(folder)
    loop(0.5)
    (real,) = set(files(folder)) - {integer}
    real.write_bytes(integer.read_bytes())  # whole, but of an integer
    second = compiled()(twice)
    assert (second(0.5), hits(second)) == (2.0, 0)


def test_files_of_another_source_are_not_used(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # Python itself goes by the times
    source = folder / "source.py"

    def computed(text: str) -> tuple[int, int]:
        source.write_text(f"A = {text}\n\ndef f(x):\n    return A * x\n")
        os.utime(source, (0, 0))  # as a build that can be repeated leaves them
        spec = importlib.util.spec_from_file_location("source", source)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        loop = compiled()(module.f)
        return loop(3), hits(loop)

    assert [computed("2"), computed("2"), computed("3")] == [(6, 0), (6, 1), (9, 0)]


def test_files_are_of_all_named_sources(folder: Path) -> None:
    """What other modules give to a loop is compiled into it."""
    constants = folder / "constants.py"
    found = []
    for text in ("A = 2", "A = 2", "A = 3"):
        constants.write_text(text)
        os.utime(constants, (0, 0))
        loop = compiled(sources=[constants])(twice)
        found.append((loop(3), hits(loop)))
    assert found == [(7, 0), (7, 1), (7, 0)]


def test_the_solvers_loops_name_all_their_sources() -> None:
    """They take nothing of the package but from the module that their decorator names."""
    folder = Path(rb.__file__).parent / "models" / "halfspace" / "loops"
    modules = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
    assert len(modules) > 2
    for path in modules:
        names = [
            node.module
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("roughbench")
        ]
        assert names == ["roughbench.models.halfspace.loops"], path.name


def test_without_a_place_for_files(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "file" / "folder"))
    assert compiled()(twice)(3) == 7


def test_a_solver_whose_files_are_damaged(tmp_path: Path) -> None:
    environment = os.environ | {
        "NUMBA_CACHE_DIR": str(tmp_path),
        "PYTHONPATH": str(Path(rb.__file__).parents[1]),
    }
    program = (
        "import numpy as np, roughbench as rb\n"
        "from roughbench.models._foundation_loops import grow_regions as loop\n"
        "surface = {'H': 0.7, 'q0': 1.0, 'q1': 32.0, 'slope': 0.1}\n"
        "models = [{'kind': 'foundation', 'springs': 128}]\n"
        "spec = {'surface': surface, 'pressures': [0.001, 0.01], 'models': models}\n"
        "texts = []\n"
        "r = rb.run(spec, progress=lambda news: texts.append(news.text))\n"
        "hits = sum(loop.stats.cache_hits.values())\n"
        "assert ('compiling, once' in texts) == (hits == 0)\n"
        "print(r['main']['foundation']['area'].tolist(), hits)"
    )

    def printed() -> str:
        command = [sys.executable, "-c", program]
        return subprocess.run(
            command, capture_output=True, text=True, check=True, env=environment
        ).stdout

    numbers = printed()
    assert numbers.endswith(" 0\n")
    assert printed() == numbers.replace(" 0\n", " 1\n")
    for path in files(tmp_path):
        content = bytearray(path.read_bytes())
        middle = len(content) // 2  # machine code: it was a segmentation fault
        content[middle : middle + 4000] = os.urandom(4000)
        path.write_bytes(bytes(content))
    assert printed() == numbers
    assert printed() == numbers.replace(" 0\n", " 1\n")
