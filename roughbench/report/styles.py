"""How models and experiments look in the charts: colour and symbol, and dashes.

The templates know how the legend draws each symbol and each pattern of dashes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from roughbench.figures.styles import curve_styles
from roughbench.models.persson import Persson
from roughbench.report.sources import ReportSource
from roughbench.report.text import plotly_text
from roughbench.results import ModelResult

SYMBOLS = (
    "square-open",
    "circle",
    "triangle-up",
    "diamond",
    "triangle-down",
    "x",
    "cross",
    "pentagon",
    "star-triangle-up",
    "hourglass",
    "triangle-left",
    "triangle-right",
)
"""plotly's names of markers."""
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
"""plotly's names of dashes."""
THEORY_COLOUR = Persson.style.colour
"""Of Persson's theory, drawn beside the observables of a model."""


@dataclass(frozen=True, slots=True)
class PageStyle:
    """How a model is drawn: in a colour, ``#RRGGBB``, with one of :data:`SYMBOLS`."""

    colour: str
    symbol: str


def page_styles(sources: Sequence[ReportSource]) -> dict[str, PageStyle]:
    """Return a style for every label, the same in all files."""
    printed = curve_styles(pair for source in sources for pair in source.models())
    return {
        label: PageStyle(style.colour, SYMBOLS[place % len(SYMBOLS)])
        for place, (label, style) in enumerate(printed.items())
    }


def experiment_dashes(experiments: Iterable[str]) -> dict[str, str]:
    """Return the dashes of every experiment of a file, solid for the first."""
    return {name: DASHES[place % len(DASHES)] for place, name in enumerate(experiments)}


@dataclass(frozen=True, slots=True, eq=False)
class DrawnModel:
    """A model in one experiment, and how all charts of its file draw it.

    The name is in plotly's subset of HTML, and the dash one of :data:`DASHES`.
    """

    experiment: str
    result: ModelResult
    name: str
    style: PageStyle
    dash: str

    @property
    def meta(self) -> dict[str, str]:
        """By which the page's script finds the curves."""
        return {"model": self.result.label, "experiment": self.experiment}


def drawn_models(source: ReportSource, styles: Mapping[str, PageStyle]) -> Iterator[DrawnModel]:
    """Yield the models of a file as its charts draw them, in styles by label."""
    dashes = experiment_dashes(source.results)
    for experiment, result in source.models():
        name = plotly_text(source.curve_name(experiment, result.label))
        yield DrawnModel(experiment, result, name, styles[result.label], dashes[experiment])
