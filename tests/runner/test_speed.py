"""How long models take here: measured once, kept, and used by estimates."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from roughbench.engines import compute
from roughbench.models.foundation import Foundation
from roughbench.models.persson import Persson
from roughbench.runner import preview, speed
from roughbench.runner.dry_run import estimate
from roughbench.runner.speed import Speeds

START, LOADING = 0.25, 0.125
REAL: Callable[[Any], tuple[float, float]] = speed._started


@pytest.fixture(autouse=True)
def _start(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spare a process for each model that is measured."""
    monkeypatch.setattr(speed, "_started", lambda _: (START, LOADING))


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("ROUGHBENCH_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def measured(*models: Any) -> list[str]:
    said: list[str] = []
    Speeds().measure(models, said.append)
    return said


def test_measured_once_and_kept(cache: Path) -> None:
    model = Foundation(springs=512)
    assert Speeds().slowness(model) == 1.0
    assert not cache.exists()  # to look changes nothing
    before, after = measured(model, Foundation(springs=1024, label="other"), Persson())
    assert before == (
        "measuring how fast this machine is, once for each model: foundation, persson"
    )
    assert after.endswith(f"s, kept in {cache / 'speed.json'}")
    kept = json.loads((cache / "speed.json").read_text())
    assert len([name for name in kept if "start" not in name and "loading" not in name]) == 2
    assert 0.0 < Speeds().slowness(model) != 1.0
    assert measured(model, Persson()) == []
    assert len(measured(Foundation(springs=512, ends="open"))) == 2  # another option


@pytest.mark.parametrize("content", ["", "[]", "{", '{"foundation": "fast"}', '{"a": -1.0}'])
def test_a_damaged_file_is_measured_again(cache: Path, content: str) -> None:
    cache.mkdir()
    (cache / "speed.json").write_text(content)
    assert Speeds().slowness(Persson()) == 1.0
    assert len(measured(Persson())) == 2
    assert measured(Persson()) == []


def test_without_a_cache_folder(cache: Path) -> None:
    cache.touch()
    assert measured(Persson())[1].endswith("not kept: the cache folder cannot be written")


def test_what_is_measured_is_the_computation(
    monkeypatch: pytest.MonkeyPatch, cache: Path
) -> None:
    """A machine on which each computation takes a second of a core: a control."""
    original: Callable[..., Any] = compute.compute
    clock = [0.0]
    monkeypatch.setattr(time, "process_time", lambda: clock[0])

    def slow(*arguments: Any) -> Any:
        clock[0] += 1.0
        return original(*arguments)

    monkeypatch.setattr(speed, "compute", slow)
    measured(Persson())
    assert not cache.is_file()
    assert Speeds().slowness(Persson()) == pytest.approx(100.0)  # by the formula: 10 ms


def test_what_a_process_takes_to_start_is_measured_in_one() -> None:
    start, loading = REAL(Persson())
    assert 0.05 < start < 60.0  # of an interpreter and the imports
    assert 1e-3 < loading < 60.0  # quadratures
    assert REAL(Foundation().model_copy(update={"label": lambda: None})) == (1e-3, 1e-3)


def test_starts_count_once_for_each_kind() -> None:
    models = [Persson(), Foundation(springs=512), Foundation(springs=1024), Persson()]
    assert Speeds().starting(models) == [0.0] * 4
    measured(*models)
    assert Speeds().starting(models) == [START + LOADING, LOADING, 0.0, 0.0]
    assert Speeds().starting([]) == []


def test_estimates_use_it(small_spec: dict[str, Any], cache: Path) -> None:
    """Small runs are mostly start: 12 s of a core were said to be 3."""
    said: list[str] = []
    by_formula = preview(small_spec)
    assert not cache.exists()
    here = preview(small_spec, measuring=said.append)
    assert len(said) == 2
    starts = [START + LOADING, LOADING]
    for before, after, start in zip(by_formula, here, starts, strict=True):
        kind = Foundation() if "foundation" in after.model else Persson()
        model = kind.model_copy(update={"springs": 128} if kind.kind == "foundation" else {})
        computing = before.seconds * Speeds().slowness(model)
        assert after.seconds == pytest.approx(computing + start)
    again = estimate(small_spec)
    assert again.core_seconds == pytest.approx(sum(part.seconds for part in here))
