"""Runs with an observable in a file: named in the spec, in workers, again after an edit."""

from __future__ import annotations

import json
import pickle
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from matplotlib.lines import Line2D
from numpy.typing import NDArray

import roughbench as rb
from roughbench import figures
from roughbench.cli import main
from roughbench.cli.results_csv import observables_csv, summary_csv
from roughbench.cli.tables import as_text
from roughbench.engines.compute import compute
from roughbench.errors import RoughbenchError, StoreError
from roughbench.figures.rebuild import spec_fault
from roughbench.observables import OBSERVABLES
from roughbench.observables.described import DescribedObservable, described, description
from roughbench.planning.plan import plan
from roughbench.planning.tasks import Task
from roughbench.report import make_report
from roughbench.rundir.identity import identity, key_of, observing_digest
from roughbench.spec import json_schema

GAPS = "gaps.py:Gaps"
TEXT = '''\
import numpy as np

import bins
from roughbench.observables import Observable, Profile
from roughbench.quantities import Variable


class Gaps(Observable):
    """How the gap is distributed out of contact."""

    name = "gaps"
    title = "Distribution of <gaps>"
    x, y = "gap $g/h_rms$", "share"
    x_is_log = False
    is_in_heights = True
    values = Variable("share of points with a gap in the bin", length=-1)
    places = Variable("gap / h_rms")
    scalars = {"average": Variable("mean gap out of contact", length=1)}
    attributes = ("gaps_limit",)

    def compute(self, field):
        gap = field.gap[~field.contact]
        counts, _ = np.histogram(gap / field.rms_height, bins.EDGES)
        return Profile(
            self.name,
            edges=bins.EDGES,
            places=(bins.EDGES[1:] + bins.EDGES[:-1]) / 2.0,
            values=counts / field.pressure.size,
            scalars={"average": float(gap.mean()) if gap.size else 0.0},
        )

    def theory(self, origin, places):
        return np.outer(np.ones(len(origin.pressures)), np.exp(-places))

    def theory_title(self, attributes):
        return f"Exponential, up to {attributes['gaps_limit']:.0f}"

    def parameters(self, origin):
        return {"gaps_limit": 8.0}

    def drawn_unit(self, places, dimension):
        return 2.0 * np.ones(places.shape)
'''
BINS = "import numpy as np\n\nEDGES = np.linspace(0.0, 8.0, 21)\n"


def write_spec(folder: Path, *observables: str, **more: Any) -> Path:
    (folder / "gaps.py").write_text(TEXT, encoding="utf-8")
    (folder / "bins.py").write_text(BINS, encoding="utf-8")
    path = folder / "observed.yaml"
    tree = {
        "name": "observed",
        "surface": {"H": 0.7, "q0": 1.0, "qr": 2.0, "q1": 16.0, "slope": 0.1},
        "pressures": [1e-3, 1e-2],
        "realizations": 3,
        "models": [{"kind": "foundation", "springs": 64}, {"kind": "persson"}],
        "observables": [*(observables or (GAPS, "clusters"))],
    }
    path.write_text(yaml.safe_dump(tree | more, sort_keys=False))
    return path


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the results of the spec; its files are not there any more, or harmful."""
    folder = tmp_path_factory.mktemp("observed")
    rb.run(write_spec(folder), output=folder / "o.h5", threads=1)
    (folder / "gaps.py").write_text("raise ZeroDivisionError\n")
    return folder / "o.h5"


def test_its_values_are_in_the_results(output: Path) -> None:
    model = rb.load(output)["main"]["foundation"]
    assert model["gaps"].shape == (3, 2, 20)
    assert model["gaps_average"].shape == (3, 2)
    np.testing.assert_allclose(model["gaps_mean"], model["gaps"].mean(axis=0))
    np.testing.assert_allclose(model["gaps_average_mean"], model["gaps_average"].mean(axis=0))
    assert model["gaps_persson"].shape == (2, 20)
    assert (model["gaps_drawn_unit"] == 2.0).all()
    assert model.units("gaps_mean") == "1/length"
    assert model.units("gaps_average_sem") == "length"
    assert model.long_name("gaps_bin") == "gap / h_rms"
    assert model.attributes["gaps_limit"] == 8.0
    height = float(model.attributes["rms_height"])
    shares, places = model["gaps"], model["gaps_bin"]
    moments = (shares * places).sum(axis=-1) * height
    assert (moments[:, 0] > 0.0).all()
    # Each gap is off by at most half a bin of 0.4 h_rms.
    means = model["gaps_average"] * shares.sum(axis=-1)
    np.testing.assert_allclose(moments, means, atol=0.2 * height)
    assert "gaps" not in rb.load(output)["main"]["persson"]


def test_results_show_and_draw_it_without_its_file(output: Path, tmp_path: Path) -> None:
    results = rb.load(output)
    assert spec_fault(results) is None
    text = as_text(results, "o.h5")
    assert "observables from outside: gaps (gaps.py:Gaps)" in text
    assert "gaps_limit" not in text
    assert "observable_gaps" not in text
    tables = observables_csv(results["main"]["foundation"])
    assert list(tables) == ["clusters", "gaps"]
    heading = "pressure [1],gaps_bin [1],gaps_mean [1/length],gaps_sem [1/length],gaps_persson"
    assert tables["gaps"].startswith(heading)
    assert "gaps_average_mean [length]" in summary_csv(results["main"]["foundation"])
    assert {"gaps", "clusters"} <= set(figures.available(results))
    done = CliRunner().invoke(
        main, ["plot", str(output), "-o", str(tmp_path), "--figure", "gaps"]
    )
    assert done.exit_code == 0, done.stderr
    assert (tmp_path / "gaps.png").stat().st_size > 10_000
    page = make_report([output], resamples=2)
    assert "Distribution of &lt;gaps&gt;" in page
    assert "<gaps>" not in page


def test_the_figure_says_what_the_class_says(output: Path) -> None:
    results = rb.load(output)
    (gaps,) = described(results["main"]["foundation"].attributes)
    assert gaps.theory_title({}) == "Exponential, up to 8"
    recipe = figures.recipes_of(results)["gaps"]
    axes = recipe.draw(results).axes[0]
    assert (axes.get_xscale(), axes.get_ylabel()) == ("linear", "share")
    line = next(line for line in axes.lines if "Exponential" in str(line.get_gid()))
    np.testing.assert_allclose(drawn(line, "y"), np.exp(-drawn(line, "x")))
    own = next(other for other in axes.lines if other is not line)
    model = results["main"]["foundation"]
    shown = model["gaps_mean"][0] > 0.0
    np.testing.assert_allclose(drawn(own, "y"), model["gaps_mean"][0][shown] / 2.0)


def drawn(line: Line2D, axis: str) -> NDArray[np.float64]:
    return np.asarray(line.get_xdata() if axis == "x" else line.get_ydata(), float)


def test_its_units_are_those_of_the_spec(tmp_path: Path) -> None:
    given = {
        "surface": {"H": 0.7, "q0": "1 / um", "qr": "2 / um", "q1": "16 / um", "slope": 0.1},
        "modulus": {"E*": "3 GPa"},
        "pressures": ["3 MPa", "30 MPa"],
    }
    plain = rb.run(write_spec(tmp_path, GAPS), threads=1)["main"]["foundation"]
    spec = write_spec(tmp_path, GAPS, **given)
    text = TEXT.replace('bin", length=-1)', 'bin", modulus=1)')
    assert text != TEXT
    (tmp_path / "gaps.py").write_text(text)
    output = tmp_path / "o.h5"
    rb.run(spec, output=output, threads=1)
    with_units = rb.load(output)["main"]["foundation"]
    assert with_units.units("gaps_mean") == "Pa"
    assert with_units.units("gaps_average") == "m"
    assert with_units.units("gaps_bin") == "1"
    np.testing.assert_allclose(with_units["gaps"], 3e9 * plain["gaps"], rtol=1e-9)
    np.testing.assert_allclose(with_units["gaps_average"], 1e-6 * plain["gaps_average"])
    np.testing.assert_allclose(with_units.reduced()["gaps"], plain["gaps"], rtol=1e-9)
    assert (with_units["gaps_drawn_unit"] == 2.0).all()
    results = rb.load(output)
    axes = figures.recipes_of(results)["gaps"].draw(results).axes[0]
    assert axes.get_ylabel() == "share (MPa)"
    own = next(line for line in axes.lines if "Exponential" not in str(line.get_gid()))
    shown = with_units["gaps_mean"][0] > 0.0
    values = with_units["gaps_mean"][0][shown] / 2.0
    np.testing.assert_allclose(drawn(own, "y"), values / 1e6)


def test_worker_processes_have_it(tmp_path: Path) -> None:
    spec = write_spec(tmp_path, realizations=40)
    rb.run(spec, output=tmp_path / "one.h5", jobs=1, threads=1)
    rb.run(spec, output=tmp_path / "two.h5", jobs=2, threads=1)
    assert (tmp_path / "one.h5").read_bytes() == (tmp_path / "two.h5").read_bytes()


def test_a_task_carries_it_to_a_process_without_its_file(tmp_path: Path) -> None:
    """As to the worker of a cluster, which gets what Dask makes of a task."""
    dask = pytest.importorskip("distributed.protocol.pickle")
    cell = plan(rb.load_spec(write_spec(tmp_path, GAPS)))[0]
    task = Task(cell, range(3), cell.pressures)
    here = compute(task)
    for name in ("gaps.py", "bins.py"):
        (tmp_path / name).unlink()
    code = (
        "import pickle, sys, numpy as np; task = pickle.load(open(sys.argv[1], 'rb'));"
        "from roughbench.engines.compute import compute;"
        "from roughbench.rundir.identity import observing_digest;"
        "np.savez(sys.argv[2], **compute(task));"
        "print(observing_digest(task.cell.asked.observables))"
    )
    for dumps in (pickle.dumps, dask.dumps):
        (tmp_path / "task.pickle").write_bytes(dumps(task))
        done = subprocess.run(
            [sys.executable, "-c", code, tmp_path / "task.pickle", tmp_path / "there.npz"],
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout.strip() == observing_digest(cell.asked.observables)
        with np.load(tmp_path / "there.npz") as there:
            assert there.files == list(here)
            np.testing.assert_array_equal(there["gaps"], here["gaps"])


def test_an_edit_computes_again_what_it_concerns(tmp_path: Path) -> None:
    spec = write_spec(tmp_path)
    output = tmp_path / "o.h5"
    rb.run(spec, output=output, threads=1)
    cells = keys(spec)
    (tmp_path / "gaps.py").write_text(TEXT.replace('"""How', '"""In which way'))
    assert keys(spec) == cells
    (tmp_path / "bins.py").write_text(BINS.replace("8.0", "9.0"))
    edited = keys(spec)
    assert edited["main/foundation"] != cells["main/foundation"]
    assert edited["main/persson"] == cells["main/persson"]
    results = rb.run(spec, output=output, threads=1)
    assert results["main"]["foundation"]["gaps_edges"][-1] == 9.0


def keys(spec: Path) -> dict[str, str]:
    return {str(cell): key_of(identity(cell, 1)) for cell in plan(rb.load_spec(spec))}


@pytest.mark.parametrize(
    ("before", "after", "reference", "message"),
    [
        ("", "", "gasp.py:Gaps", "no such file: gasp.py (did you mean 'gaps.py'?)"),
        ("", "", "gaps.py:Gasp", "gaps.py has no class 'Gasp' (did you mean 'Gaps'?)"),
        ("", "", "gaps.py:Zzz", "gaps.py has no class 'Zzz'; its observables: Gaps"),
        ("", "", "gaps.py", "must name a class too, as in gaps.py:Gaps"),
        ("", "", "gaps.py:Profile", "is not a subclass of roughbench.observables.Observable"),
        ("import bins", "import bin5", GAPS, "gaps.py:3: ModuleNotFoundError"),
        ("class Gaps(", "class Gaps)(", GAPS, "gaps.py:8: unmatched ')'"),
        ("def compute", "def computed", GAPS, "gaps.py:Gaps lacks compute; see docs/adding-an"),
        ('    name = "gaps"\n', "", GAPS, "gaps.py:Gaps lacks name, a str; see docs/adding-an"),
        ('name = "gaps"', "name = 3", GAPS, "gaps.py:Gaps lacks name, a str, got 3"),
        ('name = "gaps"', 'name = "../x"', GAPS, "names must have a letter first, then"),
        (
            'name = "gaps"',
            'name = "clusters"',
            GAPS,
            "'clusters', which another observable has",
        ),
        ("$g/h_rms$", "$g/h_rms", GAPS, "x has a $ without another, which ends the formula"),
        (
            "    def theory(",
            "    def __init__(self, x): pass\n\n    def theory(",
            GAPS,
            "TypeEr",
        ),
    ],
)
def test_what_is_wrong_has_its_place(
    tmp_path: Path, before: str, after: str, reference: str, message: str
) -> None:
    spec = write_spec(tmp_path, "clusters", reference)
    assert before in TEXT
    (tmp_path / "gaps.py").write_text(TEXT.replace(before, after, 1) if before else TEXT)
    with pytest.raises(rb.SpecError) as caught:
        rb.load_spec(spec)
    (fault,) = caught.value.faults
    assert re.search(r"observed\.yaml:\d+:3: error: observables\[1\]: ", str(fault))
    assert message in str(fault)


def test_two_of_one_name_do_not_meet(tmp_path: Path) -> None:
    spec = write_spec(tmp_path, GAPS, "./gaps.py:Gaps")
    with pytest.raises(
        rb.SpecError, match=r"\[1\]: has the name gaps as gaps\.py:Gaps; choose"
    ):
        rb.load_spec(spec)


@pytest.mark.parametrize(
    ("change", "variable"),
    [
        (('name = "gaps"', 'name = "area"'), "area"),
        (('"average": Var', '"mean": Var'), "gaps_mean"),
        (('name = "gaps"', 'name = "gaps"\n    variable = "status"'), "status"),
    ],
)
def test_a_variable_that_is_taken(
    tmp_path: Path, change: tuple[str, str], variable: str
) -> None:
    spec = write_spec(tmp_path, GAPS)
    (tmp_path / "gaps.py").write_text(TEXT.replace(*change))
    with pytest.raises(RoughbenchError, match=rf"would have a variable '{variable}', which is"):
        rb.run(spec, output=tmp_path / "o.h5")
    assert not (tmp_path / "o.h5").exists()


def test_an_error_of_it_comes_back_with_its_line(tmp_path: Path) -> None:
    spec = write_spec(tmp_path)
    broken = TEXT.replace("gap = field.gap[", "gap = field.gaps[")
    (tmp_path / "gaps.py").write_text(broken)
    line = 1 + broken[: broken.index("field.gaps[")].count("\n")
    message = rf"the observable gaps: gaps\.py:{line}: AttributeError: 'Field' object has no"
    for jobs in (1, 2):
        with pytest.raises(RoughbenchError, match=message):
            rb.run(spec, output=tmp_path / "o.h5", jobs=jobs, threads=1)


def test_the_schema_admits_it() -> None:
    names, file = json_schema()["properties"]["observables"]["anyOf"][0]["items"]["anyOf"]
    assert names["enum"] == [*OBSERVABLES]
    assert re.search(file["pattern"], GAPS)
    assert not re.search(file["pattern"], "gaps.py")


# -- what a file says of it ------------------------------------------------------------------


@pytest.mark.parametrize("name", OBSERVABLES)
def test_a_description_says_all_that_a_figure_needs(name: str) -> None:
    real = OBSERVABLES[name]
    attributes = dict.fromkeys(real.attributes, 1.0)
    read = DescribedObservable(description(real, attributes))
    for field in ("name", "variable", "title", "x", "y", "x_is_log", "is_in_heights"):
        assert getattr(read, field) == getattr(real, field)
    assert (read.values, read.places) == (real.values, real.places)
    assert (dict(read.scalars), read.attributes) == (dict(real.scalars), real.attributes)
    assert read.theory_title({}) == real.theory_title(attributes)


@pytest.mark.parametrize(
    "change",
    [{"title": 3}, {"values": None}, {"scalars": []}, {"attributes": [1]}, {"x": None}],
)
def test_a_spoiled_description_is_told(output: Path, change: dict[str, Any]) -> None:
    result = rb.load(output)["main"]["foundation"]
    text = json.dumps(json.loads(str(result.attributes["observable_gaps"])) | change)
    with pytest.raises(StoreError, match="attribute observable_gaps describes no observable"):
        described({"observable_gaps": text})
    with pytest.raises(StoreError, match="attribute observable_gaps "):
        described({"observable_gaps": "["})


# -- figures of files ------------------------------------------------------------------------

FIGURE = """\
class AreaOverPressure:
    def missing(self, results):
        return None if any(results.models()) else "a model"

    def draw(self, results):
        from matplotlib.figure import Figure

        figure = Figure()
        axes = figure.add_subplot(xscale="log")
        for _, model in results.models():
            axes.plot(model["pressure"], model["area_mean"] / model["pressure"])
        return figure
"""


def plot(output: Path, reference: str) -> Any:
    words = ["plot", str(output), "-o", "drawn", "--figure", reference]
    return CliRunner().invoke(main, words)


def test_a_figure_of_a_file(
    output: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(FIGURE)
    done = plot(output, "mine.py:AreaOverPressure")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.split() == [
        "drawn/area_over_pressure.pdf",
        "drawn/area_over_pressure.png",
    ]
    assert Path("drawn/area_over_pressure.png").stat().st_size > 5_000


@pytest.mark.parametrize(
    ("change", "reference", "message"),
    [
        (
            ("", ""),
            "mine.py:AreaOver",
            "mine.py has no class 'AreaOver' (did you mean 'AreaOverP",
        ),
        (
            ("", ""),
            "myne.py:AreaOverPressure",
            "no such file: myne.py (did you mean 'mine.py'?)",
        ),
        (
            ("def draw", "def drew"),
            "mine.py:AreaOverPressure",
            "lacks draw; see docs/adding-an-",
        ),
        (
            ("AreaOverPressure", "Area"),
            "mine.py:Area",
            "there is a figure 'area' already; rename",
        ),
        (
            ("figure.add_subplot", "figure.subplot"),
            "mine.py:AreaOverPressure",
            "the figure area_over_pressure: mine.py:9: AttributeError: ",
        ),
        (
            ("None if any(results.models()) else ", ""),
            "mine.py:AreaOverPressure",
            "needs a model; figures that",
        ),
    ],
)
def test_what_is_wrong_with_a_figure_is_said(
    output: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    change: tuple[str, str],
    reference: str,
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(FIGURE.replace(*change) if change[0] else FIGURE)
    done = plot(output, reference)
    assert done.exit_code == 1
    assert done.stderr.startswith("error: ")
    assert message in done.stderr
    assert "fault of roughbench" not in done.stderr
