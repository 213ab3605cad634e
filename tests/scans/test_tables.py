"""Text files of topographies: whatever separates the numbers, whatever stands above them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roughbench.errors import SurfaceError
from roughbench.scans import number_blocks, number_text, tables
from roughbench.scans.image import FloatArray
from roughbench.scans.topography import Scan, read_scan
from tests.scans.writers import write_xyz

H = np.random.default_rng(5).standard_normal((6, 9))
SPIP = "# File Format = ASCII\n# x-pixels = 9\n# y-pixels = 6\n"
SIZE, UNIT = (6e-6, 9e-6), 1e-9


def text(heights: FloatArray, sign: str = " ", form: Callable[[float], str] = repr) -> str:
    return "".join(sign.join(form(float(h)) for h in row) + "\n" for row in heights)


def save(folder: Path, content: str | bytes, name: str = "scan.txt") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def read(path: Path, **given: object) -> Scan:
    return read_scan(path, **({"size": SIZE, "unit": UNIT} | given))  # type: ignore[arg-type]


def comma(h: float) -> str:
    return repr(h).replace(".", ",")


@pytest.mark.parametrize(
    ("content", "name"),
    [
        (text(H), "a.txt"),
        (text(H, "\t"), "a.txt"),
        (text(H, ";"), "a.csv"),
        (text(H, ","), "a.csv"),
        (text(H, ", "), "a.csv"),
        (text(H, " ; "), "a.csv"),
        (text(H, "   "), "a.asc"),
        (text(H, " \t"), "a.tsv"),
        (text(H, ";", comma), "a.csv"),
        (text(H, "\t", comma), "a.txt"),
        (text(H, " ", comma), "a.txt"),
        (text(H, ";").replace("\n", ";\n"), "trailing.csv"),
        (text(H, ";").replace("\n", " ; \n"), "trailing.csv"),
        (text(H, "\t").replace("\n", "\t\n"), "trailing.txt"),
        (text(H).replace("\n", "\r\n"), "windows.txt"),
        (text(H).replace("\n", "\r"), "old.txt"),
        (text(H).replace("\n", "\n\n"), "blank-lines.txt"),
        ("  " + text(H).replace("\n", "\n  "), "indented.txt"),
        (text(H).rstrip("\n"), "unended.txt"),
        ("\ufeff" + text(H, ";", comma), "bom.csv"),
        (text(H).encode("utf-16"), "utf16.txt"),
        (b"# Breite des Bildes: gro\xdf\n" + text(H).encode(), "latin1.txt"),
        ("Kommentar\nund noch einer, 3 Zeilen lang\n\n" + text(H), "prose.txt"),
        (text(H) + "# done\n", "footer.txt"),
        (text(H, ";", lambda h: f"{h:+.17E}"), "exponents.csv"),
    ],
)
def test_a_matrix_reads_however_it_is_written(
    tmp_path: Path, content: str | bytes, name: str
) -> None:
    scan = read(save(tmp_path, content, name))
    np.testing.assert_allclose(scan.heights, H * UNIT, rtol=1e-12)
    assert scan.size == SIZE


@settings(max_examples=30, deadline=None)
@given(
    st.integers(4, 7),
    st.integers(4, 7),
    st.sampled_from([";", "\t", ",", " ; ", ", "]),
    st.data(),
)
def test_empty_cells_are_holes_wherever_they_are(
    tmp_path_factory: pytest.TempPathFactory,
    rows: int,
    columns: int,
    sign: str,
    data: st.DataObject,
) -> None:
    gone = data.draw(st.lists(st.booleans(), min_size=rows * columns, max_size=rows * columns))
    holes = np.array(gone).reshape(rows, columns)
    holes[1, 1] = False
    holes[:, -1] &= np.arange(rows) % 2 == 0  # else the last sign would end every line
    heights = 0.5 + np.arange(float(rows * columns)).reshape(rows, columns)
    heights[holes] = np.nan
    path = save(
        tmp_path_factory.mktemp("gaps"),
        text(heights, sign, lambda h: "" if np.isnan(h) else repr(h)),
    )
    np.testing.assert_array_equal(read(path, unit=1.0).heights, heights)


@pytest.mark.parametrize(
    "word",
    [
        "nan",
        "NaN",
        "BAD",
        "bad",
        "inf",
        "-inf",
        "N/A",
        "None",
        "-",
        "---",
        "***",
        "?",
        "No Data",
    ],
)
@pytest.mark.parametrize("sign", [" ", "\t", ";", ","])
def test_words_for_missing_points(tmp_path: Path, word: str, sign: str) -> None:
    if " " in word and sign == " ":
        sign = "\t"
    heights = H.copy()
    heights[0, 0] = heights[2, 3:5] = heights[5, 8] = np.nan
    scan = read(save(tmp_path, text(heights, sign, lambda h: word if np.isnan(h) else repr(h))))
    np.testing.assert_allclose(scan.heights, heights * UNIT, rtol=1e-12)
    assert scan.missing == pytest.approx(4 / 54)


@pytest.mark.parametrize(
    ("header", "size", "unit"),
    [
        ("# Channel: Z\n# Width: 9.00 µm\n# Height: 6.00 µm\n# Value units: nm\n", SIZE, UNIT),
        ("# Kanal: Z\n# Breite: 9,0 µm\n# Höhe: 6,0 µm\n# Einheiten: m\n", SIZE, 1.0),
        (
            SPIP + "# x-length = 9000\n# y-length = 6000\n# Bit2nm = 0.5\n# Start of Data:\n",
            SIZE,
            0.5e-9,
        ),
        (
            SPIP + "# x-length = 9\n# y-length = 6\n# x-unit = um\n# z-unit = Å\n",
            SIZE,
            1e-10,
        ),
        (
            "NX = 9\nNY = 6\nScale X = 1\nScale Y = 1\nUnit X = um\nUnit Data = nm\n",
            SIZE,
            UNIT,
        ),
        ("Pixel size: 1 µm\nz unit: mm\n", SIZE, 1e-3),
        ("x size;9;um\n", None, None),
        ("# Value units: µm\n", None, 1e-6),
    ],
)
def test_headers_say_size_and_unit(
    tmp_path: Path, header: str, size: tuple[float, float] | None, unit: float | None
) -> None:
    path = save(tmp_path, header + text(H, "\t"))
    image = tables.read_table(path, "scan.txt", None)
    assert image.size == (None if size is None else pytest.approx(size, rel=1e-12))
    assert image.unit == (None if unit is None else pytest.approx(unit, rel=1e-12))
    np.testing.assert_array_equal(image.values, H)


def test_numbers_in_one_column_take_the_shape_that_the_header_says(tmp_path: Path) -> None:
    header = "# x-pixels = 9\n# y-pixels = 6\n"
    scan = read(save(tmp_path, header + text(H.reshape(-1, 1))))
    np.testing.assert_allclose(scan.heights, H * UNIT, rtol=1e-12)


def test_several_matrices_are_channels(tmp_path: Path) -> None:
    head = "# Channel: {}\n# Width: 9 µm\n# Height: 6 µm\n# Value units: {}\n"
    path = save(
        tmp_path,
        head.format("Phase", "deg")
        + text(H[:5])
        + "\n"
        + head.format("ZSensor", "nm")
        + text(H)
        + head.format("Back", "nm")
        + text(-H),
    )
    scan = read_scan(path)
    assert scan.channel == "ZSensor"
    np.testing.assert_allclose(scan.heights, H * UNIT, rtol=1e-12)
    np.testing.assert_allclose(read_scan(path, channel="Back").heights, -H * UNIT, rtol=1e-12)
    with pytest.raises(
        SurfaceError,
        match=r"no channel 'Zsensor'; it holds Phase \(deg\), ZSensor \(nm\), Back",
    ) as caught:
        read_scan(path, channel="Zsensor")
    assert "did you mean channel: ZSensor?" in str(caught.value)
    with pytest.raises(SurfaceError, match=r"Phase \(deg\) holds no heights"):
        read_scan(path, channel="Phase")


def test_a_long_file_is_read_in_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(number_text, "_CHUNK", 100)
    monkeypatch.setattr(number_blocks, "_SAMPLE", 10)
    heights = H.copy()
    heights[4, 2] = np.nan
    content = "# Value units: nm\n" + text(
        heights, ";", lambda h: "" if np.isnan(h) else repr(h)
    )
    np.testing.assert_allclose(
        read(save(tmp_path, content)).heights, heights * UNIT, rtol=1e-12
    )
    content = content.replace(repr(float(H[5, 1])), "0.1x")
    with pytest.raises(SurfaceError, match=r"line 7: '0\.1x' is no number"):
        read(save(tmp_path, content))


FAULTS = [
    ("", "the file is empty"),
    ("\n \n", "no lines of numbers in it"),
    ("only words\nin it\n", "no lines of numbers in it"),
    (text(H) + "1 2 3\n", "line 7: 3 numbers, where the lines before have 9"),
    ("512 512\n" + text(H), "line 2: 9 numbers, where the lines before have 2; mark header"),
    (text(H).replace(repr(float(H[2, 3])), "1.2.3"), "line 3: '1.2.3' is no number"),
    (text(H).replace(repr(float(H[2, 3])), "12:30"), "line 3: '12:30' is no number"),
    (text(H, ";").replace(repr(float(H[2, 3])), "1,2.3"), "is no number"),
    (text(H, ";").replace(repr(float(H[2, 3])), "1 2"), "by semicolons and by blanks, too"),
    (text(H, "\t").replace(repr(float(H[2, 3])) + "\t", "1 "), "by tabs and by blanks, too"),
    ("1,5\n2,5\n3,5\n4,5\n", "is 1,5 one number or two"),
    (text(H[:, :1]), "6 lines with one number each are no matrix"),
    (text(H[:3]), "at least 4 points per side, got 3 rows and 9 columns"),
    (
        "# x-pixels = 10\n# y-pixels = 6\n" + text(H),
        "says 6 rows and 10 columns, it has 6 and 9",
    ),
    (
        text(H) + "# Channel: b\n" + text(H) + "# Channel: b\n" + text(H),
        "several matrices of one",
    ),
    (";0;1;2;3\n0;5;5;6;7\n1;4;5;6;7\n2;3;4;5;5\n3;1;2;3;3\n", "look like coordinates"),
    (text(H) * 10 + "\0\0\0\n", "bytes of zero"),
    (text(H)[:-30] + "\0\0\0\n", "bytes of zero"),
    ("\ufffeab", "no lines"),
    (text(np.full((5, 5), np.nan), ";"), "no lines of numbers in it|all 25 points are missing"),
]


@pytest.mark.parametrize(("content", "message"), FAULTS)
def test_each_fault_has_its_line(tmp_path: Path, content: str, message: str) -> None:
    path = save(tmp_path, content)
    with pytest.raises(SurfaceError, match=message) as caught:
        read_scan("scan.txt", tmp_path, size=SIZE, unit=UNIT)
    assert str(caught.value).startswith("scan.txt: ")
    assert "\n" not in str(caught.value)
    assert path.exists()


# Lists of points --------------------------------------------------------------------------


@pytest.mark.parametrize("rounding", [17, 4])
def test_points_in_any_order_fill_their_grid(tmp_path: Path, rounding: int) -> None:
    heights = H.copy()
    heights[1, 2] = heights[5, 8] = heights[0, 0] = np.nan
    order = np.random.default_rng(1).permutation(H.size)
    path = tmp_path / "points.xyz"
    write_xyz(path, heights, (1.0, 1.0 / 3.0), order, "# Lateral units: µm\n# Value units: nm")
    if rounding == 4:
        lines = path.read_text().splitlines()
        cut = [" ".join(f"{float(n):.4g}" for n in line.split()) for line in lines[2:]]
        path.write_text("\n".join(lines[:2] + cut))
    scan = read_scan(path)
    np.testing.assert_allclose(
        scan.heights, heights * 1e-9, rtol=1e-12 if rounding == 17 else 1e-3
    )
    assert scan.size == pytest.approx((6e-6, 3e-6), rel=1e-12 if rounding == 17 else 1e-3)


def test_units_of_points_may_stand_above_their_columns(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    write_xyz(path, H, (2.0, 1.0), np.arange(H.size))
    path.write_text("X [mm];Y [mm];Z [µm]\n" + path.read_text().replace(" ", ";"))
    scan = read_scan(path)
    np.testing.assert_allclose(scan.heights, H * 1e-6, rtol=1e-12)
    assert scan.size == pytest.approx((12e-3, 9e-3))


def test_points_without_units_need_a_size_of_their_shape(tmp_path: Path) -> None:
    path = tmp_path / "points.xyz"
    write_xyz(path, H, (2.0, 1.0), np.arange(H.size))
    with pytest.raises(SurfaceError, match="does not say the size of the image and the unit"):
        read_scan(path)
    assert read_scan(path, size=(12e-6, 9e-6), unit=1e-9).spacing == (2e-6, 1e-6)
    with pytest.raises(SurfaceError, match=r"pixels 2 times as high as wide.* 1 times as high"):
        read_scan(path, size=(6e-6, 9e-6), unit=1e-9)


def test_coordinates_that_are_a_little_off_are_noted(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    rows, columns = (part.ravel() for part in np.indices((30, 40)))
    off = rng.uniform(-0.02, 0.02, (2, rows.size))
    off[:, [0, -1]] = 0.0
    points = np.stack([columns + off[0], rows + off[1], rng.standard_normal(rows.size)], axis=1)
    path = tmp_path / "points.xyz"
    np.savetxt(path, points)
    scan = read_scan(path, size=(30e-6, 40e-6), unit=1e-9)
    np.testing.assert_allclose(scan.heights.ravel(), points[:, 2] * 1e-9, rtol=1e-12)
    assert "of a step off their nodes" in scan.notes[0]


def scattered(rng: np.random.Generator) -> FloatArray:
    return rng.uniform(0.0, 1.0, (200, 3))


def rounded(rng: np.random.Generator) -> FloatArray:
    return rng.uniform(0.0, 1.0, (200, 3)).round(2)


def doubled(_: np.random.Generator) -> FloatArray:
    rows, columns = (part.ravel() for part in np.indices((5, 5)))
    points = np.stack([columns, rows, 1.0 * rows], axis=1)
    return np.concatenate([points, points[7:8]])


def in_a_line(rng: np.random.Generator) -> FloatArray:
    return np.stack([np.arange(9.0), np.full(9, 2.0), rng.standard_normal(9)], axis=1)


def without_place(rng: np.random.Generator) -> FloatArray:
    points = rng.uniform(0.0, 1.0, (20, 3))
    points[4, 1] = np.nan
    return points


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (scattered, r"no regular grid: the 200 values of x have no common step"),
        (rounded, r"no regular grid: its 200 points would fill \d\.\d\d% of a grid"),
        (doubled, r"2 points at one place, x = 2, y = 1: 26 points on a grid of 5 by 5"),
        (in_a_line, r"all 9 points have y = 2: a line, no map"),
        (without_place, r"point 5 of 20 has no coordinates"),
    ],
)
def test_what_is_no_grid_is_refused_with_numbers(
    tmp_path: Path, make: Callable[[np.random.Generator], FloatArray], message: str
) -> None:
    path = tmp_path / "points.xyz"
    np.savetxt(path, make(np.random.default_rng(2)))
    with pytest.raises(SurfaceError, match=message):
        read_scan(path, size=SIZE, unit=UNIT)


def test_an_xyz_file_has_three_columns(tmp_path: Path) -> None:
    with pytest.raises(SurfaceError, match="three columns, x, y and height, got 9"):
        read_scan(save(tmp_path, text(H), "a.xyz"), size=SIZE, unit=UNIT)
