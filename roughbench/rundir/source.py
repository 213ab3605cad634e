"""What a source file computes, as a digest: blind to words, comments and layout.

Two texts have the same digest if their syntax trees are the same but for docstrings, other
statements that are strings alone, descriptions of options, title, style
and page of a class, and positions. The tree is written
down here rather than by :func:`ast.dump`, whose text differs between versions of Python; what
a version leaves out when it is empty (``type_params`` since 3.12) is left out everywhere.
"""

from __future__ import annotations

import ast
import hashlib

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
    pieces: list[str] = []
    _write(_tree(text), pieces)
    return hashlib.sha256("".join(pieces).encode()).hexdigest()


def imported(text: str) -> set[str]:
    """Return every dotted name that a module imports, or may mean by an import.

    Examples
    --------
    >>> sorted(imported("import numpy as np; from roughbench.models import base"))
    ['numpy', 'roughbench.models', 'roughbench.models.base']
    >>> sorted(imported("import roughbench as rb; rb.solve_curve"))
    ['roughbench', 'roughbench.solve_curve']
    """
    names: set[str] = set()
    tree = ast.parse(text)
    bound: set[str] = set()  # names of the package itself
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
            bound.update(a.asname or a.name for a in node.names if a.name == "roughbench")
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    for node in ast.walk(tree):
        if not isinstance(node, ast.Attribute) or not isinstance(node.value, ast.Name):
            continue
        if node.value.id in bound:
            names.add(f"roughbench.{node.attr}")
    return names


def _write(value: object, pieces: list[str]) -> None:
    """Add a tree as text in brackets, which no two different trees share."""
    if isinstance(value, ast.AST):
        if isinstance(value, ast.ClassDef):
            value.body = [part for part in value.body if not _is_declared(part)]
        pieces.append(f"{type(value).__name__}(")
        for name, part in ast.iter_fields(value):
            if name not in _IMMATERIAL and part is not None and part != []:
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
        pieces.append(f"{type(value).__name__}:{value!r},")


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


def _tree(text: str) -> ast.Module:
    """Return the tree of a module, without what Python 3.12 adds to its f-strings."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            node.values = [part for part in node.values if not _is_empty(part)]
    return tree


def _is_empty(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value == ""
