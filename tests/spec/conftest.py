"""Specs to spoil, and the faults that come of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from roughbench.errors import SpecError
from roughbench.spec import load_spec


@pytest.fixture
def valid() -> str:
    """Return a spec without faults."""
    return (Path(__file__).parent / "valid.yaml").read_text(encoding="utf-8")


FaultsOf = Callable[..., list[str]]


@pytest.fixture
def faults_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FaultsOf:
    """Write a text to ``bad.yaml``, load it, and return its faults as the user sees them."""
    monkeypatch.chdir(tmp_path)

    def faults_of(text: str, *overrides: str) -> list[str]:
        (tmp_path / "bad.yaml").write_text(text, encoding="utf-8")
        with pytest.raises(SpecError) as caught:
            load_spec("bad.yaml", overrides)
        return [str(fault) for fault in caught.value.faults]

    return faults_of
