"""Pydantic's findings in the words of the spec: what is wrong, what was given, what to do."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping
from typing import Any, Literal

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from roughbench.errors import ModelError
from roughbench.models.registry import Catalog
from roughbench.spec.measured import FileSurface, ScanSurface
from roughbench.spec.model import Spec
from roughbench.spec.modulus import Body, ContactModulus
from roughbench.spec.pressures import PressureRange
from roughbench.spec.surfaces import SelfAffineSurface
from roughbench.spec.tree import Finding, KeyPath, did_you_mean, lookup, render, show
from roughbench.spec.wavelengths import OF_WAVES, WAVELENGTHS
from roughbench.text import suggestion

SURFACES: dict[str, type[BaseModel]] = {
    "self-affine": SelfAffineSurface,
    "file": FileSurface,
    "scan": ScanSurface,
}

_BOUNDS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}
_TYPES = {
    "float_type": "a number",
    "bool_type": "true or false",
    "string_type": "text",
    "tuple_type": "a list",
    "model_type": "a mapping",
}


def translate(error: ErrorDetails, tree: Any, catalog: Catalog) -> Finding | None:
    """Return one of pydantic's errors as a finding, None if it only follows from others.

    Parameters
    ----------
    error : ErrorDetails
        Of the validation of :class:`Spec`.
    tree : dict
        What was validated.
    catalog : Catalog
        Of its models.
    """
    path, kind, context = _path(error["loc"]), error["type"], error.get("ctx", {})
    if isinstance(written := lookup(tree, path), str):  # a number with its unit, by now in SI
        error = {**error, "input": written}
    if kind == "default_factory_not_called" or (kind == "too_short" and error["input"]):
        return None
    if kind == "parent":
        return Finding(path[:-1], error["msg"], "key")
    if kind in ("child", "missing_child"):
        at: Literal["value", "parent"] = "value" if kind == "child" else "parent"
        return Finding((*path, context["part"]), error["msg"], at)
    if kind == "extra_forbidden":
        return Finding(path, f"unknown key{_known_keys(path, tree, catalog)}", "key")
    if kind == "missing":
        return Finding(path, f"is missing{_description(path, tree, catalog)}", "parent")
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _wrong_form(path, error["input"])
    return Finding(path, _value_message(error, _most(path, tree, catalog)))


def _most(path: KeyPath, tree: Any, catalog: Catalog) -> int | None:
    """Return the largest integer that may stand at ``path``, if there is one."""
    entry = fields_at(path[:-1], tree, catalog).get(str(path[-1])) if path else None
    bounds = [getattr(rule, "le", None) for rule in entry[1].metadata] if entry else []
    return next((bound for bound in bounds if isinstance(bound, int)), None)


def _value_message(error: ErrorDetails, most: int | None) -> str:
    kind, context = error["type"], error.get("ctx", {})
    got = error["input"]
    if kind in _BOUNDS:
        word, key = _BOUNDS[kind]
        bound = context[key]
        shown = str(bound) if isinstance(bound, int) else f"{bound:g}"
        return f"must be {word} {shown}, got {show(got)}"
    if kind in _TYPES:
        return f"must be {_TYPES[kind]}, got {show(got)}{_with_point(got)}"
    if kind == "int_type":
        whole = isinstance(got, float) and got.is_integer()
        if whole and most is not None and got > most:
            return f"must be at most {most}, got {show(got)}"
        return f"must be an integer, got {show(got)}" + (
            f" (write {int(got)})" if whole else ""
        )
    if kind == "literal_error":
        return _choice(context["expected"], got)
    if kind == "string_pattern_mismatch":
        letters = "a letter or digit first, then letters, digits and any of _.+-"
        return f"must have {letters}, got {show(got)}"
    if kind in ("too_short", "string_too_short"):
        return "must not be empty"
    if kind in ("too_long", "string_too_long"):
        things = "entries" if kind == "too_long" else "characters"
        return f"must have at most {context['max_length']} {things}"
    if kind == "value_error":  # raised by our own validators
        return str(context["error"])
    message = error["msg"][:1].lower() + error["msg"][1:]
    return f"{message}, got {show(got)}"


def without_echoes(findings: list[Finding], tree: Any, catalog: Catalog) -> list[Finding]:
    """Leave out the missing keys that only miss because they are misspelt."""
    meant = set()
    for finding in findings:
        if finding.message.startswith("unknown key"):
            *parent, word = finding.path
            near = _meant(str(word), fields_at(tuple(parent), tree, catalog))
            meant.add((*parent, WAVELENGTHS.get(near or "", near)))
    scales = {(*path[:-1],) for path in meant if path[-1] in ("slope", "rms_height")}
    return [
        finding
        for finding in findings
        if not (finding.at == "parent" and finding.path in meant)
        and not (finding.path in scales and finding.message.endswith("got none"))
    ]


def fields_at(path: KeyPath, tree: Any, catalog: Catalog) -> dict[str, tuple[str, FieldInfo]]:
    """Return the fields of the mapping at ``path``: name in the spec → name, field."""
    owner: type[BaseModel] | None = None
    if path == ():
        owner = Spec
    elif path == ("surface",):
        owner = SURFACES.get(lookup(tree, ("surface", "kind")) or "self-affine")
    elif path == ("pressures",):
        owner = PressureRange
    elif path[:1] == ("modulus",):
        contact = "E*" in (lookup(tree, ("modulus",)) or ())
        owner = ContactModulus if contact else Body
    elif len(path) == 2 and path[0] == "models":
        with contextlib.suppress(KeyError, ModelError):
            owner = catalog.find(str(lookup(tree, (*path, "kind"))))
    fields = owner.model_fields if owner else {}
    found = {field.alias or name: (name, field) for name, field in fields.items()}
    if owner is SelfAffineSurface:
        found |= {key: (key, FieldInfo(description=words)) for key, words in OF_WAVES.items()}
    return found


def _path(loc: tuple[str | int, ...]) -> KeyPath:
    """Leave out the names of union members, which pydantic puts into the location."""
    if loc[:1] in (("surface",), ("pressures",), ("modulus",)):
        return loc[:1] + loc[2:]
    if loc[:1] == ("models",) and loc[3:] in (("word",), ("number",)):
        return loc[:3]
    return loc


def _wrong_form(path: KeyPath, got: Any) -> Finding:
    if path == ("pressures",):
        forms = "a list, or a mapping with min, max and points"
        return Finding(path, f"must be {forms}, got {show(got)}")
    if path == ("modulus",):
        forms = "{E: 2.5 GPa, nu: 0.5}, a list of two bodies, or {E*: 3.33 GPa}"
        return Finding(path, f"must be {forms}, got {show(got)}")
    if not isinstance(got, Mapping):
        return Finding(path, f"must be a mapping, got {show(got)}")
    known = [*SURFACES]
    path = (*path, "kind")
    if not isinstance(got["kind"], str):
        return Finding(path, f"must be one of {', '.join(known)}, got {show(got['kind'])}")
    return Finding(path, f"unknown kind {show(got['kind'])}{did_you_mean(got['kind'], known)}")


def _meant(word: str, fields: Mapping[str, tuple[str, FieldInfo]]) -> str | None:
    """Words of the Python interface, such as ``hurst``, lead to those of the spec."""
    candidates = {alias: alias for alias in fields}
    candidates |= {name: alias for alias, (name, _) in fields.items()}
    near = suggestion(word, candidates)
    return candidates[near] if near else None


def _with_point(got: object) -> str:
    """Return how a number with a decimal comma is written in YAML."""
    if isinstance(got, str) and re.fullmatch(r"[-+]?\d+,\d+(e[-+]?\d+)?", got, re.IGNORECASE):
        return f" (write {got.replace(',', '.')}, with a point)"
    return ""


def _known_keys(path: KeyPath, tree: Any, catalog: Catalog) -> str:
    word = str(path[-1])
    if re.match(r"\d", word):  # {min: 1,0e-5}
        return "; a comma begins another key: numbers are written with a point"
    fields = fields_at(path[:-1], tree, catalog)
    if near := _meant(word, fields):
        return f" (did you mean {near!r}?)"
    if place := _elsewhere(word, path[:-1], tree, catalog):
        owner = render(place[:-1]) or "the top of the spec"
        return f"; it belongs to {owner}, as {render(place)}"
    return f"; known here: {', '.join(fields)}"


def _elsewhere(word: str, here: KeyPath, tree: Any, catalog: Catalog) -> KeyPath | None:
    """Return where in the spec this key would be known, if there is one such place."""
    models = lookup(tree, ("models",))
    places: list[KeyPath] = [(), ("surface",), ("pressures",), ("modulus",)]
    places += [("models", n) for n in range(len(models) if isinstance(models, list) else 0)]
    found = [place for place in places if word in fields_at(place, tree, catalog)]
    kinds = {str(place[:1]) for place in found}
    return (*found[0], word) if here not in found and len(kinds) == 1 else None


def _description(path: KeyPath, tree: Any, catalog: Catalog) -> str:
    entry = fields_at(path[:-1], tree, catalog).get(str(path[-1]))
    return f" ({entry[1].description.rstrip('.')})" if entry and entry[1].description else ""


def _choice(expected: str, got: Any) -> str:
    choices = re.findall(r"'([^']*)'", expected)
    near = suggestion(got, choices) if isinstance(got, str) else None
    return f"must be {' or '.join(choices)}, got {show(got)}" + (
        f" (did you mean {near!r}?)" if near else ""
    )
