"""The style of the figures, and how they get onto the disk."""

from __future__ import annotations

import contextlib
import io
import re
import urllib.parse
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from roughbench.outputs import ENDS, Kind, check_output, write_output
from roughbench.publish import make_folder

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMN = 3.375
"""Width of a figure, in inches: one column of a two-column page."""
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's palette, told apart with any colour vision."""
GUIDE = "0.45"
"""Grey of guide lines and of what they say."""
SMALL = 7.0
"""Size of annotations, in points."""
MAKER = "roughbench"
"""Both files name it, so that no figure of anybody else is ever replaced."""
BACKGROUND = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}
"""Box behind a word that lines may run through."""


@contextlib.contextmanager
def publication_style() -> Iterator[None]:
    """Draw in the style of this package, whatever the user's own settings are."""
    import matplotlib as mpl

    with (
        mpl.rc_context(),
        resources.as_file(resources.files(__package__) / "roughbench.mplstyle") as path,
    ):
        mpl.rcdefaults()
        mpl.rcParams.update(mpl.rc_params_from_file(path, use_default_template=False))
        yield


def new_figure(
    rows: int, height: float, columns: int = 1, *, extra: float = 0.0, share: bool = False
) -> tuple[Figure, list[Axes]]:
    """Return an empty figure with its panels, row by row.

    Parameters
    ----------
    rows : int
    height : float
        Of one panel with its labels, inches; each is one column wide.
    columns : int
    extra : float
        Height of what stands outside the panels, inches.
    share : bool
        Whether all panels have the same limits of the pressure, and each row those of
        the ordinate.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(COLUMN * columns, height * rows + extra))
    axes = figure.subplots(
        rows, columns, squeeze=False, sharex=share, sharey="row" if share else False
    )
    return figure, list(axes.flat)


def letter(axes: Axes, number: int, text: str = "") -> None:
    """Write (a), (b), … and a word on the panel above its upper left corner."""
    axes.set_title(f"({chr(ord('a') + number % 26)})  {text}".rstrip(), loc="left", pad=3)


def legend_above(figure: Figure, handles: list[Artist], room: float = 0.9) -> None:
    """Put the legend above the panels, in as many columns as fit.

    The figure grows by what a legend is taller than ``room``, in inches, so that many
    contenders do not press the panels flat.
    """
    for columns in (4, 3, 2, 1):
        legend = figure.legend(handles=handles, loc="outside upper center", ncols=columns)
        rows = -(-len(handles) // columns)
        size = legend.get_window_extent()
        if columns == 1 or (rows > 1 and size.width < figure.bbox.width):
            taller = size.height / figure.dpi - room
            figure.set_figheight(figure.get_figheight() + max(taller, 0.0))
            return
        legend.remove()


def footnote(figure: Figure, lines: list[str]) -> None:
    """Write remarks under the panels, if there are any."""
    if lines:
        figure.supxlabel("\n".join(lines), color=GUIDE)


def check_files(name: str, folder: Path) -> None:
    """Refuse to draw what could not be saved.

    Raises
    ------
    StoreError
        If ``name.pdf`` or ``name.png`` is a file of somebody else, or cannot be written.
    """
    for suffix, kind in FIGURE.items():
        check_output(folder / f"{name}.{suffix}", kind)


def save(figure: Figure, name: str, folder: Path, source: str = "") -> list[Path]:
    """Write ``name.pdf`` and ``name.png``, each in one step.

    Both say which results file they were drawn of, if ``source`` names one.

    Equal figures give equal bytes: neither file holds a date or a version.

    Returns
    -------
    list of Path
        The PDF and the PNG.

    Raises
    ------
    StoreError
        If the folder cannot be made, or the files not be written, or one of their names
        is that of another file.
    """
    make_folder(folder)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # laid out: the same in both files
    maker = f"{MAKER}, of <{urllib.parse.quote(source)}>" if source else MAKER
    undated: dict[str, dict[str, str | None]] = {
        "pdf": {"Creator": maker, "Producer": None, "CreationDate": None},
        "png": {"Software": maker},
    }
    paths = []
    for suffix, metadata in undated.items():
        image = io.BytesIO()
        figure.savefig(image, format=suffix, metadata=metadata)
        path = folder / f"{name}.{suffix}"
        paths.append(write_output(image.getvalue(), path, FIGURE[suffix]))
    return paths


def source_of(path: Path) -> str:
    """Return the name of the results file that a PNG was drawn of; empty if it says none."""
    with contextlib.suppress(OSError):
        if path.is_file():  # to open a pipe is to wait
            with path.open("rb") as file:
                found = _PNG.search(file.read(ENDS))
            return urllib.parse.unquote((found[1] or b"").decode("latin-1")) if found else ""
    return ""


_MADE = rb"roughbench(?:, of <([^>]*)>)?"
_PDF = re.compile(rb"/Creator \(" + _MADE + rb"\)")
_PNG = re.compile(rb"tEXtSoftware\0" + _MADE)
FIGURE = {
    "pdf": Kind("figure", lambda _, tail: _PDF.search(tail) is not None),
    "png": Kind("figure", lambda head, _: _PNG.search(head) is not None),
}
"""By suffix."""
