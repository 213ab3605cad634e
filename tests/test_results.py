"""Results at a prompt and in a notebook: short texts, small tables, errors that help."""

from __future__ import annotations

import re
from typing import Any

import pytest

import roughbench as rb
from roughbench.results import MOST_LINES, ModelResult, Results


@pytest.fixture
def results(small_spec: dict[str, Any]) -> Results:
    return rb.run(small_spec | {"sweep": {"surface.qr": [1.0, 4.0]}})


def test_results_are_a_few_lines(results: Results) -> None:
    assert repr(results).splitlines() == [
        "Results 'small': 2 experiments, label (realizations)",
        "  surface.qr=1.0: foundation (20), persson (1)",
        "  surface.qr=4.0: foundation (20), persson (1)",
    ]
    assert str(results) == repr(results)


def test_many_experiments_and_models_stay_a_few_lines(results: Results) -> None:
    models = {f"label-{k}": results["surface.qr=1.0"]["persson"] for k in range(40)}
    many = Results({f"surface.qr={k}.0": models for k in range(100)}, "", "", "many")
    lines = repr(many).splitlines()
    assert len(lines) == MOST_LINES + 2
    assert max(map(len, lines)) < 100
    assert lines[-1] == f"  … {100 - MOST_LINES} more"
    assert many._repr_html_().count("<tr>") == 1 + 2 * MOST_LINES
    assert f"{4000 - 2 * MOST_LINES} more models" in many._repr_html_()


def test_a_model_says_what_it_holds(results: Results) -> None:
    lines = repr(results["surface.qr=4.0"]["foundation"]).splitlines()
    assert lines[0] == (
        "ModelResult 'foundation': Popov (1D foundation), 20 realizations, "
        "3 pressures, p/E* = 0.0001 … 0.01"
    )
    assert lines[1].startswith("  variables: pressure, area, separation, ")
    assert "area_mean" not in " ".join(lines)
    assert len(lines) <= 4
    assert max(map(len, lines[1:])) <= 90


def test_notebooks_get_small_tables(results: Results) -> None:
    table = results._repr_html_()
    assert table.count("<tr>") == 5
    assert "<td>surface.qr=4.0</td><td>foundation</td><td>Popov (1D foundation)</td>" in table
    assert "60 of 60" in table
    model = results["surface.qr=4.0"]["foundation"]
    shown = model._repr_html_()
    mean, error = float(model["area_mean"][0]), float(model["area_sem"][0])
    assert f"<td>0.0001</td><td>{mean:.4g} ± {error:.2g}</td>" in shown
    assert shown.count("<tr>") == 4
    assert "contact stiffness K/E*, 1/length" in shown


def test_names_are_escaped_in_tables(results: Results) -> None:
    one = results["surface.qr=1.0"]["persson"]
    hostile = ModelResult("<b>", one.kind, "<i>", one.attributes, one.variables)
    text = Results({"<script>": {"<b>": hostile}}, "", "", "<u>")._repr_html_()
    assert not re.search(r"<(script|b|i|u)>", text)
    assert "<i>" not in hostile._repr_html_()


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (["surface.qr=4"], "named 'surface.qr=4' (did you mean 'surface.qr=4.0'?)"),
        (
            ["surface.qr=1.0", "foundatoin"],
            "no model is named 'foundatoin' (did you mean 'foun",
        ),
        (["surface.qr=1.0", "persson", "Area_mean"], "(did you mean 'area_mean'?)"),
        (["nothing like it"], "known here: surface.qr=1.0, surface.qr=4.0"),
        (["surface.qr=1.0", "persson", "xyz"], "known here: pressure, area, separation, "),
    ],
)
def test_a_wrong_name_is_a_key_error_that_helps(
    results: Results, path: list[str], message: str
) -> None:
    found: Any = results
    for name in path[:-1]:
        found = found[name]
    with pytest.raises(KeyError) as caught:
        found[path[-1]]
    assert message in str(caught.value)
    assert "\\" not in str(caught.value)  # a plain KeyError would quote and escape it
    assert isinstance(caught.value, rb.RoughbenchError)


def test_asking_whether_a_name_is_there_raises_nothing(results: Results) -> None:
    assert "main" not in results
    assert results.get("main") is None
    assert "bem" not in results["surface.qr=1.0"]
    assert results["surface.qr=1.0"].get("bem") is None
    assert "nothing" not in results["surface.qr=1.0"]["persson"]
