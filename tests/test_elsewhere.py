"""Where there is no fcntl, no resource, no pyFFTW, few signals and no /proc: all the same."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughbench as rb

SPEC = """\
name: there
surface: {H: 0.7, q0: 1.0, q1: 8.0, slope: 0.1}
pressures: [0.01, 0.05]
realizations: 3
models: [{kind: bem, grid: 32}, {kind: foundation, springs: 64, realizations: 20}]
"""
PROGRAM = """\
import sys
from roughbench.cli import main

def call(*words):
    try:
        main(words)
    except SystemExit as ended:
        print("ended with", ended.code, flush=True)

if __name__ == "__main__":
    call("run", "spec.yaml", "--quiet", "-j", "1", "--threads", "1", "--set", "realizations=1")
    call("run", "spec.yaml", "--quiet", "-j", sys.argv[1], "--threads", "1")
    call("status", "there.h5")
    call("plot", "there.h5", "--figure", "area", "-o", "plots")
    call("verify", "there.h5")
    call("clean", "there.h5")
    assert "numba" in sys.modules and not sys.modules.get("fcntl")
"""


@pytest.mark.parametrize("jobs", ["1", pytest.param("2", marks=pytest.mark.slow)])
def test_a_run_on_a_system_that_lacks_what_linux_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jobs: str
) -> None:
    """Computed, resumed, also by worker processes, drawn, verified; to the bit as here."""
    here = Path(__file__).parent
    (tmp_path / "spec.yaml").write_text(SPEC, encoding="utf-8")
    (tmp_path / "program.py").write_text(PROGRAM, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "program.py", jobs],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": f"{here / 'elsewhere'}{os.pathsep}{here.parent}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.count("ended with 0") == 6, done.stdout + done.stderr
    assert "no locks" in done.stderr  # which neither fcntl nor Windows gives: it is said
    assert (tmp_path / "plots" / "area.png").stat().st_size > 1000
    assert not (tmp_path / "there.h5.rbrun").exists()

    there = rb.load(tmp_path / "there.h5")["main"]
    monkeypatch.setenv("ROUGHBENCH_FFT", "scipy")
    ours = rb.run(SPEC, threads=1, jobs=1)["main"]
    assert list(there) == list(ours)
    assert there["bem"].made_with["fft"] == "scipy"
    assert there["bem"].made_with["threads"] == 1
    assert "fft" not in there["foundation"].made_with  # which transforms nothing
    for label, model in ours.items():
        for name in model:
            np.testing.assert_array_equal(there[label][name], model[name])
