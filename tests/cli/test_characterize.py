"""``roughbench characterize``: tables, JSON, a picture and a spec."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from roughbench.cli import main
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """Write a file of heights in nm on 10 µm, with a hole."""
    q0 = 2 * math.pi / 10e-6
    law = self_affine(hurst=0.8, q_min=q0, q_rolloff=4 * q0, q_max=32 * q0, rms_slope=0.1)
    heights = 1e9 * make_surface(law, 128, 10e-6, realization_generator(0, 0))
    heights[5:9, 7:12] = np.nan
    np.save(tmp_path / "plate.npy", heights)
    return tmp_path / "plate.npy"


def call(*words: object) -> Result:
    return CliRunner().invoke(main, ["characterize", *map(str, words)])


GIVEN = ("--size", "10 um", "--unit", "nm")


def test_a_table_for_people(scan: Path) -> None:
    result = call(scan, *GIVEN)
    assert result.exit_code == 0, result.output
    for word in (
        "128 × 128 points",
        "10 µm × 10 µm",
        "Sq",
        " nm",
        "as read",
        "profiles along x",
    ):
        assert word in result.output
    assert "Self-affine law" in result.output
    assert "fill: 1 %" in result.output
    assert "e-0" not in result.output  # prefixes, not powers of ten


def test_json(scan: Path) -> None:
    result = call(scan, *GIVEN, "--json", "--fill", "1%", "--detrend", "none")
    assert result.exit_code == 0, result.output
    values = json.loads(result.stdout)
    assert values["points"] == [128, 128]
    assert values["size"] == [1e-5, 1e-5]
    assert values["missing"] == 0.0
    assert values["raw"]["missing"] == pytest.approx(20 / 128**2)
    assert values["fit"]["H"] == pytest.approx(0.8, abs=0.1)
    assert values["Sdq"] == pytest.approx(0.1, rel=0.1)


def test_a_spec_and_a_picture(scan: Path, tmp_path: Path) -> None:
    spec, picture = tmp_path / "plate.yaml", tmp_path / "plate.png"
    for _ in range(2):  # its own files may be written over
        result = call(scan, *GIVEN, "-o", spec, "--figure", picture)
        assert result.exit_code == 0, result.output
    assert str(spec) in result.output
    assert str(picture) in result.output
    text = spec.read_text(encoding="utf-8")
    for line in ("path: plate.npy", "size: [10 um, 10 um]", "unit: nm", "fill: 1 %"):
        assert line in text
    assert "# A placeholder" in text
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_json_on_stdout_alone(scan: Path, tmp_path: Path) -> None:
    result = call(scan, *GIVEN, "--json", "-o", tmp_path / "plate.yaml")
    assert json.loads(result.stdout)["points"] == [128, 128]
    assert "plate.yaml" in result.stderr


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ((), 2, "size"),
        (("--size", "1 / 10 um", "--unit", "nm"), 1, "two ways"),
        ((*GIVEN, "--fill", "150%"), 2, "must be a share"),
        ((*GIVEN, "--fill", "0"), 2, "missing"),
        ((*GIVEN, "--figure", "plate.jpeg"), 1, ".png, .pdf or .svg"),
        ((*GIVEN, "--detrend", "cubic"), 2, "plane"),
    ],
)
def test_faults(scan: Path, words: tuple[str, ...], code: int, message: str) -> None:
    result = call(scan, *words)
    assert result.exit_code == code, result.output
    assert message in result.output


def test_no_file_of_anybody_else_is_written_over(scan: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text("name: mine\n")
    result = call(scan, *GIVEN, "-o", mine)
    assert result.exit_code == 1
    assert "choose another name" in result.output
    assert mine.read_text() == "name: mine\n"
    assert call(scan, *GIVEN, "--figure", scan.with_suffix(".png")).exit_code == 0
    assert call(scan, *GIVEN, "-o", scan).exit_code == 1
