"""``run`` on top of earlier runs, ``status``, ``verify`` and ``clean``."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

import roughbench as rb
from roughbench.rundir.folder import RunFolder

Invoke = Callable[..., Result]


def shard_of(results: Path) -> Path:
    return next(results.with_name("small.h5.rbrun").glob("shards/*/000000-000019.*"))


def test_dry_run_says_what_and_why_and_writes_nothing(folder: Path, invoke: Invoke) -> None:
    done = invoke("run", "small.yaml", "-n")
    assert done.exit_code == 0
    first, second, total = done.stdout.splitlines()
    assert first.startswith("main/foundation, realizations 1 to 20: new (60 states in 1 task,")
    assert second.startswith("main/persson: new (3 states in 1 task")
    assert total.startswith("2 tasks to compute, about ")
    assert [entry.name for entry in folder.iterdir()] == ["small.yaml"]


def test_dry_run_on_top_of_a_run(results: Path, invoke: Invoke) -> None:
    assert invoke("run", results.with_name("small.yaml"), "-n").stdout.splitlines() == [
        "main/foundation, realizations 1 to 20: done",
        "main/persson: done",
        "nothing to compute",
    ]
    changed = invoke("run", "small.yaml", "-n", "--set", "seed=8").stdout
    assert "main/foundation, realizations 1 to 20: changed: seed: 7 → 8 (60 states" in changed
    forced = invoke("run", "small.yaml", "-n", "--force").stdout
    assert "main/persson: forced (3 states" in forced


@pytest.mark.usefixtures("folder")
def test_only_leaves_the_rest_and_exits_3(invoke: Invoke) -> None:
    done = invoke("run", "small.yaml", "--only", "main/persson")
    assert done.exit_code == 3
    message = "error: the results file is not written yet: not all is computed\n"
    assert message in done.stderr
    assert "3 of 63 states are kept in small.h5.rbrun; resume: roughbench run" in done.stderr
    assert invoke("status", "small.h5").stdout.splitlines()[-2:] == [
        "small.h5: incomplete, 3 of 63 states are done",
        "resume: roughbench run small.yaml --only main/persson",
    ]
    assert invoke("run", "small.yaml", "--only", "main/bem").exit_code == 1
    assert ", 3 of 63 states were there already; rea" in invoke("run", "small.yaml").stderr


@pytest.mark.usefixtures("folder")
def test_status_of_a_spec_that_nobody_has_run(invoke: Invoke) -> None:
    done = invoke("status", "small.yaml")
    assert done.exit_code == 1
    assert done.stderr == (
        "error: nothing of small.yaml has been computed here: there is no small.h5.rbrun; give "
        "the results file of its run (-o), or start one with: roughbench run small.yaml\n"
    )


def test_a_run_that_finds_all_says_that_nothing_was_computed(
    results: Path, invoke: Invoke
) -> None:
    done = invoke("run", results.with_name("small.yaml"))
    assert ", nothing was computed, as all states are there (--force" in done.stderr
    forced = invoke("run", "small.yaml", "--force")
    assert " were there" not in forced.stderr
    assert "nothing was computed" not in forced.stderr


def test_status_of_a_complete_run(results: Path, invoke: Invoke) -> None:
    for path in (results, f"{results}.rbrun", "small.yaml"):
        done = invoke("status", path)
        assert done.exit_code == 0
        assert done.stdout.splitlines()[-1].endswith(
            "small.h5: complete, 63 of 63 states are done"
        )
    state = json.loads(invoke("status", results, "--json").stdout)
    assert (state["state"], state["done"], state["states"]) == ("complete", 63, 63)
    assert state["running"] is None
    assert [part["reason"] for part in state["parts"]] == ["done", "done"]


def test_a_running_run_is_known_and_left_alone(results: Path, invoke: Invoke) -> None:
    with RunFolder(results).locked("roughbench run small.yaml"):
        assert "running, 63 of 63" in invoke("status", results).stdout
        state = json.loads(invoke("status", results, "--json").stdout)
        assert state["running"]["process"] == os.getpid()
        for command in (("run", "small.yaml"), ("clean", results)):
            refused = invoke(*command)
            assert refused.exit_code == 75
            assert f"is locked by process {os.getpid()} on " in refused.stderr
            assert "(roughbench run small.yaml); wait for it" in refused.stderr
        assert invoke("verify", results).exit_code == 0
        assert invoke("run", "small.yaml", "-n").exit_code == 0
    assert invoke("run", "small.yaml").exit_code == 0


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("command", ["status", "verify", "clean"])
def test_where_there_is_no_run(invoke: Invoke, command: str) -> None:
    done = invoke(command, "small.h5")
    assert done.exit_code == 1
    assert done.stderr == (
        "error: small.h5.rbrun: no such run directory; give the results file of a run (-o), or "
        "start one with: roughbench run SPEC.yaml\n"
    )


def test_verify_reads_everything(results: Path, invoke: Invoke) -> None:
    results = Path(results.name)
    done = invoke("verify", results)
    assert (done.exit_code, done.stdout) == (0, "3 files are sound, 0 damaged\n")
    shard = shard_of(results)
    data = shard.read_bytes()
    shard.write_bytes(data[:200] + b"x" + data[201:])
    results.write_bytes(results.read_bytes().replace(b"seed: 7", b"seed: 8"))
    done = invoke("verify", results)
    assert (done.exit_code, done.stdout) == (1, "1 files are sound, 2 damaged\n")
    assert f"damaged: {shard}: is damaged: its content does not match" in done.stderr
    assert f"damaged: {results}: damaged (its content does not match its check" in done.stderr
    again = invoke("run", "small.yaml")
    assert again.exit_code == 0
    assert f"warning: {shard}: is damaged" in again.stderr
    assert invoke("verify", results).exit_code == 0


def test_clean_removes_the_run_directory(results: Path, invoke: Invoke) -> None:
    done = invoke("clean", results)
    assert (done.exit_code, done.stdout) == (0, "freed 0.0 MB\n")
    assert sorted(path.name for path in results.parent.iterdir()) == ["small.h5", "small.yaml"]
    assert rb.load(results)


def test_clean_unused_keeps_what_the_last_run_needs(results: Path, invoke: Invoke) -> None:
    old = shard_of(results)
    assert invoke("run", "small.yaml", "--set", "seed=8").exit_code == 0
    assert old.exists()
    assert invoke("clean", results, "--unused").exit_code == 0
    assert not old.exists()
    assert shard_of(results).exists()
    assert "nothing to compute" in invoke("run", "small.yaml", "-n", "--set", "seed=8").stdout


def test_a_lost_request_is_said(results: Path, invoke: Invoke) -> None:
    (results.with_name("small.h5.rbrun") / "run.json").write_text("{")
    for command in (("status", results), ("clean", results, "--unused")):
        done = invoke(*command)
        assert done.exit_code == 1
        assert "run.json is missing or damaged" in done.stderr
    assert invoke("run", "small.yaml").exit_code == 0
    assert invoke("status", results).exit_code == 0


def test_provenance_stands_apart(results: Path) -> None:
    import hashlib

    message = json.loads((results.with_name("small.h5.rbrun") / "provenance.json").read_text())
    assert message["results_sha256"] == hashlib.sha256(results.read_bytes()).hexdigest()
    assert message["spec_sha256"] == rb.load(results).spec_sha256
    foundation = message["models"]["main/foundation"]
    assert (foundation["seed"], foundation["states"], foundation["unconverged"]) == (7, 60, 0)
    assert foundation["peak_memory"] > 10**7
    assert {"host", "cpu", "numpy", "pyfftw", "system"} <= set(foundation["machines"][0])


@pytest.mark.parametrize("size", ["0", "x", "-1G", ""])
@pytest.mark.usefixtures("folder")
def test_memory_that_is_none(invoke: Invoke, size: str) -> None:
    done = invoke("run", "small.yaml", "--max-memory", size)
    assert done.exit_code == 1
    assert done.stderr == f"error: memory must read like 12G or 800M, got '{size}'\n"


@pytest.mark.usefixtures("folder")
def test_too_little_memory_is_said_at_once(invoke: Invoke) -> None:
    done = invoke("run", "small.yaml", "--max-memory", "100M")
    assert done.exit_code == 1
    assert "needs about 0.3 GB, and all tasks together may take 0.1 GB" in done.stderr
    assert "allow more with --max-memory" in done.stderr


def test_no_file_of_a_run_rewrites_the_terminal(results: Path, invoke: Invoke) -> None:
    """Its files, and their names, may be another one's."""
    results = Path(results.name)
    run = results.with_name("small.h5.rbrun")
    evil = "\x1b[2J\u202e\nerror: you lost"
    request = RunFolder(results).request()
    RunFolder(results).write_request(request | {"command": evil})
    shard = shard_of(results)
    shard.rename(shard.with_name(f"{evil.replace('/', '')}.npz"))
    message = []
    for command in (
        ("status", results),
        ("verify", results),
        ("run", "small.yaml", "-n"),
        ("run", "small.yaml", "-v"),
    ):
        done = invoke(*command)
        message.append(done.stdout + done.stderr)
    for text in message:
        assert not {"\x1b", "\u202e"} & set(text)
    for text in message[:3]:
        assert not any(line.startswith("error: you lost") for line in text.splitlines())
    assert "resume: \\x1b[2J\\u202e\\nerror: you lost" in message[0]
    assert "is no shard of roughbench" in message[1]
    (run / "lock").write_text("")
    with RunFolder(results).locked(evil):
        refused = invoke("run", "small.yaml")
    assert refused.exit_code == 75
    assert not {"\x1b", "\u202e"} & set(refused.stderr)
