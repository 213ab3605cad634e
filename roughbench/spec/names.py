"""The name of a spec that gives itself none: that of its file, as far as its letters allow."""

from __future__ import annotations

import re
import unicodedata

LONGEST = 100
_LETTER = re.compile(r"\b(?:SMALL|CAPITAL)? ?LETTER (?:FINAL )?([A-Z]{1,12})\b")


def default_name(stem: str) -> str:
    """Return the name of a file in letters that names of specs have.

    Examples
    --------
    >>> default_name("my spec ξ"), default_name("größe_8"), default_name("_plate")
    ('my_spec_xi', 'grosse_8', 'plate')
    >>> default_name("表面"), default_name("...")
    ('u8868u9762', 'spec')
    """
    text = "".join(_latin(letter) for letter in unicodedata.normalize("NFC", stem))
    return re.sub(r"^[^A-Za-z0-9]+", "", text)[:LONGEST] or "spec"


def _latin(letter: str) -> str:
    if re.fullmatch(r"[A-Za-z0-9_.+-]", letter):
        return letter
    plain = unicodedata.normalize("NFKD", letter.replace("ß", "ss")).encode("ascii", "ignore")
    if re.fullmatch(rb"[A-Za-z0-9]+", plain):
        return plain.decode()
    if not letter.isalnum():
        return "_"
    named = _LETTER.search(unicodedata.name(letter, ""))
    return named[1].lower() if named else f"u{ord(letter):x}"
