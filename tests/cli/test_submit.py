"""A run as jobs of Slurm: their scripts, profiles, and what is said where they cannot be."""

from __future__ import annotations

import json
import os
import stat
import subprocess
from pathlib import Path

import pytest

from roughbench.engines.profiles import JobProfile, config_file, load_profile
from roughbench.engines.sbatch import ShareJobs
from roughbench.errors import RoughbenchError
from tests.cli.conftest import SPEC, Invoke

PROFILE = """\
[profile.short]
partition = "short"
account = "tribology"
walltime = "04:00:00"
cpus = 2
options = ["--qos=low", "--comment=two words"]
setup = "echo prepared"
"""
SBATCH = """\
#!/bin/bash
echo "$@" >> sbatch.log
[ -e refuse ] && grep -q assemble <<< "$@" && { echo "Invalid account" >&2; exit 1; }
echo "$(( 100 + $(wc -l < sbatch.log) ));cluster"
"""


@pytest.fixture
def config(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = folder / "config.toml"
    path.write_text(PROFILE)
    monkeypatch.setenv("ROUGHBENCH_CONFIG", str(path))
    return path


@pytest.fixture
def sbatch(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Have a command sbatch that notes what it is told, and gives numbers from 101 on."""
    path = folder / "bin" / "sbatch"
    path.parent.mkdir()
    path.write_text(SBATCH)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{path.parent}{os.pathsep}{os.environ['PATH']}")
    return folder / "sbatch.log"


@pytest.mark.usefixtures("config")
def test_an_array_is_submitted_with_a_job_behind_it(
    folder: Path, sbatch: Path, invoke: Invoke
) -> None:
    done = invoke("submit", "small.yaml", "--array", 40, "--profile", "short", "--cpus", 4)
    assert (done.exit_code, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [
        "101: 40 shares of small.h5",
        "102: writes small.h5 when they have ended",
    ]
    jobs = folder / "small.h5.rbrun" / "jobs"
    assert sbatch.read_text().splitlines() == [
        f"--parsable {jobs / 'array.sh'}",
        f"--parsable --dependency=afterany:101 {jobs / 'assemble.sh'}",
    ]
    array = (jobs / "array.sh").read_text()
    for line in (
        *("--job-name=small", "--array=1-40", "--time=04:00:00", "--cpus-per-task=4"),
        *("--partition=short", "--account=tribology", "--qos=low", '--comment="two words"'),
    ):
        assert f"#SBATCH {line}\n" in array
    assert "\necho prepared\n" in array
    assert "--array" not in (jobs / "assemble.sh").read_text()
    assert (jobs / "spec.yaml").read_text() == SPEC
    assert invoke("status", "small.h5").exit_code == 1, "nothing was computed yet"


@pytest.mark.slow
@pytest.mark.usefixtures("sbatch")
def test_the_scripts_compute(folder: Path, invoke: Invoke) -> None:
    (folder / "unnamed.yaml").write_text(SPEC.replace("name: small\n", ""))
    words = ["submit", "unnamed.yaml", "--array", 1, "-o", "a b.h5", "--json"]
    done = invoke(*words, "--set", "seed=8")
    assert done.exit_code == 0, done.stderr
    made = json.loads(done.stdout)
    (folder / "unnamed.yaml").write_text("changed: meanwhile")
    environment = os.environ | {"SLURM_ARRAY_TASK_ID": "1"}
    for script in (made["array"]["script"], made["assembling"]["script"]):
        subprocess.run(["bash", script], env=environment, check=True, cwd="/")
    shown = json.loads(invoke("show", folder / "a b.h5", "--json").stdout)
    assert shown["name"] == "unnamed"
    assert "seed: 8" in shown["spec"]


def test_scripts_are_shown_without_writing(folder: Path, invoke: Invoke) -> None:
    done = invoke("submit", "small.yaml", "--array", 3, "-n", "--memory", "7G")
    assert done.exit_code == 0
    assert done.stdout.count("#!/bin/bash") == 2
    assert "#SBATCH --mem=7G\n" in done.stdout
    assert '--share "${SLURM_ARRAY_TASK_ID}/3"' in done.stdout
    estimated = json.loads(invoke("submit", "small.yaml", "--array", 3, "-n", "--json").stdout)
    assert "#SBATCH --mem=13" in estimated["array"]
    assert [path.name for path in folder.iterdir()] == ["small.yaml"]


def test_what_slurm_refuses_is_told(
    folder: Path, sbatch: Path, invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "refuse").write_text("")
    done = invoke("submit", "small.yaml", "--array", 2)
    assert done.exit_code == 1
    assert "it says: Invalid account" in done.stderr
    assert "the jobs 101 are submitted; when they have ended: sbatch" in done.stderr
    monkeypatch.setenv("PATH", str(folder))
    done = invoke("submit", "small.yaml", "--array", 2)
    assert done.exit_code == 1
    assert "sbatch is not on the PATH; where it is, submit these" in done.stderr
    assert sbatch.is_file()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[profile.long]\n", "has no profile 'short'; there are long"),
        ("[profile.shrt]\n", "did you mean 'shrt'"),
        ("profile = 3\n", "has no profile 'short'"),
        ("[profile]\nshort = 3\n", "must be a table"),
        (
            "[profile.short]\npartion = 'x'\n",
            "profile.short.partion: unknown key; did you mean",
        ),
        ("[profile.short]\ncpus = 'two'\n", "profile.short.cpus: must be a number, got 'two'"),
        ("[profile.short]\ncpus = true\n", "profile.short.cpus: must be a number"),
        ("[profile.short]\ncpus = 0\n", "must be at least 1, got 0"),
        ("[profile.short]\noptions = '-x'\n", "options: must be a list of texts"),
        ("[profile.short\n", "is no TOML: "),
    ],
)
def test_a_profile_is_checked(config: Path, text: str, message: str) -> None:
    config.write_text(text)
    with pytest.raises(RoughbenchError, match=r"config\.toml: ") as refused:
        load_profile("short")
    assert message in str(refused.value)


def test_where_profiles_are(
    folder: Path, monkeypatch: pytest.MonkeyPatch, invoke: Invoke
) -> None:
    monkeypatch.delenv("ROUGHBENCH_CONFIG", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(folder / "settings"))
    assert config_file() == folder / "settings" / "roughbench" / "config.toml"
    done = invoke("submit", "small.yaml", "--array", 2, "--profile", "short")
    assert done.exit_code == 1
    assert "there is no profile 'short': the file" in done.stderr
    monkeypatch.delenv("XDG_CONFIG_HOME")
    monkeypatch.setenv("HOME", str(folder))
    monkeypatch.setattr("sys.platform", "darwin")
    assert config_file().parent == folder / "Library" / "Application Support" / "roughbench"
    monkeypatch.setattr("sys.platform", "win32")
    monkeypatch.setenv("APPDATA", str(folder / "Roaming"))
    assert config_file().parent == folder / "Roaming" / "roughbench"


def test_what_cannot_stand_in_a_script_is_refused(tmp_path: Path) -> None:
    profile = JobProfile(account="a\nrm -r /")
    jobs = ShareJobs("x", ("rb",), tmp_path, tmp_path, tmp_path, tmp_path, 2, profile, "1G")
    with pytest.raises(RoughbenchError, match="an option is one line"):
        jobs.array_script()
