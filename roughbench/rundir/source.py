"""What a source file computes, as a digest: blind to words, comments and layout.

Two texts have the same digest if their syntax trees are the same but for docstrings, other
statements that are strings alone, descriptions of options, title, style
and page of a class, and positions. The tree is written
down here rather than by :func:`ast.dump`, whose text differs between versions of Python; what
a version leaves out when it is empty (``type_params`` since 3.12) is left out everywhere.
"""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterator

_IMMATERIAL = {"ctx", "kind", "type_comment", "type_ignores"}
"""Fields that say nothing more than the rest: loads or stores, u-prefixes, comments."""
_DECLARED = {"title", "style", "page"}
"""Of a class: what is not for numbers."""


def digest(text: str) -> str:
    """Return a digest of what a module computes, 64 hexadecimal digits.

    Examples
    --------
    >>> digest("x = 1  # one") == digest("'Numbers.'; x = (1)")
    True
    >>> digest("x = 1") == digest("x = 2")
    False
    """
    return _read(text)[0]


def imported(text: str) -> frozenset[str]:
    """Return every dotted name that a module imports, or may mean by an import.

    Examples
    --------
    >>> sorted(imported("import numpy as np; from roughbench.models import base"))
    ['numpy', 'roughbench.models', 'roughbench.models.base']
    >>> sorted(imported("import roughbench as rb; rb.solve_curve"))
    ['roughbench', 'roughbench.solve_curve']
    """
    return _read(text)[1]


@functools.lru_cache(maxsize=512)
def _read(text: str) -> tuple[str, frozenset[str]]:
    """Return digest and imported names; kept, as most models share most modules."""
    tree = ast.parse(text)
    names = frozenset(_imported(tree))
    pieces: list[str] = []
    _write(tree, pieces)
    return hashlib.sha256("".join(pieces).encode()).hexdigest(), names


def _imported(tree: ast.Module) -> set[str]:
    names: set[str] = set()
    bound: set[str] = set()  # names of the package itself
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
            bound.update(a.asname or a.name for a in node.names if a.name == "roughbench")
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    for node in ast.walk(tree) if bound else ():
        if not isinstance(node, ast.Attribute) or not isinstance(node.value, ast.Name):
            continue
        if node.value.id in bound:
            names.add(f"roughbench.{node.attr}")
    return names


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what may be or hold a statement: no expression does."""
    for name in ("body", "orelse", "finalbody", "handlers", "cases"):
        parts = getattr(node, name, ())
        for part in parts if isinstance(parts, list) else ():
            yield part
            yield from _statements(part)


def _write(value: object, pieces: list[str]) -> None:
    """Add a tree as text in brackets, which no two different trees share."""
    kind = type(value)
    if isinstance(value, ast.AST):
        if isinstance(value, ast.ClassDef):
            value.body = [part for part in value.body if not _is_declared(part)]
        elif isinstance(value, ast.JoinedStr):  # with what Python 3.12 adds to it
            value.values = [part for part in value.values if not _is_empty(part)]
        pieces.append(f"{kind.__name__}(")
        for name in kind._fields:  # type: ignore[attr-defined]
            if name in _IMMATERIAL:
                continue
            part = getattr(value, name, None)
            if part is not None and part != []:
                pieces.append(f"{name}=")
                _write(part, pieces)
        pieces.append(")")
    elif isinstance(value, list):
        pieces.append("[")
        for part in value:
            if not _is_words(part):
                _write(part, pieces)
        pieces.append("]")
    else:
        pieces.append(f"{kind.__name__}:{value!r},")


def _is_declared(node: object) -> bool:
    """Whether a statement in a class says how a model is called and drawn."""
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    is_assignment = isinstance(node, ast.Assign | ast.AnnAssign)
    names = {target.id for target in targets if isinstance(target, ast.Name)}
    return is_assignment and bool(names) and names <= _DECLARED


def _is_words(node: object) -> bool:
    """Whether a node is there for people: a string that nobody uses, or a description."""
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    return isinstance(node, ast.keyword) and node.arg == "description"


def _is_empty(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value == ""
