r"""Words with formulas in them, written once and set in several ways.

Formulas stand between dollars, in the letters of Unicode, with ``_`` before a subscript:
``"pressure $σ/(E*ξ)$"``.
"""

from __future__ import annotations

import re
import unicodedata

_FORMULA = re.compile(r"\$([^$]*)\$")
_GREEK = re.compile("[Α-Ωα-ω]")
_COMMANDS = {"ū": r"\bar u", "E*²": r"E\!^{*2}", "E*": r"E\!^*", "²": "^2"}


def plain(text: str) -> str:
    """Return words for a terminal.

    Examples
    --------
    >>> plain("contact area $A/A_0$"), plain("$K h_rms/E*$")
    ('contact area A/A0', 'K h_rms/E*')
    """
    return re.sub(r"_(?=\d)", "", text.replace("$", ""))


def typeset(text: str) -> str:
    """Return words for prose, with the subscripts that Unicode has.

    Examples
    --------
    >>> typeset("$A/A_0$"), typeset("$ū/h_rms$")
    ('A/A₀', 'ū/h_rms')
    """
    return re.sub(r"_(\d)", lambda found: chr(ord("₀") + int(found[1])), text.replace("$", ""))


def mathtext(text: str) -> str:
    r"""Return words for a figure.

    Examples
    --------
    >>> print(mathtext("separation $ū/h_rms$"), mathtext("$C_σ/πq$ of $E*$"))
    separation $\bar u/h_\mathrm{rms}$ $C_\sigma/\pi q$ of $E\!^*$
    """
    return _FORMULA.sub(lambda found: f"${_mathtext(found[1])}$", text)


def _mathtext(formula: str) -> str:
    formula = re.sub(r"_(\w{2,})", r"_\\mathrm{\1}", formula)
    for letter, command in _COMMANDS.items():
        formula = formula.replace(letter, command)
    formula = _GREEK.sub(lambda found: f"{_greek(found[0])} ", formula)
    return re.sub(r" (?![A-Za-z])", "", formula)  # a letter would belong to the command


def _greek(letter: str) -> str:
    """Return a letter's command, after its name in Unicode."""
    _, size, _, *_, name = unicodedata.name(letter).replace("LAMDA", "LAMBDA").split()
    return "\\" + (name.lower() if size == "SMALL" else name.capitalize())
