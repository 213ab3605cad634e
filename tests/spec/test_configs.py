"""The specs that come with roughbench."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from roughbench.models.foundation import Foundation
from roughbench.spec import SelfAffineSurface, load_spec

CONFIGS = Path(__file__).parents[2] / "configs"
FILES = sorted(CONFIGS.rglob("*.yaml"))


def test_they_are_all_there() -> None:
    assert [str(path.relative_to(CONFIGS)) for path in FILES] == [
        "fig1.yaml",
        "fig2.yaml",
        "fig3.yaml",
        "fig4.yaml",
        "models.yaml",
        "paper/bem.yaml",
        "paper/fig3.yaml",
        "paper/fig4.yaml",
        "quick.yaml",
        "smoke.yaml",
        "study/below.yaml",
        "study/cells.yaml",
        "study/contenders-256.yaml",
        "study/contenders.yaml",
        "study/cutoff.yaml",
        "study/exponents-64.yaml",
        "study/exponents-8.yaml",
        "study/fields.yaml",
        "study/finite-size-rolloff.yaml",
        "study/finite-size.yaml",
        "study/gaussian.yaml",
        "study/hurst.yaml",
        "study/ladder.yaml",
        "study/paper-size.yaml",
        "study/points.yaml",
        "study/resolution.yaml",
        "study/rolloff.yaml",
        "study/size.yaml",
        "study/slope-128-few.yaml",
        "study/slope-128.yaml",
        "study/slope-32-coarse.yaml",
        "study/slope-32.yaml",
        "study/slope-512.yaml",
        "study/slope-8.yaml",
        "study/theory.yaml",
        "units.yaml",
    ]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_each_says_what_it_is_for_and_holds_what_it_promises(path: Path) -> None:
    assert path.read_text(encoding="utf-8").startswith("# ")
    spec = load_spec(path)
    folder = path.parent.name
    paper = folder == "paper"
    assert spec.name == (path.stem if folder == "configs" else f"{folder}-{path.stem}")
    experiments = spec.experiments()
    if folder == "study":
        assert len(spec.sweep) <= 1, "one thing varies at most"
    else:
        assert len(experiments) == 2, "without and with a roll-off"
    for _, experiment in experiments:
        surface = experiment.surface
        assert isinstance(surface, SelfAffineSurface)
        assert surface.q_max == 8192.0 or not paper
        for model in experiment.models:
            if isinstance(model, Foundation):
                waves = surface.q_max * surface.length / (2 * math.pi)
                assert model.springs >= 4 * waves
                assert model.undersampled == "error"


def test_the_papers_own_number_of_springs_is_one_option_away() -> None:
    path = CONFIGS / "paper" / "fig3.yaml"
    overrides = ["models.foundation.springs=8192", "models.foundation.undersampled=alias"]
    foundation = load_spec(path, overrides).models[0]
    assert isinstance(foundation, Foundation)
    assert (foundation.springs, foundation.undersampled) == (8192, "alias")
