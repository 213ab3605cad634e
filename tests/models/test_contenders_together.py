"""Every contender in one spec: run, stored, drawn, fitted; on heights from a file too."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.errors import SpecError
from roughbench.figures import available, render
from roughbench.fits import fit
from roughbench.models import MODELS
from roughbench.results import Results
from roughbench.spec import load_spec

VARIANTS: list[dict[str, Any]] = [
    {"kind": "bem"},
    {"kind": "foundation", "springs": 128},
    {"kind": "line"},
    {"kind": "persson"},
    {"kind": "persson", "label": "own", "area_gamma": 0.5},
    {"kind": "winkler"},
    {"kind": "winkler", "label": "limit", "heights": "gaussian"},
    {"kind": "gw"},
    {"kind": "gw", "label": "counted", "summits": "counted"},
    {"kind": "gw_elliptic"},
    {"kind": "gw_elliptic", "label": "each", "summits": "counted"},
    {"kind": "bgt"},
    {"kind": "hertz_top"},
    {"kind": "hertz_top", "label": "typical", "radius": "spectrum"},
]
SPECTRUM_ALONE = {"persson", "own", "limit", "gw", "gw_elliptic", "bgt", "typical"}


def name(model: dict[str, Any]) -> str:
    return str(model.get("label", model["kind"]))


@pytest.fixture(scope="module")
def together(tmp_path_factory: pytest.TempPathFactory) -> Results:
    path = tmp_path_factory.mktemp("run") / "all.h5"
    rb.run(
        {
            "name": "all",
            "surface": {"H": 0.7, "q0": 1.0, "qr": 2.0, "q1": 16.0, "slope": 0.1},
            "pressures": [1e-6, 1e-5, 1e-4, 1e-3, 1e-2],
            "realizations": 3,
            "seed": 4,
            "models": VARIANTS,
        },
        output=path,
        threads=1,
    )
    return rb.load(path)


def test_the_list_of_variants_is_complete() -> None:
    assert {model["kind"] for model in VARIANTS} == set(MODELS)


def test_each_has_its_curves_and_its_realizations(together: Results) -> None:
    found = together["main"]
    assert list(found) == [name(model) for model in VARIANTS]
    for label, result in found.items():
        assert result.n_realizations == (1 if label in SPECTRUM_ALONE else 3), label
        ended = 3 if result.kind == "hertz_top" else 0
        assert set(np.unique(result["status"])) <= {0, ended}, label
        assert (result["status"][:, :2] == 0).all(), label
        area = result["area_mean"]
        assert (np.diff(area[np.isfinite(area)]) > 0).all(), label
        assert ("grid_points" in result.attributes) == (label not in SPECTRUM_ALONE), label
    assert found["line"].attributes["points"] == found["line"].attributes["grid_points"] == 256
    assert found["winkler"].attributes["grid"] == 64
    assert "summits_in_contact" in found["counted"]
    assert found["own"].attributes["area_gamma"] == 0.5


def test_titles_tell_variants_apart(together: Results) -> None:
    titles = [result.title for result in together["main"].values()]
    assert titles.count("Persson") == 2  # labels tell these two apart
    assert len(set(titles)) == len(titles) - 1


def test_figures_and_fits_take_all_of_them(together: Results, tmp_path: Path) -> None:
    assert {"area", "separation", "stiffness", "fig3"} <= set(available(together))
    for figure in ("area", "stiffness"):
        for path in render(together, figure, tmp_path):
            assert path.stat().st_size > 0
    fitted = fit(together, resamples=10)["main"]
    assert set(fitted) == set(together["main"])
    assert fitted["bgt"]["kappa"].value == pytest.approx(math.sqrt(2 * math.pi), rel=1e-9)


@pytest.mark.parametrize("shape", [(32, 32), (128,)])
def test_heights_from_a_file(
    shape: tuple[int, ...], tmp_path: Path, rng: np.random.Generator
) -> None:
    """Smooth heights, so that counted summits are rounded."""
    modes = np.fft.rfftn(rng.normal(size=shape))
    q = np.meshgrid(*(np.fft.fftfreq(n) * n for n in shape), indexing="ij")
    size = np.sqrt(sum(k * k for k in q))[..., : shape[-1] // 2 + 1]
    modes[(size > 6) | (size == 0)] = 0
    heights = np.fft.irfftn(modes)
    np.save(tmp_path / "heights.npy", 0.01 * heights / heights.std())
    wanted = 2 if len(shape) == 2 else 1
    models = [
        {key: value for key, value in model.items() if key != "springs"}
        for model in VARIANTS
        if name(model) in SPECTRUM_ALONE or _dimension(model) == wanted
    ]
    assert len(models) == len(SPECTRUM_ALONE) + (5 if wanted == 2 else 2)
    found = rb.run(
        {
            "name": "measured",
            "surface": {"kind": "file", "path": str(tmp_path / "heights.npy"), "length": 1.0},
            "pressures": [1e-5, 1e-4],
            "models": models,
        }
    )["main"]
    for label, result in found.items():
        assert result.n_realizations == 1
        assert np.isfinite(result["area"][0, 0]), label


def _dimension(model: dict[str, Any]) -> int:
    return MODELS[model["kind"]](**model).dimension


@pytest.mark.parametrize(
    ("model", "message"),
    [
        ({"kind": "winkler", "heights": "gaussian", "grid": 64}, "has no effect with heights"),
        ({"kind": "gw", "grid": 64}, "has no effect with summits: nayak"),
        ({"kind": "hertz_top", "radius": "spectrum", "grid": 64}, "has no effect with radius"),
        ({"kind": "gw_elliptic", "realizations": 3}, "works on the spectrum"),
        ({"kind": "line", "points": 20}, "models.0..points: 20 points per side are too coarse"),
        ({"kind": "winkler", "grid": 20}, "models.0..grid: 20 points per side are too coarse"),
        ({"kind": "persson", "area_gamma": 0.0}, "area_gamma: must be greater than 0"),
        ({"kind": "hertz_top", "reach": 0.0}, "reach: must be greater than 0"),
    ],
)
def test_options_without_effect_or_sense_are_refused(
    model: dict[str, Any], message: str
) -> None:
    tree = {
        "name": "bad",
        "surface": {"H": 0.7, "q0": 1.0, "q1": 16.0, "slope": 0.1},
        "pressures": [1e-3],
        "models": [model],
    }
    with pytest.raises(SpecError, match=message):
        load_spec(tree)
