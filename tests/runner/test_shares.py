"""Shares of a run, computed by processes that know nothing of each other."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import roughbench as rb
from roughbench.cli import main
from roughbench.errors import LockedError, RoughbenchError
from roughbench.planning.shares import Share, parse_share, realizations_of_share
from roughbench.rundir.folder import RunFolder
from roughbench.runner import clean, plan, run_share, status
from roughbench.spec import load_spec


def invoke(*words: object) -> tuple[int, str, str]:
    found = CliRunner().invoke(main, [str(word) for word in words])
    return found.exit_code, found.stdout, found.stderr


@pytest.fixture
def spec(small_spec: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a spec of two models in a file, in the current folder."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "small.yaml"
    path.write_text(load_spec(small_spec).text)
    return path


@pytest.mark.parametrize("count", [1, 3, 40])
def test_every_realization_is_in_one_share(small_spec: dict[str, Any], count: int) -> None:
    cells = plan(load_spec(small_spec | {"realizations": 20_000}))
    every = [Share(number, count) for number in range(1, count + 1)]
    shares = [realizations_of_share(cells, share) for share in every]
    for cell in cells:
        found = sorted(r for share in shares for r in share.get(cell, ()))
        assert found == list(range(cell.n_realizations))
    loads = [sum(cell.work * len(rows) for cell, rows in share.items()) for share in shares]
    assert max(loads) < 2.0 * sum(loads) / count
    assert shares == [
        realizations_of_share(cells, Share(k, count)) for k in range(1, count + 1)
    ]


@pytest.mark.parametrize(
    "text", ["0/4", "5/4", "1/0", "a/b", "1", "1/4/2", "", "-1/4", "1/100001"]
)
def test_what_is_no_share_is_refused(text: str) -> None:
    with pytest.raises(RoughbenchError, match="a share reads like 3/40"):
        parse_share(text)


def test_shares_and_a_run_make_the_results_of_one_run(spec: Path) -> None:
    rb.run(spec, output="whole.h5", threads=1)
    left = []
    for number in (2, 3, 1):
        code, out, err = invoke(
            "run", spec, "-o", "shared.h5", "--share", f"{number}/3", "-j", 1
        )
        assert code == 0, err
        left.append(out.splitlines()[-1])
    assert left[0].startswith("share 2/3: 1 task computed; ")
    assert left[0].endswith("of 63 states are left to others")
    assert left[2] == "share 1/3: 1 task computed; all is done"
    assert not Path("shared.h5").exists()
    found = status("shared.h5")
    assert (found.state, found.done, found.shares) == ("incomplete", 63, ())
    assert "--share" not in found.command
    again = invoke("run", spec, "-o", "shared.h5", "--share", "2/3", "--json")
    assert '"tasks": 0' in again[1]
    assert invoke("run", spec, "-o", "shared.h5", "-q", "--threads", 1)[0] == 0
    assert Path("shared.h5").read_bytes() == Path("whole.h5").read_bytes()


def test_more_shares_than_tasks_have_nothing_to_do(spec: Path) -> None:
    outcomes = [run_share(spec, "x.h5", Share(k, 40)) for k in (39, 40)]
    assert [(one.tasks, one.left) for one in outcomes] == [(0, 63), (0, 63)]


def test_shares_keep_out_a_run_and_their_like_alone(spec: Path) -> None:
    folder = RunFolder("x.h5")
    with folder.shared(Share(1, 3), "one"):
        assert folder.shares() == ["1/3"]
        with folder.shared(Share(2, 3), "other"):
            assert folder.shares() == ["1/3", "2/3"]
            run_share(spec, "x.h5", Share(3, 3))
        assert status("x.h5").state == "running"
        assert "1 share being computed: 1/3" in invoke("status", "x.h5")[1]
        with pytest.raises(LockedError, match=r"locked by process \d+ on"):
            run_share(spec, "x.h5", Share(1, 3))
        code, _, err = invoke("run", spec, "-o", "x.h5")
        assert code == 75
        assert "shares are being computed in x.h5.rbrun: 1/3; wait" in err
        with pytest.raises(LockedError, match="shares are being computed"):
            clean("x.h5")
    assert folder.shares() == []
    with folder.locked("a run"), pytest.raises(LockedError, match=r"\(a run\)"):
        run_share(spec, "x.h5", Share(1, 3))


def test_a_damaged_shard_is_left_to_the_run_that_assembles(spec: Path) -> None:
    run_share(spec, "x.h5", Share(1, 1))
    shard = next(Path("x.h5.rbrun/shards").rglob("*.npz"))
    shard.write_bytes(b"damaged")
    outcome = run_share(spec, "x.h5", Share(1, 1))
    assert (outcome.tasks, outcome.left) == (1, 0)
    assert shard.exists()
    assert "is damaged" in Path("x.h5.rbrun/shares/1-of-1.log").read_text()
    rb.run(spec, output="x.h5", threads=1)
    assert not shard.exists()
    (aside,) = Path("x.h5.rbrun/set-aside").iterdir()
    assert aside.read_bytes() == b"damaged"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--share", "4/3"], "a share reads like 3/40"),
        (["--share", "1/3", "--force"], "--share and --force do not go together"),
        (["--share", "1/3", "--only", "persson"], "--share and --only do not go together"),
        (["--share", "1/3", "-n"], "--share and --dry-run do not go together"),
        (["--share", "1/3", "--engine", "slurm"], "--share and --engine do not go together"),
    ],
)
def test_what_shares_do_not_do_is_said(spec: Path, words: list[str], message: str) -> None:
    code, _, err = invoke("run", spec, *words)
    assert (code, message in err) == (2, True)
    assert not Path("small.h5.rbrun").exists()


@pytest.mark.slow
def test_of_forty_shares_three_are_killed(spec: Path) -> None:
    """Forty processes, a few at a time; what the killed ones left is computed in the end."""
    text = spec.read_text().replace("realizations: 20", "realizations: 2000")
    spec.write_text(text.replace("springs: 128", "springs: 4096"))
    environment = os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])}

    def start(*words: str) -> subprocess.Popen[bytes]:
        line = [sys.executable, "-m", "roughbench", "run", str(spec), "-q", "-j", "1", *words]
        return subprocess.Popen(
            [*line, "--threads", "1"], env=environment, stdout=subprocess.DEVNULL
        )

    killed = {7: 0.0, 21: 0.5, 38: 1.0}
    codes: dict[int, int] = {}
    for first in range(1, 41, 4):
        running = {
            k: start("-o", "shared.h5", "--share", f"{k}/40") for k in range(first, first + 4)
        }
        for number, process in running.items():
            if number in killed:
                until = time.monotonic() + 60.0
                lock = Path(f"shared.h5.rbrun/shares/{number:02d}-of-40.lock")
                while not lock.exists() and time.monotonic() < until:
                    time.sleep(0.01)
                time.sleep(killed[number])
                process.send_signal(signal.SIGKILL)
        codes |= {number: process.wait() for number, process in running.items()}
    assert {k for k, code in codes.items() if code != 0} <= set(killed)
    assert codes[7] == -signal.SIGKILL
    before = status("shared.h5")
    assert before.done < before.states
    assert start("-o", "shared.h5").wait() == 0
    assert start("-o", "whole.h5").wait() == 0
    assert Path("shared.h5").read_bytes() == Path("whole.h5").read_bytes()
