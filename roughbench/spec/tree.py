"""The plain tree behind a spec, the key paths into it, and what is wrong at them.

A tree holds what YAML can say: dicts with text keys, lists, text, finite numbers,
booleans and None. A key path such as ``models[0].gamma`` is a tuple in the code.
"""

from __future__ import annotations

import math
import numbers
import os
import re
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from roughbench.models.registry import Catalog
from roughbench.text import suggestion, unsafe_character

KeyPath = tuple[str | int, ...]

_INSTALLED = Catalog()
MAX_DEPTH = 16
MAX_NODES = 50_000


class Finding(NamedTuple):
    """One fault, not yet placed in a file."""

    path: KeyPath
    message: str
    at: Literal["value", "key", "parent"] = "value"


class KeyPathError(Exception):
    """A key path that leads nowhere; the message says what to write instead."""


def render(path: KeyPath) -> str:
    """Write a key path as users do.

    Examples
    --------
    >>> render(("models", 0, "gamma"))
    'models[0].gamma'
    """
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            word = part if part and part.isprintable() and len(part) <= 60 else show(part)
            text += f".{word}" if text else word
    return text


def show(value: object) -> str:
    """Write a received value for a message: YAML's words, short, on one line."""
    if isinstance(value, Mapping):
        return "a mapping"
    if isinstance(value, (list, tuple)):
        return "a list"
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    text = ascii(value) if isinstance(value, str) and not value.isprintable() else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def did_you_mean(word: str, known: Sequence[str]) -> str:
    """Return `` (did you mean 'x'?)``, or a list of what is known."""
    near = suggestion(word, known)
    if near is not None:
        return f" (did you mean {near!r}?)"
    return f"; known here: {', '.join(known)}" if known else ""


def resolve(tree: Mapping[str, Any], text: str, catalog: Catalog = _INSTALLED) -> KeyPath:
    """Return the key path that ``text`` stands for; only its last key may be new.

    Models are found by number or by name: ``models[0].gamma``, ``models.persson.gamma``. The
    catalog knows the kind of a model in a file, which is its name unless it has a label.

    Raises
    ------
    KeyPathError
        If the path is not written as one, or leads nowhere.

    Examples
    --------
    >>> resolve({"models": [{"kind": "bem"}, {"kind": "persson"}]}, "models.persson.gamma")
    ('models', 1, 'gamma')
    """
    head, _, rest = text.partition(".")
    if head == "sweep" and rest:
        if not isinstance(tree.get("sweep") or {}, Mapping):
            raise KeyPathError("sweep must map key paths to lists of values")
        return ("sweep", rest)
    path = _model_by_name(tree, rest, catalog) if head == "models" and rest else _parse(text)
    node: Any = tree
    for depth, part in enumerate(path):
        here = render(path[:depth]) or "the spec"
        last = depth == len(path) - 1
        if isinstance(part, str):
            if not isinstance(node, Mapping):
                raise KeyPathError(f"{here} is {_kind(node)} and has no keys")
            if part not in node and not last:
                raise KeyPathError(f"{here} has no key {part!r}{did_you_mean(part, [*node])}")
            node = node.get(part)
        else:
            if not isinstance(node, list):
                raise KeyPathError(f"{here} is {_kind(node)} and has no entry [{part}]")
            if part >= len(node):
                last_entry = f"; the last is [{len(node) - 1}]" if node else ", it is empty"
                raise KeyPathError(f"{here} has no entry [{part}]{last_entry}")
            node = node[part]
    return path


def assign(tree: Any, path: KeyPath, value: object) -> Any:
    """Return a copy of ``tree`` with ``value`` at ``path`` (see :func:`resolve`)."""
    if not path:
        return value
    head, rest = path[0], path[1:]
    if isinstance(head, int):
        return [assign(v, rest, value) if i == head else v for i, v in enumerate(tree)]
    tree = tree or {}
    return {**tree, head: assign(tree.get(head), rest, value)}


def lookup(tree: Any, path: KeyPath) -> Any:
    """Return what stands at ``path``, or None.

    Examples
    --------
    >>> lookup({"models": [{"kind": "bem"}]}, ("models", 0, "kind"))
    'bem'
    >>> lookup({"models": 3}, ("models", 0, "kind")) is None
    True
    """
    for part in path:
        if isinstance(tree, Mapping):
            tree = tree.get(part)
        elif isinstance(tree, (list, tuple)) and isinstance(part, int) and part < len(tree):
            tree = tree[part]
        else:
            return None
    return tree


def freeze(tree: Any) -> Any:
    """Return ``tree`` with tuples for lists, as the strict models want it."""
    if isinstance(tree, Mapping):
        return {key: freeze(value) for key, value in tree.items()}
    return tuple(freeze(value) for value in tree) if isinstance(tree, list) else tree


def plain(value: object) -> tuple[Any, list[Finding]]:
    """Return a Python object as a tree: tuples, arrays, NumPy numbers, paths converted."""
    findings: list[Finding] = []
    nodes = 0

    def convert(value: object, path: KeyPath) -> Any:
        nonlocal nodes
        nodes += 1
        if len(path) > MAX_DEPTH or nodes > MAX_NODES:
            if not any(finding.path == () for finding in findings):
                findings.append(Finding((), f"nested too deep, or over {MAX_NODES} entries"))
            return None
        if isinstance(value, np.ndarray):
            value = value.tolist()
        if isinstance(value, os.PathLike):
            value = os.fspath(value)
        if isinstance(value, Mapping):
            findings.extend(
                Finding(path, f"keys must be text that prints, got {show(key)}")
                for key in value
                if not isinstance(key, str) or unsafe_character(key)
            )
            return {str(key): convert(entry, (*path, str(key))) for key, entry in value.items()}
        if isinstance(value, (list, tuple)):
            return [convert(entry, (*path, i)) for i, entry in enumerate(value)]
        if value is None or isinstance(value, (bool, np.bool_)):
            return value if value is None else bool(value)
        if isinstance(value, str):
            unsafe = unsafe_character(value)
            if unsafe is not None:
                findings.append(Finding(path, f"holds {unsafe[1]}; remove it"))
                return ""
            return str(value)
        if isinstance(value, numbers.Integral) and abs(int(value)) < 2**63:
            return int(value)
        if isinstance(value, numbers.Real) and not isinstance(value, numbers.Integral):
            if math.isfinite(value):
                return float(value)
            findings.append(Finding(path, f"must be a finite number, got {show(float(value))}"))
        elif isinstance(value, numbers.Integral):
            findings.append(Finding(path, "must be an integer below 2**63"))
        else:
            findings.append(
                Finding(path, f"a spec cannot hold a Python {type(value).__name__}")
            )
        return None

    return convert(value, ()), findings


def _kind(node: object) -> str:
    return {dict: "a mapping", list: "a list", type(None): "empty"}.get(type(node), show(node))


def _parse(text: str) -> KeyPath:
    if not re.fullmatch(r"[^.\[\]]+(\[\d{1,9}\])*(\.[^.\[\]]+(\[\d{1,9}\])*)*", text):
        raise KeyPathError(
            f"{show(text)} is no key path; write it like surface.H or models[0].grid"
        )
    return tuple(
        int(part[1:-1]) if part.startswith("[") else part
        for part in re.findall(r"\[\d+\]|[^.\[\]]+", text)
    )


def _model_by_name(tree: Mapping[str, Any], rest: str, catalog: Catalog) -> KeyPath:
    """Labels may hold dots, so the longest name that fits wins."""
    models = tree.get("models")
    names: dict[str, int] = {}
    for number, model in enumerate(models if isinstance(models, list) else ()):
        if not isinstance(model, dict):
            continue
        name, kind = model.get("label"), model.get("kind")
        if not name and isinstance(kind, str):
            name = catalog.own_kind(kind)
        if isinstance(name, str):
            names.setdefault(name, number)
    for name in sorted(names, key=len, reverse=True):
        if rest == name:
            return ("models", names[name])
        if rest.startswith(f"{name}."):
            return ("models", names[name], *_parse(rest.removeprefix(f"{name}.")))
    word = rest.partition(".")[0]
    raise KeyPathError(f"models has no {word!r}{did_you_mean(word, [*names])}")
