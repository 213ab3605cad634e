"""Results computed anew: from files of this version and of an earlier one, and what differs."""

from __future__ import annotations

import dataclasses
import json
import lzma
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from roughbench.cli import main
from roughbench.figures import needed
from roughbench.results import Results
from roughbench.runner.comparison import allowance, compare
from roughbench.runner.needs import needs_of
from roughbench.runner.origins import changed_options, differences
from roughbench.store import load, write_results

EARLIER = Path(__file__).parents[1] / "data" / "release-0.2.h5.xz"
"""Of roughbench 0.2.0: bem on 32² points, foundation, Persson, line; two realizations."""


@pytest.fixture(scope="module")
def earlier(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("earlier") / "release-0.2.h5"
    path.write_bytes(lzma.decompress(EARLIER.read_bytes()))
    return path


@pytest.fixture(scope="module")
def old(earlier: Path) -> Results:
    return load(earlier)


def changed(results: Results, label: str, **variables: Any) -> Results:
    """Return results with other values of one model."""
    models = dict(results["main"])
    given = {**models[label].variables, **variables}
    models[label] = dataclasses.replace(models[label], variables=given)
    return dataclasses.replace(results, experiments={"main": models})


def reproduce(*arguments: object) -> tuple[int, str]:
    found = CliRunner().invoke(main, ["reproduce", *map(str, arguments), "-j", "1", "-q"])
    return found.exit_code, found.output


def test_a_file_of_the_earlier_release_is_reproduced(
    earlier: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    before = earlier.read_bytes()
    code, text = reproduce(earlier, "--threads", 1, "--json")
    found = json.loads(text)
    rows = {(one["model"], one["quantity"]): one for one in found["deviations"]}
    for label, realizations in (("bem", 2), ("line", 2), ("foundation", 4), ("persson", 1)):
        for quantity in ("area", "separation", "stiffness", "energy"):
            assert rows[f"main/{label}", quantity]["states"] == 3 * realizations
    others = [where for where, row in rows.items() if not row["agrees"]]
    assert others == [("main/line", "area")], text  # 0.2.0 did not correct it (CHANGELOG)
    assert code == 1
    assert rows["main/line", "area_raw"]["deviation"] == 0.0
    ends = 0.190 / 64 * 4 / (3 / 64)  # two patches of three points in all
    assert rows["main/line", "area"]["deviation"] == pytest.approx(ends, rel=0.01)
    assert rows["main/bem", "area"]["allowed"] == pytest.approx(1e-3)
    assert rows["main/bem", "separation"]["deviation"] < 1e-4
    assert rows["main/persson", "stiffness"]["deviation"] < 1e-12
    assert found["origin_is_known"] is False
    assert earlier.read_bytes() == before
    assert sorted(load("release-0.2-reproduced.h5")["main"]) == sorted(load(earlier)["main"])


def test_a_deviation_ends_with_1_and_names_the_place(
    old: Results, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    stiffness = old["main"]["persson"]["stiffness"].copy()
    stiffness[0, 1] *= 1.01
    write_results(changed(old, "persson", stiffness=stiffness), tmp_path / "off.h5")
    code, text = reproduce("off.h5", "--figure", "stiffness", "--threads", 1)
    assert code == 1
    line = next(line for line in text.splitlines() if line.startswith("main/persson"))
    assert "DIFFERS, most at realization 1, pressure 2" in line
    assert text.splitlines()[-1] == "off-reproduced.h5 DIFFERS from off.h5"
    assert "separation" not in text, "the figure does not show it"
    assert "off.h5 does not say by which versions it was made" in text
    code, text = reproduce("off.h5", "--figure", "stiffness", "--tolerance", 0.02)
    assert (code, "off-reproduced.h5 agrees with off.h5" in text) == (0, True)


def test_what_cannot_be_reproduced_is_refused(
    earlier: Path, old: Results, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(earlier, "same.h5")
    assert reproduce("same.h5", "-o", "same.h5") == (
        1,
        "error: same.h5: is the file to be reproduced; choose another with -o\n",
    )
    code, text = reproduce("same.h5", "--figure", "contact")
    assert (code, "needs fields" in text) == (1, True)
    code, text = reproduce("same.h5", "--figure", "spectrum")
    assert (code, "nothing is computed for it" in text) == (2, True)
    code, text = reproduce("none.h5")
    assert (code, "no such file" in text) == (1, True)
    strange = dataclasses.replace(old, spec_text=old.spec_text.replace("surface:", "surfaces:"))
    write_results(strange, tmp_path / "strange.h5")
    code, text = reproduce("strange.h5")
    assert code == 2
    assert "surfaces: unknown key" in text
    assert "this is the spec in strange.h5" in text
    assert not list(tmp_path.glob("*-reproduced.h5"))


def test_nothing_deviates_from_itself(old: Results) -> None:
    rows, faults = compare(old, old)
    assert faults == []
    assert len(rows) == 26
    assert all(row.agrees and row.deviation == 0.0 for row in rows)


def test_the_deviation_of_a_mean_is_counted_in_standard_errors(old: Results) -> None:
    result = old["main"]["foundation"]
    mean = result["area_mean"] + 0.5 * result["area_sem"]
    new = changed(old, "foundation", area_mean=mean)
    rows = {(row.model, row.quantity): row for row in compare(old, new)[0]}
    assert rows["main/foundation", "area"].of_error == pytest.approx(0.5)
    assert np.isnan(rows["main/persson", "area"].of_error)


@pytest.mark.parametrize(
    ("points", "moved", "differing"),
    [(1.0, 1, []), (3.0, 1, ["main/bem"]), (1.0, 0, ["main/bem"])],
)
def test_an_area_may_differ_by_two_grid_points_where_one_has_moved(
    old: Results, points: float, moved: int, differing: list[str]
) -> None:
    bem = old["main"]["bem"]
    raw = bem["area_raw"].copy()
    raw[0, 0] += moved / 32**2
    new = changed(old, "bem", area=bem["area"] + points / 32**2, area_raw=raw)
    rows, _ = compare(old, new, tolerance=1e-9)
    assert [row.model for row in rows if not row.agrees] == differing
    assert allowance(old["main"]["line"], "area").absolute == 2.0 / 64


def test_what_is_not_there_is_no_agreement(old: Results) -> None:
    result = old["main"]["bem"]
    status = result["status"].copy()
    status[0, 0] = 2
    assert compare(old, changed(old, "bem", status=status))[1] == [
        "main/bem: 1 states converged before, and do not any more"
    ]
    other = compare(old, changed(old, "bem", pressure=2.0 * result["pressure"]))[1]
    assert other == ["main/bem: has other pressures than the old results"]
    fewer = {name: one[:1] for name, one in result.variables.items() if one.shape[:1] == (2,)}
    assert "(realizations, pressures)" in compare(old, changed(old, "bem", **fewer))[1][0]
    infinite = np.full_like(result["stiffness"], np.inf)
    rows, _ = compare(old, changed(old, "bem", stiffness=infinite))
    assert [row.deviation for row in rows if not row.agrees] == [np.inf]


def test_a_figure_needs_what_it_shows(old: Results) -> None:
    models = dict(old["main"])
    kept = {n: v for n, v in models["line"].variables.items() if not n.startswith("stiffness")}
    models["line"] = dataclasses.replace(models["line"], variables=kept)
    results = dataclasses.replace(old, experiments={"main": models})
    area = needs_of(results, [needed(results, "area")])
    assert (area.quantities, area.fields) == (frozenset({"area"}), False)
    assert area.models == {("main", label) for label in old["main"]}
    stiffness = needs_of(results, [needed(results, "stiffness")])
    assert stiffness.models == area.models - {("main", "line")}
    both = needs_of(results, [needed(results, "stiffness"), needed(results, "area")])
    assert (both.quantities, both.models) == (frozenset({"area", "stiffness"}), area.models)
    anything = needs_of(results, [lambda _: None])
    assert (anything.quantities, anything.fields) == (None, True)


def test_why_results_may_differ(old: Results) -> None:
    before = {"main/bem": {"numpy": "1", "code": "a"}, "main/line": {"numpy": "1", "code": "b"}}
    after = {"main/bem": {"numpy": "2", "code": "c"}, "main/line": {"numpy": "2", "code": "b"}}
    assert differences(before, after) == ["numpy: 1 → 2", "code: another (main/bem)"]
    assert differences({}, after) == []
    models = dict(old["main"])
    attributes = {**models["persson"].attributes, "gamma": 0.5}
    models["persson"] = dataclasses.replace(models["persson"], attributes=attributes)
    new = dataclasses.replace(old, experiments={"main": models})
    assert changed_options(old, new) == ["main/persson: gamma: 0.45 → 0.5"]
