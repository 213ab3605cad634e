"""The page in a browser without a network: what is drawn, what switches do, how wide it is."""

from __future__ import annotations

import html
import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread

from roughbench.report import make_report
from tests.report.conftest import EXPERIMENTS, LABELS, RESAMPLES

PROBE = (Path(__file__).parent / "probe.js").read_text(encoding="utf-8")
CURVES = len(LABELS) * len(EXPERIMENTS)
PHONE, DESK = 390, 1200

pytestmark = pytest.mark.browser

Browse = Callable[..., str]


@pytest.fixture(scope="module")
def browser() -> str:
    """Return the path of Chromium."""
    found = next(
        filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
    )
    if found is None:
        message = "no Chromium on PATH; install it, as with apt-get install chromium"
        if os.environ.get("CI") == "true":
            pytest.fail(message)
        pytest.skip(message)
    return found


@pytest.fixture(scope="module")
def browse(browser: str, tmp_path_factory: pytest.TempPathFactory) -> Browse:
    """Return a callable that opens a page, and returns its document when all is done."""
    folder = tmp_path_factory.mktemp("browser")

    def run(page: Path, *options: str, width: int = DESK, height: int = 900) -> str:
        done = subprocess.run(
            [
                browser,
                "--headless=new",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-dev-shm-usage",
                "--hide-scrollbars",
                "--no-first-run",
                "--disable-background-networking",
                "--host-resolver-rules=MAP * ~NOTFOUND",
                "--virtual-time-budget=60000",
                f"--user-data-dir={folder}",
                f"--window-size={width},{height}",
                *(options or ("--dump-dom",)),
                page.as_uri(),
            ],
            capture_output=True,
            timeout=240,
            check=True,
        )
        return done.stdout.decode()

    return run


@pytest.fixture(scope="module")
def page(results_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the page on the small run, with a spy in it."""
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(with_probe(make_report([results_file], resamples=RESAMPLES)), "utf-8")
    return path


def with_probe(text: str, more: str = "") -> str:
    head, end, body = text.partition("</head>")
    return f"{head}<script>{PROBE}</script>{end}{body.replace('</body>', more + '</body>')}"


def seen_in(document: str) -> dict[str, Any]:
    found = re.search(r'data-seen="([^"]*)"', document)
    assert found is not None, "the page was not drawn"
    seen: dict[str, Any] = json.loads(html.unescape(found[1]))
    return seen


@pytest.fixture(scope="module")
def seen(browse: Browse, page: Path) -> dict[str, Any]:
    return seen_in(browse(page))


def test_there_are_no_errors_and_no_requests(seen: dict[str, Any]) -> None:
    assert seen["errors"] == []
    assert seen["blocked"] == []
    assert [name for name in seen["requests"] if not name.startswith(("data:", "blob:"))] == []


def test_a_fault_would_be_seen(browse: Browse, page: Path, tmp_path: Path) -> None:
    faulty = tmp_path / "faulty.html"
    more = "<script>undefined_name()</script><img src='https://example.org/x.png'>"
    text = page.read_text(encoding="utf-8")
    faulty.write_text(text.replace("</body>", f"{more}</body>"), encoding="utf-8")
    seen = seen_in(browse(faulty))
    assert any("undefined_name" in error for error in seen["errors"])
    assert seen["blocked"] == ["https://example.org/x.png"]


def test_every_curve_is_drawn(seen: dict[str, Any]) -> None:
    assert seen["drawn"] == [CURVES] * 5
    random = len(LABELS) - 1
    assert seen["bands"] == 5 * random * len(EXPERIMENTS)


def test_switches_turn_models_and_experiments_off_and_on(seen: dict[str, Any]) -> None:
    assert seen["withoutFoundation"] == [CURVES - len(EXPERIMENTS)] * 5
    assert seen["oneExperiment"] == [len(LABELS)] * 5
    assert seen["again"] == seen["drawn"]


def test_buttons_change_the_axes(seen: dict[str, Any]) -> None:
    assert seen["axes"] == [["log", "log"], ["linear", "log"], ["linear", "linear"]]
    assert seen["words"].startswith("x: lineary: linear")


def test_hovering_tells_the_model_the_pressure_and_the_error(seen: dict[str, Any]) -> None:
    assert re.match(
        r"Exact \(BEM\), qr/q0\s=\s1p/E\* = 0.00631A/A0 = 0\.\d+ ± 0\.\d+$", seen["hover"]
    )


@pytest.mark.parametrize("width", [PHONE, 768, DESK])
def test_the_page_does_not_scroll_sideways(
    browse: Browse, page: Path, tmp_path: Path, width: int
) -> None:
    # A window has a least width; a frame has none.
    frame = tmp_path / "frame.html"
    frame.write_text(
        f'<body style="margin:0"><iframe src="{page.as_uri()}" '
        f'style="border:0;width:{width}px;height:900px"></iframe><script>'
        "onmessage = (event) => { document.documentElement.dataset.seen = event.data; }"
        "</script></body>",
        encoding="utf-8",
    )
    seen = seen_in(browse(frame))
    assert seen["width"] == width
    assert seen["scroll"] == width
    assert seen["wide"] == []
    assert seen["scrolling"] > 0 or width == DESK
    assert seen["scrolling"] == seen["said"]  # a word at every table that goes on


def test_a_picture_of_the_page_is_not_blank(
    browse: Browse, page: Path, seen: dict[str, Any], tmp_path: Path
) -> None:
    picture = tmp_path / "page.png"
    height = int(max(box[3] for box in seen["places"])) + 100
    browse(page, f"--screenshot={picture}", width=DESK, height=height)
    pixels = imread(picture)[..., :3]
    assert pixels.shape[1] == DESK
    for left, top, right, bottom in np.array(seen["places"]).round().astype(int):
        chart = pixels[top:bottom, left:right]
        coloured = np.ptp(chart, axis=2) > 0.2
        assert chart.std() > 0.05
        assert 0.001 < coloured.mean() < 0.5  # curves, not a block


def test_it_prints_all_of_its_tables(browse: Browse, page: Path, tmp_path: Path) -> None:
    printed = tmp_path / "report.pdf"
    browse(page, f"--print-to-pdf={printed}", "--no-pdf-header-footer")
    assert printed.read_bytes().startswith(b"%PDF-")
    assert printed.stat().st_size > 50_000
