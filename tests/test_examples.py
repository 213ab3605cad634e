"""The examples run, and say what they should."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb

ROOT = Path(rb.__file__).parents[1]
EXAMPLES = ROOT / "examples"


def output_of(*arguments: object) -> list[list[str]]:
    """Return the words of each line that an example prints."""
    done = subprocess.run(
        [sys.executable, "-W", "error", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert done.stderr == ""
    return [line.split() for line in done.stdout.splitlines()]


def test_own_heights(tmp_path: Path, rng: np.random.Generator) -> None:
    heights = rng.normal(size=(8, 8))
    np.save(tmp_path / "h.npy", heights)
    _, *rows = output_of(EXAMPLES / "own_heights.py", tmp_path / "h.npy", 2.0)
    curve = rb.solve_curve(heights, np.geomspace(1e-3, 0.1, 5), length=2.0)
    assert [float(row[1]) for row in rows] == pytest.approx(curve.area.tolist(), abs=6e-5)
    assert [row[4] for row in rows] == ["0"] * 5
    assert len(output_of(EXAMPLES / "own_heights.py")) == 6


def test_compare_results(small_spec: dict[str, Any], tmp_path: Path) -> None:
    rb.run(small_spec, output=tmp_path / "a.h5")
    rb.run(small_spec | {"seed": 8}, output=tmp_path / "b.h5")
    compare = EXAMPLES / "compare_results.py"
    found = output_of(compare, tmp_path / "a.h5", tmp_path / "b.h5")
    by_name = {(row[0], row[1]): float(row[2].rstrip(",")) for row in found}
    assert by_name["main/persson:", "area"] == 0.0
    assert 0.0 < by_name["main/foundation:", "area"] < 1.0
    same = output_of(compare, tmp_path / "a.h5", tmp_path / "a.h5")
    assert {float(row[2].rstrip(",")) for row in same} == {0.0}


def test_a_theory_of_ones_own() -> None:
    models = rb.run(EXAMPLES / "mytheory.yaml")["main"]
    assert list(models) == ["bem", "persson", "erf09"]
    assert "stiffness" not in models["erf09"]
    ratio = models["erf09"]["area_mean"] / models["persson"]["area_mean"]
    assert ratio[0] == pytest.approx(0.9, rel=0.01)  # both proportional to p


def test_reduction_of_dimensionality() -> None:
    """Exact on smooth indenters; with roughness the stiffness stays near, the area does not."""
    lines = output_of(EXAMPLES / "reduction.py")
    middle = next(i for i, words in enumerate(lines) if words[0] == "rms")
    smooth = np.array([words[-6:] for words in lines[1:middle]], float)
    assert len(smooth) == 3
    # Approach, K and A, from the half-space and from the springs.
    np.testing.assert_allclose(smooth[:, 0::2], smooth[:, 1::2], rtol=2e-3)
    np.testing.assert_allclose(smooth[:, 3], 2 * 0.25, rtol=1e-3)
    rough = np.array(lines[middle + 1 :], float)
    np.testing.assert_allclose(rough[0, 1:], 1.0, atol=3e-3)
    np.testing.assert_allclose(rough[:, 2], 1.0, atol=0.05)
    assert (np.diff(rough[:, 3]) > 0).all()
    assert rough[-1, 3] > 2.0


def test_the_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")
    notebook = json.loads((EXAMPLES / "first_run.ipynb").read_text(encoding="utf-8"))
    names: dict[str, Any] = {}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            exec(compile("".join(cell["source"]), "notebook", "exec"), names)  # noqa: S102
    assert set(names["ratios"]) == {"foundation", "persson"}
    assert min(names["ratios"]["foundation"]) > 1.0
    names["plt"].close(names["figure"])


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.ipynb")), ids=lambda path: path.stem)
def test_notebooks_are_kept_without_output(path: Path) -> None:
    """They run in CI: make notebooks."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    for cell in notebook["cells"]:
        assert cell["cell_type"] in ("markdown", "code")
        if cell["cell_type"] == "code":
            assert (cell["outputs"], cell["execution_count"]) == ([], None)
            compile("".join(cell["source"]), path.name, "exec")  # no magic: plain Python
    assert notebook["metadata"]["kernelspec"]["name"] == "python3"


def test_all_of_them_are_listed() -> None:
    page = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    names = {path.name for path in EXAMPLES.iterdir() if path.name != "README.md"}
    assert {name for name in names if f"({name})" not in page} == set()
