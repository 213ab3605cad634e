"""A short campaign of faults; the long one is ``scripts/fault_campaign.py``."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import roughbench as rb

ROOT = Path(rb.__file__).parents[1]


@pytest.mark.slow
def test_a_short_campaign() -> None:
    pytest.importorskip("distributed")
    numbers = {"groups": 3, "workers": 3, "terms": 1, "full": 2, "disks": 2}
    numbers |= {"dask-groups": 1, "dask-workers": 1}
    options = [f"--{kind}={n}" for kind, n in numbers.items()]
    done = subprocess.run(
        [sys.executable, "scripts/fault_campaign.py", *options, "--realizations=30"],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "all ended with the bytes of" in done.stdout
    assert "| group | 3 | 3 × -9" in done.stdout  # a run may also end before its kill
