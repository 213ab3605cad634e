"""Pressures and gaps side by side."""

from __future__ import annotations

import numpy as np
import pytest

import roughbench as rb
from roughbench.figures import FIGURES
from roughbench.figures.style import publication_style
from roughbench.results import Results

TREE = {
    "name": "distributions",
    "surface": {"H": 0.7, "q0": 1.0, "q1": 8.0, "slope": 0.1},
    "pressures": [1e-3, 1e-2],
    "realizations": 2,
    "models": [
        {"kind": "winkler", "grid": 32},
        {"kind": "winkler", "label": "limit", "heights": "gaussian"},
        {"kind": "persson"},
    ],
    "observables": ["pressure_pdf", "gap_pdf"],
}


@pytest.fixture(scope="module")
def results() -> Results:
    return rb.run(TREE)


def test_each_row_has_springs_their_limit_and_the_theory(results: Results) -> None:
    assert FIGURES["distributions"].missing(results) is None
    with publication_style():
        figure = FIGURES["distributions"].draw(results)
        figure.draw_without_rendering()
    assert len(figure.axes) == 4
    springs, persson = "Winkler (2D springs)", results["main"]["persson"].title
    limit = "Winkler (2D springs, Gaussian limit)"
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert words == [springs, limit, persson]
    for k, (left, right) in zip(
        (0, 1), zip(*[iter(figure.axes)] * 2, strict=True), strict=True
    ):
        held = results["main"]["winkler"]
        for axes, name in ((left, "pressure_pdf"), (right, "gap_pdf")):
            lines = {
                one.get_gid(): np.asarray(one.get_ydata(), float) for one in axes.get_lines()
            }
            assert set(lines) == {springs, limit, persson}
            mean = held[f"{name}_mean"][k]
            np.testing.assert_array_equal(lines[springs], mean[mean > 0.0])
        x = held["pressure_pdf_bin"]
        # The limit has the area of its model, the theory that of Persson.
        for name, label in ((limit, "limit"), (persson, "persson")):
            [found] = (one for one in left.get_lines() if one.get_gid() == name)
            area = float(results["main"][label]["area"][0, k])
            total = np.asarray(found.get_ydata(), float).sum() * (x[1] - x[0])
            assert total == pytest.approx(area, rel=1e-3)


def test_it_says_what_it_needs() -> None:
    bare = rb.run({key: value for key, value in TREE.items() if key != "observables"})
    assert "pressure_pdf and gap_pdf" in str(FIGURES["distributions"].missing(bare))
