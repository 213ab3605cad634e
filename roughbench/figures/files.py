"""Figures on the disk: in which formats, and which of the files are figures of roughbench."""

from __future__ import annotations

import contextlib
import io
import re
import urllib.parse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from roughbench.errors import StoreError
from roughbench.outputs import ENDS, Kind, check_output, write_output
from roughbench.publish import make_folder

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAKER = "roughbench"
"""Every file names it, so that no figure of anybody else is ever replaced."""
FORMATS = ("pdf", "png", "svg")
USUAL = ("pdf", "png")
"""Where nothing is said."""


def check_files(name: str, folder: Path, formats: Sequence[str] = USUAL) -> None:
    """Refuse to draw what could not be saved.

    Raises
    ------
    StoreError
        If there is no such format, or a file is one of somebody else, or cannot be written.
    """
    for suffix in formats:
        if suffix not in FIGURE:
            raise StoreError(f"there is no format {suffix!r}; choose {', '.join(FORMATS)}")
        check_output(folder / f"{name}.{suffix}", FIGURE[suffix])


def save(
    figure: Figure,
    name: str,
    folder: Path,
    source: str = "",
    formats: Sequence[str] = USUAL,
) -> list[Path]:
    """Write ``name.pdf``, ``name.png`` …, each in one step.

    All say which results file they were drawn of, if ``source`` names one.

    Equal figures give equal bytes: no file holds a date or a version.

    Returns
    -------
    list of Path
        In the order of the formats.

    Raises
    ------
    StoreError
        If the folder cannot be made, or the files not be written, or one of their names
        is that of another file.
    """
    make_folder(folder)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # laid out: the same in all files
    maker = f"{MAKER}, of <{urllib.parse.quote(source)}>" if source else MAKER
    return [
        write_output(image(figure, suffix, maker), folder / f"{name}.{suffix}", FIGURE[suffix])
        for suffix in dict.fromkeys(formats)
    ]


def image(figure: Figure, suffix: str, maker: str = MAKER) -> bytes:
    """Return the bytes of a file that holds a figure, of one of :data:`FORMATS`."""
    import matplotlib as mpl

    undated: dict[str, dict[str, str | None]] = {
        "pdf": {"Creator": maker, "Producer": None, "CreationDate": None},
        "png": {"Software": maker},
        "svg": {"Creator": maker, "Date": None},
    }
    file = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": MAKER}):  # else parts of an SVG have random names
        figure.savefig(file, format=suffix, metadata=undated[suffix])
    return file.getvalue()


def source_of(path: Path) -> str:
    """Return the name of the results file that a figure was drawn of; empty if it says none."""
    with contextlib.suppress(OSError, KeyError):
        if path.is_file():  # to open a pipe is to wait
            with path.open("rb") as file:
                head = file.read(ENDS)
                file.seek(max(0, path.stat().st_size - ENDS))
                found = _MARKS[path.suffix].search(head + file.read(ENDS))
            text = (found[1] or b"").decode("latin-1") if found else ""
            return urllib.parse.unquote(text)
    return ""


_MADE = rb"roughbench(?:, of <([^>]*)>)?"
_MARKS = {
    ".pdf": re.compile(rb"/Creator \(" + _MADE + rb"\)"),
    ".png": re.compile(rb"tEXtSoftware\0" + _MADE),
    ".svg": re.compile(rb"<dc:title>roughbench(?:, of &lt;([^&]*)&gt;)?</dc:title>"),
}
FIGURE = {
    "pdf": Kind("figure", lambda _, tail: _MARKS[".pdf"].search(tail) is not None),
    "png": Kind("figure", lambda head, _: _MARKS[".png"].search(head) is not None),
    "svg": Kind("figure", lambda head, _: _MARKS[".svg"].search(head) is not None),
}
"""By suffix."""
