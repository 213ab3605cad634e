"""Text for the page: what comes from results and specs escaped, numbers typeset."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterable, Sequence

_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_MATH = {
    r"\xi": "ξ",
    r"\gamma": "γ",
    r"\bar u": "ū",
    r"\mathrm{rms}": "rms",
    r"E\!^*": "E*",
    r"\times": "·",
}
_FOLDERS = re.compile(r"(?<![\w.~/\\])(?:~|[A-Za-z]:)?[/\\](?:[^\s/\\'\",:;{}\[\]]+[/\\])+")
"""Where an absolute path begins: its folders, up to the name of the file."""


SCROLL_WORD = '<p class="more" aria-hidden="true">more to the right: scroll sideways →</p>'
"""Beneath what is wider than the page; the styles show it only there."""


def escape(text: object) -> str:
    """Return text as it may stand in HTML, within quotation marks too.

    Examples
    --------
    >>> escape('<b> & "c"')
    '&lt;b&gt; &amp; &quot;c&quot;'
    """
    return html.escape(str(text), quote=True)


def prose(text: str) -> str:
    """Return plain text with formulas as HTML, with its sub- and superscripts.

    Examples
    --------
    >>> prose("K h_rms ~ p^(1/(1+H)), gw_elliptic from 1e-05, q^−(1+H)")
    'K h<sub>rms</sub> ~ p<sup>1/(1+H)</sup>, gw_elliptic from 10⁻⁵, q<sup>−(1+H)</sup>'
    """
    text = re.sub(r"(?<![\w.])\d(?:\.\d+)?e[-+]\d+(?!\w)", lambda m: number(float(m[0])), text)
    text = re.sub(
        r"(?<![A-Za-z_])([^\W\d_])_([a-z0-9]{1,3})\b", r"\1<sub>\2</sub>", escape(text)
    )
    inner = r"[^()]*(?:\([^()]*\)[^()]*)*"
    text = re.sub(rf"\^([-−]\({inner}\))", r"<sup>\1</sup>", text)
    return re.sub(rf"\^(?:\(({inner})\)|([-−]?\w+))", r"<sup>\1\2</sup>", text)


def muted(text: str) -> str:
    """Return text as HTML that stands back."""
    return f'<span class="muted">{escape(text)}</span>'


def without_folders(text: str) -> str:
    """Return text in which absolute paths have lost their folders.

    Examples
    --------
    >>> without_folders("path: /home/ann/data/heights.npy, and 1/(1+H)")
    'path: …/heights.npy, and 1/(1+H)'
    """
    return _FOLDERS.sub("…/", text)


def from_mathtext(text: str) -> str:
    r"""Return the words of a figure's legend as HTML.

    Examples
    --------
    >>> from_mathtext(r"Popov, $n = 5$"), from_mathtext("$q_r = 8$")
    ('Popov, n = 5', 'q<sub>r</sub> = 8')
    >>> from_mathtext(r"$L = 2\times10^{-6}$")
    'L = 2·10<sup>-6</sup>'
    """
    pieces = re.split(r"\$([^$]*)\$", text)
    return "".join(
        _formula(piece) if number % 2 else escape(piece) for number, piece in enumerate(pieces)
    )


def _formula(text: str) -> str:
    for name, letter in _MATH.items():
        text = text.replace(name, letter)
    text = re.sub(r"_(?:\{(\w+)\}|([a-z0-9]+))", r"<sub>\1\2</sub>", escape(text))
    return re.sub(r"\^\{(-?\d+)\}", r"<sup>\1</sup>", text)


def number(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits, as in a text.

    Examples
    --------
    >>> number(1.6e-5), number(-0.25), number(math.inf), number(math.nan), number(2048, 4)
    ('1.6·10⁻⁵', '−0.25', '∞', '–', '2048')
    """
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    power = math.floor(math.log10(abs(value)))
    text = f"{value:.{digits}g}"
    if -4 < power < max(4, digits + 1):
        return (f"{value:.0f}" if "e" in text else text).replace("-", "−")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    times = "" if mantissa in ("1", "-1") else f"{mantissa}·"
    sign = "-" if mantissa == "-1" else ""
    return f"{sign}{times}{_power(int(exponent))}".replace("-", "−")


def with_error(value: float, error: float, digits: int = 3) -> str:
    """Return value ± error, both to the second digit of the error.

    Parameters
    ----------
    value : float
        nan: not there, shown as a dash.
    error : float
        nan: none.
    digits : int
        Significant digits of a value without an error.

    Examples
    --------
    >>> with_error(2.0512, 0.0231), with_error(1.234e-5, 2.2e-7), with_error(1.5, math.nan)
    ('2.051 ± 0.023', '(1.234 ± 0.022)·10⁻⁵', '1.5')
    """
    if not (math.isfinite(value) and math.isfinite(error) and error > 0.0):
        return number(value, digits)
    largest = max(abs(value), error)
    power = math.floor(math.log10(largest))
    if -4 < power < 4:
        power = 0
    places = max(0, 1 - math.floor(math.log10(error)) + power)
    if places > 12:  # an error of rounding only
        return number(value, digits)
    scale = 10.0**power
    text = f"{value / scale:.{places}f} ± {error / scale:.{places}f}".replace("-", "−")
    return f"({text})·{_power(power)}" if power else text


def _power(exponent: int) -> str:
    return f"10{str(exponent).translate(_SUPERSCRIPTS)}"


def series(values: Iterable[float], digits: int = 3, most: int = 6) -> str:
    """Return a list of numbers; of a long one the ends and how many there are.

    Examples
    --------
    >>> series([8.0, 1.0, 1.0]), series(range(1, 21))
    ('1, 8', '1 … 20 (20 values)')
    """
    found = sorted(set(values))
    if len(found) <= most:
        return ", ".join(number(value, digits) for value in found)
    return f"{number(found[0], digits)} … {number(found[-1], digits)} ({len(found)} values)"


def table(
    headings: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    caption: str = "",
    numeric: bool = True,
) -> str:
    """Return a table in a box that scrolls; the first cell of a row is its heading.

    Parameters
    ----------
    headings : sequence of str
        HTML; the first stands over the headings of the rows.
    rows : sequence of sequence of str
        HTML.
    caption : str
        HTML.
    numeric : bool
        Whether the cells are numbers, and do not wrap.
    """
    head = "".join(f'<th scope="col">{heading}</th>' for heading in headings)
    body = "\n".join(
        f'<tr><th scope="row">{row[0]}</th>'
        + "".join(
            f'<td data-heading="{_without_tags(heading)}">{cell}</td>'
            for heading, cell in zip(headings[1:], row[1:], strict=True)
        )
        + "</tr>"
        for row in rows
    )
    kind = "numbers" if numeric else "words"
    title = f"<caption>{caption}</caption>" if caption else ""
    return (
        f'<div class="scrolls"><div class="scroll" tabindex="0"><table class="{kind}">{title}\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>"
        f"{SCROLL_WORD}</div>"
    )


def _without_tags(text: str) -> str:
    return re.sub(r"<[^>]*>", "", text)
