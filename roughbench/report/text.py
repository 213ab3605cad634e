"""Text with formulas in pieces, each with its style: templates escape and set them.

Nothing here is HTML, but for :func:`plotly_text`.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterable
from typing import NamedTuple

from roughbench.models import BUILT_IN
from roughbench.numbers import number
from roughbench.results import ModelResult
from roughbench.units import in_words


class Span(NamedTuple):
    """A piece of text in a style: sub, sup, code, muted, br (a new line) or none."""

    text: str
    style: str = ""


RichText = list[Span]

_MATH = {
    r"\xi": "ξ",
    r"\gamma": "γ",
    r"\bar u": "ū",
    r"\mathrm{rms}": "rms",
    r"E\!^*": "E*",
    r"\times": "·",
}
_MATHTEXT = re.compile(r"_\{?(?P<sub>(?<=\{)\w+|[a-z0-9]+)\}?|\^\{(?P<sup>-?\d+)\}")
_NOTATION = re.compile(
    r"(?<=(?<![A-Za-z_])[^\W\d_])_(?P<sub>[a-z0-9σ]{1,3})\b"
    r"|\^(?P<sup>[-−]?\([^()]*(?:\([^()]*\)[^()]*)*\)|[-−]?\w+)"
)
_EXPONENTIAL = re.compile(r"(?<![\w.])\d(?:\.\d+)?e[-+]\d+(?!\w)")
_SPEC_WORDS = re.compile(
    r"(?P<code>(?:sweep|observables): (?:\{[^}]*\}|\[[^\]]*\])|\bsurface\.\w+|\bq[r01]\b|"
    rf"\b(?:{'|'.join(BUILT_IN)})\b)"
)
"""What stands in specs: two keys with their values, wavevectors, kinds of models."""
_FOLDERS = re.compile(r"(?<![\w.~/\\])(?:~|[A-Za-z]:)?[/\\](?:[^\s/\\'\",:;{}\[\]]+[/\\])+")
"""Where an absolute path begins: its folders, up to the name of the file."""


def from_notation(text: str) -> RichText:
    """Return plain text with formulas, ``h_rms`` and ``p^(1/2)``, in pieces.

    Examples
    --------
    >>> plotly_text(from_notation("K h_rms ~ p^(1/(1+H)), gw_elliptic from 1e-05, q^−(1+H)"))
    'K h<sub>rms</sub> ~ p<sup>1/(1+H)</sup>, gw_elliptic from 10⁻⁵, q<sup>−(1+H)</sup>'
    """
    return [
        Span(piece[1:-1], style)
        if style == "sup" and piece.startswith("(")
        else Span(piece, style)
        for piece, style in _split(_NOTATION, _typeset(text))
    ]


def from_heading(text: str) -> RichText:
    """Return the heading of a fit, with the subscripts that a terminal has not.

    Examples
    --------
    >>> plotly_text(from_heading("A ~ p, in A/A0"))
    'A ∼ p, in A/A<sub>0</sub>'
    """
    return from_notation(re.sub(r"\b([Aup])0\b", r"\1_0", text).replace("~", "∼"))


def from_mathtext(text: str) -> RichText:
    r"""Return the text of a figure's legend in pieces.

    Examples
    --------
    >>> from_mathtext(r"Popov, $n = 5$"), from_mathtext("$q_r = 8$")
    ([Span(text='Popov, ', style=''), Span(text='n = 5', style='')],
     [Span(text='q', style=''), Span(text='r', style='sub'), Span(text=' = 8', style='')])
    >>> plotly_text(from_mathtext(r"$L = 2\times10^{-6}$"))
    'L = 2·10<sup>-6</sup>'
    """
    spans: RichText = []
    for place, piece in enumerate(re.split(r"\$([^$]*)\$", text)):
        if place % 2:
            for name, letter in _MATH.items():
                piece = piece.replace(name, letter)
            spans += _split(_MATHTEXT, piece)
        elif piece:
            spans.append(Span(piece))
    return spans


def from_remedy(text: str) -> RichText:
    """Return what a spec needs in pieces: keys and kinds of a spec are code.

    Examples
    --------
    >>> plotly_text(from_remedy("a spec with bem and qr = 8 q0"))
    'a spec with <code>bem</code> and <code>qr</code> = 8 <code>q0</code>'
    """
    return _split(_SPEC_WORDS, _typeset(text))


def _typeset(text: str) -> str:
    return _EXPONENTIAL.sub(lambda found: number(float(found[0])), text)


def _split(pattern: re.Pattern[str], text: str) -> RichText:
    """Return the pieces of a text: the groups of the pattern are named after their styles."""
    spans, end = [], 0
    for found in pattern.finditer(text):
        style = found.lastgroup or ""
        spans += [Span(text[end : found.start()]), Span(found[style], style)]
        end = found.end()
    return [span for span in [*spans, Span(text[end:])] if span.text]


def joined(parts: Iterable[str | RichText], between: str = ", ") -> RichText:
    """Return texts as one."""
    spans: RichText = []
    for part in parts:
        if spans:
            spans.append(Span(between) if between != "\n" else Span(" ", "br"))
        spans += [Span(part)] if isinstance(part, str) else part
    return spans


def plain(text: str | RichText) -> str:
    """Return text without its styles."""
    return text if isinstance(text, str) else "".join(span.text for span in text)


def plotly_text(text: RichText) -> str:
    """Return text in plotly's subset of HTML."""
    return "".join(
        f"<{style}>{html.escape(piece)}</{style}>" if style else html.escape(piece)
        for piece, style in text
    )


def pressure_words(result: ModelResult, pressure: float) -> str:
    """Return a pressure of some results in words: p/E* = 0.001, or with units p = 1 MPa."""
    if result.has_units:
        return f"p = {in_words(pressure, 'Pa')}"
    return f"p/E* = {number(pressure)}"


def without_folders(text: str) -> str:
    """Return text in which absolute paths have lost their folders.

    Examples
    --------
    >>> without_folders("path: /home/ann/data/heights.npy, and 1/(1+H)")
    'path: …/heights.npy, and 1/(1+H)'
    """
    return _FOLDERS.sub("…/", text)
