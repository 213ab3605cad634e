"""Which figures the results allow, and the files that come of them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

import roughbench as rb
from roughbench import figures
from roughbench.figures.style import COLUMN
from roughbench.results import ModelResult, Results
from roughbench.store import write_results

Make = Callable[..., ModelResult]
Collect = Callable[..., Results]
Draw = Callable[[Results, str], Figure]
CURVES = ["area", "separation", "stiffness", "fig3"]
PRINTED = ["printed_fig3", "printed_fig4"]
PAPER = ["foundation", "spectrum", *CURVES, *PRINTED]


def test_a_full_run_allows_all_figures(computed: Results) -> None:
    assert figures.available(computed) == [*PAPER, "contact"]
    measured, *others = figures.FIGURES
    assert measured == "surface"  # no measured surface is in these results
    assert others[: len(PAPER)] == PAPER


def test_there_is_a_pdf_and_a_png_of_each_and_nothing_else(rendered: Path) -> None:
    names = [*PAPER, "contact"]
    expected = {f"{name}.{suffix}" for name in names for suffix in ("pdf", "png")}
    assert {path.name for path in rendered.iterdir()} == expected


@pytest.mark.parametrize("name", PAPER)
def test_files_are_valid_and_one_column_wide(rendered: Path, name: str) -> None:
    data = (rendered / f"{name}.pdf").read_bytes()
    assert data.startswith(b"%PDF-1.")
    assert data.rstrip().endswith(b"%%EOF")
    for unwanted in (b"CreationDate", b"Matplotlib", b"/Subtype /Type3"):
        assert unwanted not in data
    box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+)", data)
    assert box is not None
    assert float(box[1]) == pytest.approx(72.0 * COLUMN, abs=0.1)
    image = imread(rendered / f"{name}.png")
    assert image.shape[1] == pytest.approx(300 * COLUMN, abs=1)
    assert image.shape[0] / image.shape[1] == pytest.approx(
        float(box[2]) / float(box[1]), rel=1e-2
    )
    assert np.unique(image[..., :3].sum(axis=2)).size > 50


def test_bytes_depend_on_the_results_alone(
    computed: Results, rendered: Path, tmp_path: Path
) -> None:
    """Not on the process, its hash seed, the date, or the user's settings of Matplotlib."""
    names = ("foundation", "spectrum", "stiffness", "contact")
    results = write_results(computed, tmp_path / "results.h5")
    (tmp_path / "matplotlibrc").write_text("font.size: 30\nlines.linewidth: 9\n")
    script = (
        "import sys; from roughbench import figures, load\n"
        "for name in sys.argv[2:]: figures.render(load(sys.argv[1]), name, '.')\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    settings = {
        "PYTHONHASHSEED": "5",
        "MATPLOTLIBRC": str(tmp_path / "matplotlibrc"),
        "SOURCE_DATE_EPOCH": "86400",
        "PYTHONPATH": str(Path(rb.__file__).parents[1]),
    }
    command = [sys.executable, "-c", script, str(results), *names]
    subprocess.run(command, env=os.environ | settings, cwd=tmp_path, check=True)
    for name in names:
        for file in (f"{name}.pdf", f"{name}.png"):
            assert (tmp_path / file).read_bytes() == (rendered / file).read_bytes(), file


def test_the_users_settings_are_left_as_they_were(computed: Results, tmp_path: Path) -> None:
    with mpl.rc_context({"font.size": 31.0}):
        before = dict(mpl.rcParams)
        figures.render(computed, "area", tmp_path)
        assert dict(mpl.rcParams) == before


def test_importing_the_figures_loads_no_matplotlib() -> None:
    script = "import sys, roughbench.figures; sys.exit('matplotlib' in sys.modules)"
    environment = os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])}
    assert subprocess.run([sys.executable, "-c", script], env=environment).returncode == 0


@pytest.mark.parametrize("kind", ["bem", "foundation", "persson", "winkler"])
def test_one_model_alone_makes_the_curves(
    make: Make, collect: Collect, lay_out: Draw, kind: str
) -> None:
    results = collect(make(kind, n=1))
    assert figures.available(results) == CURVES
    for name in ("fig3", "stiffness"):
        lay_out(results, name)


def test_without_a_foundation_there_is_no_fig_1(
    small_spec: dict[str, Any], tmp_path: Path
) -> None:
    small_spec["models"] = [{"kind": "persson"}]
    results = rb.run(small_spec)
    assert figures.available(results) == ["spectrum", *CURVES, *PRINTED]
    with pytest.raises(
        rb.StoreError,
        match=r"needs the fields of a foundation, .*allow: spectrum, area, separation",
    ):
        figures.render(results, "foundation", tmp_path)
    assert not list(tmp_path.iterdir())


def test_without_fields_fig_1_says_what_to_add_to_the_spec(
    small_spec: dict[str, Any], lay_out: Draw, tmp_path: Path
) -> None:
    small_spec |= {"pressures": [1e-3], "models": [{"kind": "foundation", "springs": 128}]}
    results = rb.run(small_spec)
    assert "foundation" not in figures.available(results)
    with pytest.raises(
        rb.StoreError,
        match=r"asks for with save_fields: \{pressures: \[\.\.\.\], realizations: \[0\]\}",
    ):
        figures.render(results, "foundation", tmp_path)
    small_spec["save_fields"] = {"pressures": [1e-3], "realizations": [0]}
    lay_out(rb.run(small_spec), "foundation")


def test_full_contact_everywhere_has_no_fig_1_and_no_stiffness(
    small_spec: dict[str, Any], lay_out: Draw, tmp_path: Path
) -> None:
    small_spec |= {"pressures": [1.0, 2.0], "models": [{"kind": "foundation", "springs": 128}]}
    small_spec["save_fields"] = {"pressures": [1.0], "realizations": [0]}
    results = rb.run(small_spec)
    assert figures.available(results) == ["spectrum", "area", "separation", "fig3", "contact"]
    lay_out(results, "fig3")
    with pytest.raises(rb.StoreError, match="needs a model with a finite stiffness"):
        figures.render(results, "stiffness", tmp_path)


def test_heights_from_a_file_have_no_spectrum(tmp_path: Path) -> None:
    x = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    np.save(tmp_path / "line.npy", np.cos(x) + 0.2 * np.sin(5.0 * x))
    spec = {
        "surface": {"kind": "file", "path": str(tmp_path / "line.npy"), "length": 6.0},
        "pressures": [1e-3, 1e-2, 1e-1],
        "models": [{"kind": "foundation"}],
    }
    fields = {"save_fields": {"pressures": [1e-3], "realizations": [0]}}
    assert figures.available(rb.run(spec | fields)) == ["foundation", *CURVES, "contact"]
    results = rb.run(spec)
    assert figures.available(results) == CURVES
    with pytest.raises(rb.StoreError, match="'spectrum' needs a surface given by its spectrum"):
        figures.render(results, "spectrum", tmp_path)
    (tmp_path / "line.npy").unlink()
    assert figures.available(results) == CURVES


def test_a_spec_that_cannot_be_read_leaves_what_is_in_the_results(
    computed: Results, tmp_path: Path
) -> None:
    results = replace(computed, spec_text="surface: {H: 7}")
    assert figures.available(results) == ["foundation", *CURVES, *PRINTED, "contact"]
    with pytest.raises(rb.StoreError, match="'spectrum' needs the results' spec"):
        figures.render(results, "spectrum", tmp_path)


def test_empty_results_allow_nothing(collect: Collect, tmp_path: Path) -> None:
    assert figures.available(collect()) == []
    with pytest.raises(rb.StoreError, match=r"'area' needs the results of a model.*: none"):
        figures.render(collect(), "area", tmp_path)


def test_an_unknown_figure_names_the_known_ones(computed: Results, tmp_path: Path) -> None:
    with pytest.raises(
        rb.StoreError, match=r"no figure 'fig9'; choose one of surface, foundation, sp"
    ):
        figures.render(computed, "fig9", tmp_path)


def test_a_folder_that_cannot_be_made_is_an_error(computed: Results, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(rb.StoreError, match=r"file is no folder; choose another place"):
        figures.render(computed, "area", tmp_path / "file")
    with pytest.raises(rb.StoreError, match=r"file is no folder; choose another place"):
        figures.render(computed, "area", tmp_path / "file" / "below")


def test_states_in_any_state_can_be_drawn(make: Make, collect: Collect, lay_out: Draw) -> None:
    """All states unconverged, one pressure, zero area: nothing to see, but no crash."""
    nothing = make("bem", status=np.ones((3, 4), int))
    single = make(pressure=np.array([1e-3]))
    results = collect(experiments={"nothing": [nothing], "single": [single]})
    for name in ("fig3", "stiffness"):
        lay_out(results, name)
    assert figures.available(collect(nothing)) == ["area", "separation", "fig3"]
