"""The report's first section: the measured surface, or the spectrum of those that are made."""

from __future__ import annotations

import base64
import io
import math
import re

import numpy as np
import pytest
from matplotlib.image import imread
from scipy.integrate import trapezoid

from roughbench.report.sources import ReportSource
from roughbench.report.surface_tables import fit_in_words, synthetic_table
from roughbench.report.surfaces import surface_sections
from roughbench.report.text import plain
from roughbench.results import Results
from roughbench.surface_record import fitted_spectrum
from tests.recorded import FIT, WARNINGS, a_record, with_record
from tests.report.conftest import EXPERIMENTS, Page, page_of

HOSTILE = "<b>&amp;</script>"


@pytest.fixture(scope="module")
def scanned(small: Results) -> Results:
    return with_record(small, EXPERIMENTS[0], a_record())


@pytest.fixture(scope="module")
def page(scanned: Results) -> Page:
    return Page(page_of(scanned))


def test_the_surface_leads_and_the_claims_are_last_and_folded(page: Page) -> None:
    ids = [
        str(found["id"]) for tag, found in page.elements if tag == "section" and "id" in found
    ]
    sections = [name for name in ids if "-" not in name]
    assert sections == [
        "surface",
        "figures",
        "trust",
        "warnings",
        "fits",
        "provenance",
        "verdicts",
    ]
    tags = [tag if found.get("id") != "verdicts" else "claims" for tag, found in page.elements]
    claims = tags[tags.index("claims") :]
    assert claims.index("details") < claims.index("table")
    _, folded = page.elements[tags.index("claims") + claims.index("details")]
    assert "open" not in folded
    figures = [found.get("id") for tag, found in page.elements if tag == "figure"]
    assert figures[:4] == [
        None,
        "file-0-surface-0-spectrum",
        "file-0-surface-0-heights",
        "file-0-area",
    ]


def test_what_makes_an_answer_doubtful_is_said_first(page: Page) -> None:
    text = " ".join(page.text.split())
    assert text.index(WARNINGS[0]) < text.index("Heights: 80 µm × 40 µm")


def test_the_map_shows_the_heights(scanned: Results) -> None:
    [section] = surface_sections(ReportSource("plate.h5", scanned))
    image = base64.b64decode(section.image.partition(",")[2])
    pixels = imread(io.BytesIO(image), "png")[::-1, :, :3].sum(axis=2)  # the first row is below
    heights = a_record().heights
    assert pixels.shape == heights.shape
    brighter = np.corrcoef(pixels.ravel(), heights.ravel())[0, 1]
    assert brighter > 0.95
    low, high = heights.min() * 1e9, heights.max() * 1e9
    assert section.scale == (f"−{-low:.0f} nm", f"{high:.0f} nm")
    assert section.shape == "2"


def test_the_charts_have_units_and_hold_the_numbers(scanned: Results) -> None:
    [section] = surface_sections(ReportSource("plate.h5", scanned))
    spectrum, heights = (chart.data for chart in section.charts)
    assert spectrum["x"] == {"title": "wavevector q = 2π/wavelength (1/µm)", "type": "log"}
    assert re.fullmatch(r"spectrum C \(.m<sup>4</sup>\)", spectrum["y"]["title"])
    q, power = a_record().spectrum
    measured, law = spectrum["curves"]
    np.testing.assert_allclose(measured["x"], q * 1e-6, rtol=5e-4)
    np.testing.assert_allclose(
        np.array(measured["y"]) / measured["y"][0], power / power[0], rtol=1e-3
    )
    assert law["x"][0] == pytest.approx(FIT["q0"] * 1e-6, rel=1e-3)
    assert heights["x"] == {"title": "height above the mean (nm)", "type": "linear"}
    area = [float(trapezoid(curve["y"], curve["x"])) for curve in heights["curves"]]
    assert area == pytest.approx([1.0, 1.0], abs=0.01)


def test_the_law_is_the_spectrum_of_its_parameters() -> None:
    """It was made by H = 0.78, flat below 0.63/µm, with a slope of 0.12."""
    found = fitted_spectrum(FIT)
    assert found is not None
    q, power = found
    assert q[0] == FIT["q0"]
    assert q[-1] == FIT["q1"]
    np.testing.assert_allclose(q[1:3], FIT["qr"])
    assert power[0] == pytest.approx(power[1])
    slope = math.log(power[-1] / power[-2]) / math.log(q[-1] / q[-2])
    assert slope == pytest.approx(-2 * (1 + FIT["H"]))


def test_the_law_in_words() -> None:
    assert plain(fit_in_words(FIT)) == (
        "A self-affine law fits the spectrum: Hurst exponent H = 0.780 ± 0.030, flat for waves "
        "longer than 9.97 ± 0.79 µm, down to waves of 157.1 ± 7.9 nm; "
        "rms slope 0.1200 ± 0.0040."
    )
    assert "No self-affine law fits" in plain(fit_in_words(None))


@pytest.mark.parametrize("fit", [None, FIT | {"H": 1.02}, FIT | {"q1": 1e5}])
def test_what_is_no_self_affine_law_is_not_drawn(small: Results, fit: object) -> None:
    results = with_record(small, EXPERIMENTS[0], a_record(fit=fit))
    [section] = surface_sections(ReportSource("plate.h5", results))
    assert [curve["name"] for curve in section.charts[0].data["curves"]] == ["measured"]


def rows_of(results: Results, table: str) -> list[list[str]]:
    """Return the texts of a table of the only measured surface."""
    [section] = surface_sections(ReportSource("plate.h5", results))
    return [[plain(cell) for cell in row] for row in getattr(section, table).rows]


def test_its_tables_have_parameters_and_steps(scanned: Results) -> None:
    parameters = {row[0]: row[2] for row in rows_of(scanned, "parameters")}
    assert parameters["Sq"] == "82 nm"
    assert parameters["Ssk"] == "−0.21"
    assert parameters["Sdr"] == "0.7 %"
    assert parameters["Sz"] == "610 nm"
    assert rows_of(scanned, "steps") == [
        ["as read", "256 × 512 points of plate.al3d", "256 × 512", "410 nm", "0.16"],
        ["plane", "a plane removed: 22 nm per µm", "256 × 512", "84 nm", "0.13"],
        ["mirror", "mirrored at both borders", "512 × 1024", "82 nm", "0.12"],
    ]


def test_a_parameter_without_a_description_is_shown_as_it_is(small: Results) -> None:
    record = a_record(parameters={"Sq": 8.2e-8, "Spk": 2.5, "Ssk": math.nan})
    rows = rows_of(with_record(small, EXPERIMENTS[0], record), "parameters")
    assert rows[1] == ["Spk", "Spk", "2.5"]
    assert rows[2][2] == "–"


def test_made_surfaces_have_a_row_for_every_spectrum(small: Results, scanned: Results) -> None:
    table = synthetic_table(ReportSource("small.h5", small))
    assert table is not None
    assert [plain(row[0]) for row in table.rows] == ["qr/q0\xa0=\xa01", "qr/q0\xa0=\xa04"]
    assert [plain(cell) for cell in table.rows[1]][1:6] == [
        "0.7",
        "6.283",
        "1.571",
        "0.3927",
        "0.1",
    ]
    other = synthetic_table(ReportSource("plate.h5", scanned))
    assert other is not None
    assert len(other.rows) == 1


def test_hostile_names_change_no_element(small: Results) -> None:
    record = a_record(source=HOSTILE, warnings=(HOSTILE,))
    hostile = Page(page_of(with_record(small, EXPERIMENTS[0], record)))
    plain_page = Page(page_of(with_record(small, EXPERIMENTS[0], a_record())))
    assert hostile.tags == plain_page.tags
    assert hostile.text.count(HOSTILE) >= 2


def test_a_flat_or_spiky_surface_has_a_picture(small: Results) -> None:
    flat = with_record(small, EXPERIMENTS[0], a_record(heights=np.zeros((4, 4))))
    [section] = surface_sections(ReportSource("plate.h5", flat))
    assert section.scale == ("0 m", "0 m")
