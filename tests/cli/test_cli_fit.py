"""``roughbench fit``: tables, JSON, refusals."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result

import roughbench as rb
from roughbench.cli.fit import command
from roughbench.cli.fit_tables import as_text, to_json
from roughbench.fits import RESAMPLES, fit
from roughbench.numbers import with_interval
from roughbench.verdict import fit_experiments, trust_of
from tests.fits.lawful import collect, make
from tests.fits.test_comparisons import exact_curves, without

Invoke = Callable[..., Result]

SPEC = """\
name: fits
surface: {H: 0.7, q0: 1.0, qr: 4.0, q1: 256.0, slope: 0.1}
pressures: {min: 1.0e-8, max: 0.1, points: 29}
realizations: 8
seed: 7
models:
  - kind: foundation
    springs: 1024
  - kind: winkler
    grid: 512
  - kind: persson
sweep: {surface.qr: [1.0, 4.0]}
"""


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the results file of the spec above."""
    folder = tmp_path_factory.mktemp("fits")
    (folder / "fits.yaml").write_text(SPEC)
    rb.run(folder / "fits.yaml", output=folder / "fits.h5", threads=1)
    return folder / "fits.h5"


def test_prints_a_row_for_every_model(fits: Path, invoke: Invoke) -> None:
    done = invoke("fit", fits, "--reference", "winkler", "--resamples", 20)
    assert done.exit_code == 0
    assert done.stderr == ""
    text = done.stdout
    for experiment in ("surface.qr=1.0", "surface.qr=4.0"):
        assert f"== {experiment} ==" in text
    assert "1/(1+H) = 0.588" in text
    assert "agrees with winkler" in text
    found = fit(rb.load(fits), reference="winkler", resamples=20)
    for models in found.values():
        for names in models.values():
            kappa = names["kappa"]
            if not math.isnan(kappa.value):
                shown = f"{kappa.value:.4g}"
                if not math.isnan(kappa.error):
                    shown = with_interval(kappa.value, kappa.low, kappa.high, 4)
                assert shown in text
    assert "≤ 1e-08" in text  # Persson's area is proportional down to the first pressure
    assert "nan" not in text


def test_without_an_exact_solver_there_is_nothing_to_leave(fits: Path, invoke: Invoke) -> None:
    done = invoke("fit", fits, "--resamples", 2)
    assert done.exit_code == 0
    assert "agrees with" not in done.stdout


def test_json_is_strict_and_complete(fits: Path, invoke: Invoke) -> None:
    done = invoke("fit", fits, "--json", "--reference", "persson", "--resamples", 20)
    assert done.exit_code == 0

    def refuse(name: str) -> float:
        raise AssertionError(f"{name} is no JSON")

    content = json.loads(done.stdout, parse_constant=refuse)
    assert content["references"] == {"surface.qr=1.0": "persson", "surface.qr=4.0": "persson"}
    assert content["resamples"] == 20
    found = fit(rb.load(fits), reference="persson", resamples=20)
    for experiment, models in found.items():
        for label, names in models.items():
            shown = content["experiments"][experiment][label]
            assert list(shown) == list(names)
            for name, estimate in names.items():
                value = shown[name]["value"]
                assert value == (estimate.value if math.isfinite(estimate.value) else None)
                assert shown[name]["is_bound"] is estimate.is_bound
    persson = content["experiments"]["surface.qr=4.0"]["persson"]
    assert persson["kappa"]["error"] is None
    trusts = trust_of(fit_experiments([("fits.h5", rb.load(fits))], "persson", 20))
    assert json.loads(to_json(rb.load(fits), found, "persson", 20, trusts)) == content


def test_digits_follow_the_error_and_columns_the_longest() -> None:
    curves = exact_curves()
    scatter = np.linspace(0.7, 1.3, len(curves["area"]))[:, None]
    results = collect(make({name: array * scatter for name, array in curves.items()}))
    text = as_text(results, fit(results, resamples=50), "file.h5", None)
    found = re.findall(r"(\d+(?:\.(\d+))?) ± \d+(?:\.(\d+))?", text)
    assert found
    assert all(len(value) == len(error) for _, value, error in found)
    for block in text.split("\n\n"):
        heads = [line for line in block.splitlines() if line.startswith("     ")]
        rows = [line for line in block.splitlines() if line.startswith("bem  ")]
        for head, row in zip(heads, rows, strict=False):
            starts = [match.start() for match in re.finditer(r"(?<=  )\S", head)]
            assert all(row[at - 2 : at] == "  " and row[at] != " " for at in starts[1:])


def test_what_a_model_does_not_give_is_said() -> None:
    bare = without(make(exact_curves(), "erf09"), "separation", "stiffness")
    results = collect(make(exact_curves()), bare)
    fitted = fit(results, resamples=10)
    text = as_text(results, fitted, "file.h5", None)
    assert "A/A0 at equal ū/h_rms within 10 %: from" in text
    row = text.split("in p at equal ū/h_rms\n")[1].splitlines()[0]
    assert row.split() == ["erf09", "1", *["not", "given"] * 5]
    content = json.loads(to_json(results, fitted, None, 10))["experiments"]["main"]["erf09"]
    assert content["kappa"]["value"] is not None
    assert "stiffness_agrees_to_10" not in content
    assert "area_at_separation_factor" not in content


def test_the_same_file_gives_the_same_errors(fits: Path, invoke: Invoke) -> None:
    one, other = (invoke("fit", fits, "--resamples", 30).stdout for _ in range(2))
    assert one == other


def test_an_unknown_reference_is_refused(fits: Path, invoke: Invoke) -> None:
    done = invoke("fit", fits, "--reference", "bem")
    assert done.exit_code == 1
    assert done.stderr == (
        "error: no model is named 'bem'; choose one of foundation, winkler, persson\n"
    )
    assert invoke("fit", fits, "--resamples", 1).exit_code == 2


def test_as_many_resamples_as_from_python() -> None:
    (option,) = (option for option in command.params if option.name == "resamples")
    assert option.default == RESAMPLES


def test_it_says_where_each_model_can_be_trusted(fits: Path, invoke: Invoke) -> None:
    done = invoke("fit", fits, "--reference", "winkler", "--resamples", 20)
    text = " ".join(done.stdout.split())
    content = json.loads(
        invoke("fit", fits, "--json", "--reference", "winkler", "--resamples", 20).stdout
    )
    assert content["trust"].keys() == {"surface.qr=1.0", "surface.qr=4.0"}
    for models in content["trust"].values():
        assert models.keys() == {"foundation", "persson"}
        for one in models.values():
            assert one["basis"] in text
            assert one["quantities"].keys() == {"area", "separation", "stiffness"}
            for found in one["quantities"].values():
                assert found["sentence"] in text
                assert found["percent"] == 10
                assert len(found["deviations"]) == 8  # decades from 1e-8 to 0.1


def test_a_model_without_a_comparison_has_a_sentence_alone() -> None:
    results = collect(make(exact_curves()), without(make(exact_curves(), "persson"), "area"))
    experiments = fit_experiments([("one", results)], None, 2)
    fitted = {one.experiment: one.fits for one in experiments}
    found = json.loads(to_json(results, fitted, None, 2, trust_of(experiments)))
    quantities = found["trust"]["main"]["persson"]["quantities"]
    assert quantities["area"] == {"sentence": "not given"}
    assert quantities["stiffness"]["deviations"][0]["value"] == 0.0
