"""What there is of a run that is not finished: shown, drawn and watched, and called partial."""

from __future__ import annotations

import json
import shutil
import threading
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from roughbench.cli import status as status_command
from roughbench.errors import RoughbenchError
from roughbench.figures.partial import mark_partial
from roughbench.runner import partial_results, run_to_file
from roughbench.store import load
from tests.cli.conftest import SPEC, Invoke


@pytest.fixture
def unfinished(results: Path, invoke: Invoke) -> Path:
    """Return the results file to come of a run that has 20 of 50 realizations."""
    shutil.copy(results, results.with_name("twenty.h5"))
    results.unlink()
    (results.parent / "small.yaml").write_text(
        SPEC.replace("realizations: 20", "realizations: 50")
    )
    done = invoke("run", "small.yaml", "--only", "persson", "-q", "--threads", 1)
    assert done.exit_code == 3
    return results


def test_what_is_finished_has_the_numbers_of_its_realizations(unfinished: Path) -> None:
    found = partial_results(unfinished)
    assert found.partial == {"main/foundation": (20, 50)}
    whole = load(unfinished.with_name("twenty.h5"))
    for _, result in whole.models():
        for name in result:
            np.testing.assert_array_equal(found["main"][result.label][name], result[name])


def test_tables_and_json_say_that_they_are_partial(unfinished: Path, invoke: Invoke) -> None:
    shown = invoke("show", unfinished, "--partial").stdout
    assert (
        "PARTIAL, the run is not finished: main/foundation has 20 of 50 realizations" in shown
    )
    found = json.loads(invoke("show", unfinished, "--partial", "--json").stdout)
    assert found["partial"] == {"main/foundation": {"realizations": 20, "planned": 50}}
    refused = invoke("show", unfinished)
    assert refused.exit_code == 1
    assert "its run is not finished" in refused.stderr
    assert "--partial" in refused.stderr
    whole = unfinished.with_name("twenty.h5")
    assert "partial" not in json.loads(invoke("show", whole, "--json").stdout)


def test_figures_say_that_they_are_partial(
    unfinished: Path, invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts: list[str] = []

    def noting(figure: Figure, partial: dict[str, tuple[int, int]]) -> None:
        mark_partial(figure, partial)
        texts.append(figure.get_supxlabel())
        texts.extend(one.get_text() for one in figure.texts)

    monkeypatch.setattr("roughbench.figures.mark_partial", noting)
    done = invoke("plot", unfinished, "--partial", "--figure", "area", "--format", "png")
    assert done.exit_code == 0, done.stderr
    assert "PARTIAL" in texts
    assert "main/foundation 20 of 50" in texts[0].replace("\n", " ")
    assert invoke("plot", unfinished, "--figure", "area").exit_code == 1


def test_a_figure_of_a_whole_run_is_left_as_it_is() -> None:
    figure = Figure()
    mark_partial(figure, {})
    assert (figure.get_supxlabel(), figure.texts) == ("", [])
    figure.supxlabel("a remark")
    before = figure.get_figheight()
    mark_partial(figure, {f"main/{n}": (1, 9) for n in range(8)})
    assert figure.get_supxlabel().startswith("a remark\nPARTIAL, a run")
    assert "2 more" in figure.get_supxlabel()
    assert figure.get_figheight() > before


def test_nothing_finished_is_nothing_to_show(folder: Path, invoke: Invoke) -> None:
    (folder / "small.yaml").write_text(SPEC.replace("  - kind: persson\n", ""))
    assert invoke("run", "small.yaml", "--share", "2/2", "-q").exit_code == 0
    with pytest.raises(RoughbenchError, match="no realization of any model is finished yet"):
        partial_results("small.h5")


def test_a_run_is_watched_until_its_end(
    unfinished: Path, invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(status_command, "SECONDS_BETWEEN", 0.01)
    other = threading.Timer(0.2, lambda: run_to_file("small.yaml", unfinished, threads=1))
    other.start()
    done = invoke("status", unfinished, "--watch")
    other.join()
    assert done.exit_code == 0
    lines = [line.partition(" ")[2] for line in done.stdout.splitlines()]
    assert lines[0] == f"{unfinished}: incomplete, 63 of 153 states are done"
    assert lines[-1] == f"{unfinished}: complete, 153 of 153 states are done"
    assert invoke("status", unfinished, "--watch", "--json").exit_code == 2
