"""Text from outside, made fit for a terminal, a file name or a figure; and likely meanings."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterable
from pathlib import Path

_UNSAFE = re.compile(
    "[\x00-\x1f\x7f-\x9f]"  # control characters, line breaks among them
    "|[\u2028\u2029]"  # line and paragraph separator
    "|[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]"  # bidirectional marks
    "|[\ud800-\udfff]"  # half characters, as of file names in another encoding
)
"""What moves a terminal's cursor, breaks a line, or shows letters in another order."""

_KINDS = {"Cc": "control character", "Cs": "half character", "Cf": "bidirectional mark"}


def unsafe_character(text: str, allowed: str = "") -> tuple[int, str] | None:
    r"""Return place and name of the first character that no name may have, None for none.

    Examples
    --------
    >>> unsafe_character("größe 8"), unsafe_character("a\nb"), unsafe_character("a\nb", "\n")
    (None, (1, 'the control character U+000A'), None)
    >>> unsafe_character("x\u202e5h.")
    (1, 'the bidirectional mark U+202E')
    """
    for found in _UNSAFE.finditer(text):
        character = found[0]
        if character not in allowed:
            kind = _KINDS.get(unicodedata.category(character), "line break")
            return found.start(), f"the {kind} U+{ord(character):04X}"
    return None


def on_one_line(text: str) -> str:
    r"""Return a name or an argument as it is, escaped where it does not print.

    Examples
    --------
    >>> on_one_line("größe 8"), on_one_line("a\nb\u202e")
    ('größe 8', 'a\\nb\\u202e')
    """
    return "".join(_escaped(character) for character in text)


def printable(text: str) -> str:
    r"""Return a text of several lines, escaped where it does not print.

    Examples
    --------
    >>> printable("a\nb\x1b[2J")
    'a\nb\\x1b[2J'
    """
    return "".join(c if c in "\n\t" else _escaped(c) for c in text.replace("\r\n", "\n"))


def _escaped(character: str) -> str:
    # Spaces of other widths do no harm.
    if character.isprintable() or unicodedata.category(character) == "Zs":
        return character
    return character.encode("unicode_escape").decode()


def suggestion(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that was probably meant, or None.

    Examples
    --------
    >>> suggestion("rnu", ["run", "show"]), suggestion("walk", ["run", "show"])
    ('run', None)
    """
    import difflib

    known = list(known)
    by_case = {entry.lower(): entry for entry in known}
    if word.lower() in by_case:
        return by_case[word.lower()]
    close = difflib.get_close_matches(word, known, n=1, cutoff=0.6)
    return close[0] if close else None


def file_meant(path: Path, first: Collection[str] = ()) -> str:
    """Return the name of the file beside one that is missing which was probably meant.

    Names are compared without their endings; where several files have the same name, one whose
    ending is in ``first`` wins. Empty if there is none.
    """
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.name != path.name]
    except OSError:
        return ""
    names.sort(key=lambda name: (Path(name).suffix in first, name))
    beside = {Path(name).stem: name for name in names}
    return beside.get(suggestion(path.stem, beside) or "", "")
