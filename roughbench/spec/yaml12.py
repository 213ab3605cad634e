"""PyYAML with the scalars of YAML 1.2: ``1e5`` is a number, ``no`` is a word.

PyYAML follows YAML 1.1, where ``1e5`` is text, ``010`` is 8, ``12:30:45`` is 45045 and
``no`` is false. Reader and writer below share one table of scalars instead, that of the
YAML 1.2 core schema (YAML 1.2.2, chapter 10.3.2), so that what is written reads back.
"""

from __future__ import annotations

import math
import re

import yaml

_NULL, _BOOL = "tag:yaml.org,2002:null", "tag:yaml.org,2002:bool"
_INT, _FLOAT = "tag:yaml.org,2002:int", "tag:yaml.org,2002:float"

_CORE_SCHEMA: tuple[tuple[str, str], ...] = (
    (_NULL, r"null|Null|NULL|~|"),
    (_BOOL, r"true|True|TRUE|false|False|FALSE"),
    (_INT, r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+"),
    (_FLOAT, r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?"),
    (_FLOAT, r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)"),
    ("tag:yaml.org,2002:merge", "<<"),  # so that it is written in quotes
)
# PyYAML looks resolvers up by the first character; None is tried for every scalar.
_RESOLVERS: dict[str | None, list[tuple[str, re.Pattern[str]]]] = {
    None: [(tag, re.compile(rf"(?:{pattern})\Z")) for tag, pattern in _CORE_SCHEMA]
}


class Loader(yaml.SafeLoader):
    """PyYAML's scanner and parser; plain scalars resolve as in YAML 1.2."""

    yaml_implicit_resolvers = _RESOLVERS

    def value(self, event: yaml.ScalarEvent) -> str | int | float | bool | None:
        """Return the value of a scalar without a tag.

        Raises
        ------
        ValueError
            If the number does not fit: an infinity, a NaN, an endless integer, or one that
            would be rounded to zero.
        """
        tag = self.resolve(yaml.ScalarNode, event.value, event.implicit)  # type: ignore[no-untyped-call]
        text: str = event.value
        if tag == _NULL:
            return None
        if tag == _BOOL:
            return text.lower() == "true"
        if tag == _INT:
            base = {"0o": 8, "0x": 16}.get(text[:2], 10)
            number = int(text, base) if len(text) < 40 else 2**63
            if abs(number) >= 2**63:
                raise ValueError(f"must be an integer below 2**63, got {text[:40]}")
            return number
        if tag == _FLOAT:
            if "n" in text.lower() or not math.isfinite(float(text)):
                raise ValueError(f"must be a finite number, got {text[:40]}")
            real = float(text)
            if real == 0.0 and re.match(r"[-+.0]*[1-9]", text):
                raise ValueError(f"must be 0 or at least 5e-324 in size, got {text[:40]}")
            return real
        return text


class _Dumper(yaml.SafeDumper):
    """Quotes what YAML 1.2 would read as a number, and writes no aliases."""

    yaml_implicit_resolvers = _RESOLVERS

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002 (PyYAML's signature)
        return True


def dump(tree: object) -> str:
    """Return ``tree`` as YAML 1.2 text, keys in their order, floats to the last digit."""
    # PyYAML writes U+0085 unquoted where Unicode is allowed, and reads it as a line break.
    text: str = yaml.dump(
        tree, Dumper=_Dumper, sort_keys=False, allow_unicode=False, default_flow_style=None
    )
    return text
