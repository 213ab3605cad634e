"""Warnings appear when they should, and only then."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.figures.rebuild import spec_fault
from roughbench.numbers import number
from roughbench.report.sources import ReportSource
from roughbench.report.warnings import ABOUT, Remark, at_pressures, remarks
from roughbench.results import Results
from tests.report.conftest import Change, Page, page_of

PRESSURE = np.geomspace(1e-3, 0.1, 6)


@pytest.fixture(scope="module")
def sound(small: Results, change: Change) -> Results:
    """Return the results of the small run with errors and a grid that nobody minds."""
    for label in ("bem", "foundation"):
        for quantity in ("area", "separation", "stiffness"):
            mean = small["surface.qr=1.0"][label][f"{quantity}_mean"]
            finite = np.where(np.isfinite(mean), mean, 1.0)
            small = change(
                small, label, **{f"{quantity}_mean": finite, f"{quantity}_sem": 0.01 * finite}
            )
    area = np.full(PRESSURE.shape, 0.2)
    return change(small, "bem", area_raw_mean=area, area_mean=area)


def warned(results: Results) -> list[Remark]:
    found = remarks([ReportSource("r.h5", results)])
    assert {remark.topic for remark in found} <= set(ABOUT)
    return [remark for remark in found if remark.severity == "warning"]


def test_sound_results_give_no_warning_but_say_what_has_no_error(sound: Results) -> None:
    found = remarks([ReportSource("r.h5", sound)])
    assert [(r.severity, r.topic, r.text) for r in found] == [
        ("note", "Models without randomness", "persson.")
    ]


def one(results: Results, topic: str, label: str) -> str:
    """Return the text of a warning that both experiments give, and that is the only one."""
    found = warned(results)
    places = [remark.where for remark in found]
    assert places == [f"r.h5: surface.qr={qr}/{label}" for qr in ("1.0", "4.0")]
    assert {remark.topic for remark in found} == {topic}
    assert len({remark.text for remark in found}) == 1
    return found[0].text


def test_states_that_did_not_converge(sound: Results, change: Change) -> None:
    status = np.zeros((5, 6), np.int32)
    status[1:3, 0] = 1
    status[:, 3] = 2
    text = one(change(sound, status=status), "States that did not converge", "bem")
    assert text.startswith(
        "7 of 30 states did not converge (2 stagnated, 5 ran out of iterations), "
        "at p/E* = 0.001 and 0.0158"
    )
    assert text.endswith("; nothing is left at p/E* = 0.0158.")


@pytest.mark.parametrize(("points", "there"), [(64, None), (63, "3.94"), (32, "2")])
def test_points_on_the_shortest_wave(
    sound: Results, change: Change, points: int, there: str | None
) -> None:
    changed = change(sound, attributes={"grid_points": points})
    if there is None:
        assert warned(changed) == []
    else:
        text = one(changed, "Coarse grids", "bem")
        assert text == f"{there} points on the shortest wave 2π/q₁, fewer than 4."


def test_springs_need_two_on_the_shortest_wave(sound: Results, change: Change) -> None:
    assert warned(change(sound, "foundation", {"grid_points": 32})) == []
    changed = change(sound, "foundation", {"grid_points": 31})
    assert "fewer than 2" in one(changed, "Coarse grids", "foundation")


def test_contacts_of_few_points(sound: Results, change: Change) -> None:
    area = np.full(6, 0.2)
    area[1] = 99.0 / 64**2
    text = one(
        change(sound, area_mean=area, area_raw_mean=area), "Contacts of few points", "bem"
    )
    assert text == (
        "fewer than 100 points of the grid touch at p/E* = 0.00251 (on average, down to 99)."
    )


def test_contacts_of_few_points_of_a_line(sound: Results, change: Change) -> None:
    """64 points on a line are 64, and not 64² as on a surface."""
    area = np.full(6, 0.2)
    changed = change(sound, "foundation", {"grid_points": 64}, area_mean=area)
    text = one(change(changed, "foundation", area_raw_mean=area), *FEW_POINTS)
    assert "at all 6 pressures (on average, down to 13)" in text
    many = change(changed, "foundation", {"grid_points": 500}, area_raw_mean=area)
    assert warned(many) == []


FEW_POINTS = ("Contacts of few points", "foundation")


@pytest.mark.parametrize(("raw", "warns"), [(1.19, False), (1.21, True), (0.79, True)])
def test_areas_with_and_without_correction_that_differ(
    sound: Results, change: Change, raw: float, *, warns: bool
) -> None:
    areas = np.full(6, 0.2 * raw)
    changed = change(sound, area_raw_mean=areas)
    if not warns:
        assert warned(changed) == []
    else:
        text = one(changed, "Contacts of few points", "bem")
        assert "differ by up to 21 % at all 6 pressures" in text


def test_few_realizations(sound: Results, change: Change) -> None:
    changed = change(sound, status=np.zeros((4, 6), np.int32))
    assert one(changed, "Few realizations", "bem") == "4 realizations."
    changed = change(sound, status=np.zeros((1, 6), np.int32))
    assert one(changed, "Few realizations", "bem") == "1 realization."


def test_large_standard_errors(sound: Results, change: Change) -> None:
    mean = sound["surface.qr=1.0"]["foundation"]["stiffness_mean"]
    error = mean * np.array([0.09, 0.11, 0.25, 0.0, np.nan, 0.0])
    text = one(
        change(sound, "foundation", stiffness_sem=error), "Large standard errors", "foundation"
    )
    assert text == "K at p/E* = 0.00251 and 0.00631 (up to 25 %)."


def test_full_contact_is_a_note(sound: Results, change: Change) -> None:
    mean = np.array(sound["surface.qr=1.0"]["bem"]["stiffness_mean"])
    mean[-1] = np.inf
    found = remarks([ReportSource("r.h5", change(sound, stiffness_mean=mean))])
    notes = [remark for remark in found if remark.topic == "Full contact"]
    assert [remark.severity for remark in notes] == ["note"] * 2
    assert notes[0].text == "at p/E* = 0.1."


def test_what_the_spec_has_and_the_file_has_not(sound: Results) -> None:
    models = dict(sound["surface.qr=1.0"])
    del models["persson"]
    results = Results({"surface.qr=1.0": models}, sound.spec_text, "", "")
    found = warned(results)
    assert {remark.topic for remark in found} == {"Missing parts"}
    assert [remark.where.partition(": ")[2] for remark in found] == [
        "surface.qr=1.0/persson",
        *(f"surface.qr=4.0/{label}" for label in ("bem", "foundation", "persson")),
    ]


def test_pressures_that_are_missing(sound: Results) -> None:
    spec = sound.spec_text.replace("points: 6", "points: 11")
    assert spec != sound.spec_text
    results = Results(sound.experiments, spec, "", "")
    found = warned(results)
    assert len(found) == 6
    assert {remark.topic for remark in found} == {"Missing pressures"}
    assert found[0].text.startswith("the spec asks for states at 5 pressures between")


def test_models_at_different_pressures(sound: Results, change: Change) -> None:
    changed = change(sound, "persson", pressure=1.5 * PRESSURE)
    found = warned(changed)
    assert {remark.topic for remark in found} == {"Missing pressures"}
    assert [r.where for r in found if "different pressures" in r.text] == [
        "r.h5: surface.qr=1.0",
        "r.h5: surface.qr=4.0",
    ]


def test_a_spec_that_cannot_be_read(sound: Results) -> None:
    results = Results(sound.experiments, "surface: {", "", "")
    assert [remark.text for remark in warned(results)] == [
        "the spec in the file cannot be read, so nothing tells what is missing."
    ]


def test_results_of_heights_are_read_where_the_heights_are_not(tmp_path: Path) -> None:
    np.save(tmp_path / "heights.npy", 0.02 * np.sin(np.arange(64.0)))
    (tmp_path / "spec.yaml").write_text(
        "surface: {kind: file, path: heights.npy, length: 3.0}\n"
        "pressures: [0.1, 0.5]\n"
        "models: [{kind: foundation}, {kind: persson}]\n"
    )
    rb.run(tmp_path / "spec.yaml", output=tmp_path / "r.h5")
    (tmp_path / "heights.npy").unlink()
    results = rb.load(tmp_path / "r.h5")
    assert "cannot be read" not in str([remark.text for remark in warned(results)])
    assert spec_fault(results) is None
    with pytest.raises(rb.SpecError, match="no such file"):
        rb.load_spec(results.spec_text, folder=tmp_path)
    with pytest.raises(rb.SpecError, match=r"spec\.yaml:1:29: error: surface\.path: no such"):
        rb.run(tmp_path / "spec.yaml")


def test_what_the_checks_found_of_given_heights_is_said_once(tmp_path: Path) -> None:
    np.save(tmp_path / "heights.npy", 0.2 * np.sin(np.arange(64.0) * np.pi / 2 + 0.3))
    (tmp_path / "spec.yaml").write_text(
        "surface: {kind: file, path: heights.npy, length: 16.0}\n"
        "pressures: [0.1, 0.5]\n"
        "models: [{kind: foundation}, {kind: persson}]\n"
    )
    found = warned(rb.run(tmp_path / "spec.yaml"))
    texts = [remark.text for remark in found if remark.topic == "Measured heights"]
    assert len(texts) == len(set(texts)) > 0
    assert any("slope" in text for text in texts)
    accepted = rb.run(tmp_path / "spec.yaml", overrides=["surface.accept=[slope, resolution]"])
    kept = [remark.text for remark in warned(accepted) if remark.topic == "Measured heights"]
    assert set(kept) < set(texts)


def test_warnings_are_on_the_page_or_none_is(sound: Results, change: Change) -> None:
    coarse = Page(page_of(change(sound, attributes={"grid_points": 63}))).text
    assert "▲ Coarse grids" in coarse
    assert ABOUT["Coarse grids"] in coarse
    assert "r.h5" not in coarse
    assert "small.h5, qr/q0\xa0=\xa01, Exact (BEM)" in coarse
    assert "▲" not in Page(page_of(sound)).text


@pytest.mark.parametrize(
    ("chosen", "words"),
    [
        ([1, 0, 0, 0, 0, 0], "at p/E* = 0.001"),
        ([1, 0, 1, 0, 0, 1], "at p/E* = 0.001, 0.00631 and 0.1"),
        ([0, 1, 1, 1, 1, 0], "at the 4 pressures p/E* = 0.00251 to 0.0398"),
        ([1, 1, 0, 1, 1, 0], "at 4 pressures between p/E* = 0.001 and 0.0398"),
        ([1, 1, 1, 1, 1, 1], "at all 6 pressures"),
    ],
)
def test_pressures_in_words(chosen: Any, words: str) -> None:
    assert at_pressures(PRESSURE, np.array(chosen, bool)) == words


def test_the_words_are_numbers_of_the_page() -> None:
    assert number(PRESSURE[1]) in at_pressures(PRESSURE, PRESSURE < 0.003)
