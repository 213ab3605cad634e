"""The style of the figures, and the panels that they are drawn into."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughbench.errors import StoreError
from roughbench.text import on_one_line

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
BACKGROUND = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}
"""Box behind a word that lines may run through."""


@dataclass(slots=True)
class Canvas:
    """Where :func:`new_figure` draws while :func:`drawing_on` is in force.

    Attributes
    ----------
    axes : tuple of Axes or None
        Panels of the caller's; None: those of a figure that pyplot shows.
    panels : list of Axes
        That have been made, or given.
    """

    axes: tuple[Axes, ...] | None = None
    panels: list[Axes] = field(default_factory=list)


_CANVAS: ContextVar[Canvas | None] = ContextVar("canvas", default=None)


@contextlib.contextmanager
def drawing_on(canvas: Canvas) -> Iterator[None]:
    """Have figures drawn into panels that are there, or shown by pyplot."""
    token = _CANVAS.set(canvas)
    try:
        yield
    finally:
        _CANVAS.reset(token)


@contextlib.contextmanager
def publication_style(style: str | Path = "") -> Iterator[None]:
    """Draw in the style of this package, whatever the user's own settings are.

    Parameters
    ----------
    style : str or path
        What differs from it: a style of Matplotlib by name, or a style file.

    Raises
    ------
    StoreError
        If there is no such style or file, or a line of it says nothing to Matplotlib.
    """
    import matplotlib as mpl

    with (
        mpl.rc_context(),
        resources.as_file(resources.files(__package__) / "roughbench.mplstyle") as path,
    ):
        mpl.rcdefaults()
        mpl.rcParams.update(mpl.rc_params_from_file(path, use_default_template=False))
        if style:
            mpl.rcParams.update(_settings(style))
        yield


def _settings(style: str | Path) -> dict[Any, Any]:
    """Return what a style sheet sets."""
    import matplotlib as mpl
    import matplotlib.style

    name = on_one_line(str(style))
    if str(style) in matplotlib.style.library:
        return dict(matplotlib.style.library[str(style)])
    if not Path(style).is_file():
        raise StoreError(
            f"there is no style {name!r}: neither a file nor one of Matplotlib's, which are "
            f"{', '.join(matplotlib.style.available)}"
        )
    said: list[str] = []
    listener = logging.Handler()
    listener.emit = lambda record: said.append(record.getMessage())  # type: ignore[method-assign]
    logger = logging.getLogger("matplotlib")
    logger.addHandler(listener)
    propagated, logger.propagate = logger.propagate, False
    try:
        found = dict(mpl.rc_params_from_file(style, use_default_template=False))
    except (OSError, UnicodeDecodeError) as error:
        raise StoreError(f"{name}: no style sheet that can be read: {error}") from error
    finally:
        logger.removeHandler(listener)
        logger.propagate = propagated
    if said:
        raise StoreError(f"{name}: {on_one_line(' '.join(said[0].split()))}")
    return found


def new_figure(
    rows: int,
    height: float,
    columns: int = 1,
    *,
    extra: float = 0.0,
    share: bool = False,
    width: float | None = None,
) -> tuple[Figure, list[Axes]]:
    """Return an empty figure with its panels, row by row; or those of :func:`drawing_on`.

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
    width : float, optional
        Of the figure, inches; default: that of its columns.

    Raises
    ------
    StoreError
        If there are panels to draw into, more or fewer than the figure has.
    """
    from matplotlib.figure import Figure

    canvas = _CANVAS.get()
    if canvas is not None and canvas.axes is not None:
        if rows * columns != len(canvas.axes):
            many = "one panel" if rows * columns == 1 else f"{rows * columns} panels"
            raise StoreError(
                f"the figure has {many}, and ax is {len(canvas.axes)}: give ax as many, as of "
                f"plt.subplots({rows}, {columns}), or leave it out"
            )
        canvas.panels = list(canvas.axes)
        if share:
            _share(canvas.panels, columns)
        return _figure_of(canvas.axes[0]), canvas.panels
    size = (COLUMN * columns if width is None else width, height * rows + extra)
    if canvas is None:
        figure = Figure(figsize=size)
    else:
        import matplotlib.pyplot as plt

        figure = plt.figure(figsize=size)
    axes = figure.subplots(
        rows, columns, squeeze=False, sharex=share, sharey="row" if share else False
    )
    if canvas is not None:
        canvas.panels = list(axes.flat)
    return figure, list(axes.flat)


def _figure_of(axes: Axes) -> Figure:
    """Return the whole figure that a panel is in."""
    from matplotlib.figure import Figure

    figure: Any = axes.figure
    while figure is not None and not isinstance(figure, Figure):
        figure = figure.figure  # of a part of a figure, the whole
    if figure is None:
        raise StoreError("ax is in no figure: make both with matplotlib.pyplot.subplots")
    return figure


def _share(panels: Sequence[Axes], columns: int) -> None:
    """Give panels the same limits of x, and those of a row the same of y, if they have not."""
    for k, panel in enumerate(panels):
        row = panels[k - k % columns]
        if not panel.get_shared_x_axes().joined(panel, panels[0]):
            panel.sharex(panels[0])
        if not panel.get_shared_y_axes().joined(panel, row):
            panel.sharey(row)


def _given() -> tuple[Axes, ...] | None:
    canvas = _CANVAS.get()
    return None if canvas is None else canvas.axes


def set_width(figure: Figure, inches: float) -> None:
    """Set the width of a figure, unless it is the caller's."""
    if _given() is None:
        figure.set_figwidth(inches)


def letter(axes: Axes, number: int, text: str = "") -> None:
    """Write (a), (b), … and a word on the panel above its upper left corner."""
    axes.set_title(f"({chr(ord('a') + number % 26)})  {text}".rstrip(), loc="left", pad=3)


def legend_above(figure: Figure, handles: list[Artist], room: float = 0.9) -> None:
    """Put the legend above the panels, in as many columns as fit.

    The figure grows by what a legend is taller than ``room``, in inches, so that many
    contenders do not press the panels flat. In panels that were given it stands in the first.
    """
    given = _given()
    if given is not None:
        axes = given[0]
        axes.legend(handles=handles, loc="upper right" if axes.child_axes else "best")
        return
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
    """Write remarks under the panels, if there are any; at the last axis of those given."""
    given = _given()
    if given is not None:
        given[-1].set_xlabel("\n".join([given[-1].get_xlabel(), *lines]))
    elif lines:
        figure.supxlabel("\n".join(lines), color=GUIDE)
