"""Specs to spoil, and the faults that come of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from roughbench.errors import SpecError
from roughbench.spec import load_spec

VALID = """\
name: rolloff8
surface:
  H: 0.7
  q0: 1.0
  qr: 8.0
  q1: 128.0
  slope: 0.1
pressures: {min: 1.0e-5, max: 0.2, points: 20, spacing: log}
realizations: 10
seed: 2013
models:
  - kind: bem
    grid: 512
    tolerance: 1.0e-6
  - kind: foundation
    springs: 8192
    realizations: 100
  - kind: persson
    gamma: 0.45
    finite_size: none
"""


@pytest.fixture
def valid() -> str:
    """A spec without faults, of the shape that the contract shows."""
    return VALID


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
