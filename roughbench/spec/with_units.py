"""Specs with units: every length, wavevector and pressure has one, or none has.

A spec with units says its modulus, and may give wavelengths in place of wavevectors. What it
says is kept as it was written; pydantic is given wavevectors.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, get_args

from pydantic import BaseModel

from roughbench.errors import ModelError
from roughbench.models.dimensional import dimension_of
from roughbench.models.registry import Catalog
from roughbench.spec.modulus import Body, ContactModulus
from roughbench.spec.pressures import PressureRange
from roughbench.spec.surfaces import Surface
from roughbench.spec.tree import (
    Finding,
    KeyPath,
    KeyPathError,
    lookup,
    render,
    resolve,
    show,
)
from roughbench.spec.wavelengths import WAVELENGTHS, as_wavevectors, with_wavevector
from roughbench.units import EXAMPLES, Dimension, begins_with_number


@dataclass(frozen=True, slots=True)
class Spelled:
    """A spec's tree, with wavevectors for wavelengths.

    Attributes
    ----------
    tree : mapping
        For pydantic.
    has_units : bool
    findings : list of Finding
        Where units are mixed, missing or cannot be read.
    written : mapping of KeyPath to KeyPath
        Key path of a wavevector → of the wavelength that it was written as.
    dimensional : frozenset of KeyPath
        Where a value has a dimension.
    """

    tree: Mapping[str, Any]
    has_units: bool
    findings: list[Finding] = field(default_factory=list)
    written: Mapping[KeyPath, KeyPath] = field(default_factory=dict)
    dimensional: frozenset[KeyPath] = frozenset()


class _Dimensional(NamedTuple):
    """A value of a spec that has a dimension."""

    path: KeyPath
    value: Any
    dimension: Dimension

    @property
    def is_bare(self) -> bool:
        return isinstance(self.value, (int, float)) and not isinstance(self.value, bool)

    @property
    def has_unit(self) -> bool:
        return isinstance(self.value, str) and begins_with_number(self.value)


def spelled(tree: Mapping[str, Any], catalog: Catalog) -> Spelled:
    """Return a spec's tree with wavevectors for wavelengths, and what is wrong with its units.

    Parameters
    ----------
    tree : mapping
        As it was written.
    catalog : Catalog
        Of its models.
    """
    surface = tree.get("surface")
    surface = surface if isinstance(surface, Mapping) else {}
    given = [*_dimensional(tree, catalog)]
    united = [one for one in given if one.has_unit]
    says_so = "modulus" in tree or surface.get("kind") == "scan" or "unit" in surface
    if not united and not says_so and not WAVELENGTHS.keys() & surface.keys():
        return Spelled(tree, has_units=False)
    bare = [one for one in given if one.is_bare]
    paths = frozenset(one.path for one in given)
    if len(united) < len(bare) and not says_so:
        findings = [*_too_many(united, bare)]
        return Spelled(tree, has_units=False, findings=findings, dimensional=paths)
    findings = [*_without_unit(bare, united)]
    if "modulus" not in tree:
        findings.append(
            Finding(
                ("modulus",),
                "is missing, which a spec with units needs, such as {E: 2.5 GPa, nu: 0.5}",
                "parent",
            )
        )
    if surface.get("kind") == "file" and "unit" not in surface:
        findings.append(
            Finding(("surface", "unit"), "is missing: that of the heights, as in nm", "parent")
        )
    bodies = tree.get("modulus")
    if isinstance(bodies, list) and len(bodies) == 1:
        message = "has one body in its list; write it without brackets, or add the other"
        findings.append(Finding(("modulus",), message))
    replaced, wrong = as_wavevectors(surface)
    for old, new, value in replaced:
        tree = with_wavevector(tree, old, new, value)
    written: dict[KeyPath, KeyPath] = {
        ("surface", new): ("surface", old) for old, new, _ in replaced
    }
    return Spelled(tree, True, findings + wrong, written, paths)  # noqa: FBT003


def in_written_keys(findings: list[Finding], spelling: Spelled) -> list[Finding]:
    """Return the findings on a spelled tree at the keys that were written.

    Where units are mixed or cannot be read, what else is said of such values makes no sense.
    """
    if not spelling.findings:
        there = spelling.written
        return [one._replace(path=there.get(one.path, one.path)) for one in findings]
    wavevectors = {("surface", key) for key in WAVELENGTHS.values()}
    hidden = spelling.dimensional | wavevectors | {("modulus",), ("pressures",)}
    hidden |= {one.path for one in spelling.findings} | {("modulus", 1)}
    return spelling.findings + [one for one in findings if one.path not in hidden]


def _dimensional(tree: Mapping[str, Any], catalog: Catalog) -> Iterator[_Dimensional]:
    """Yield all values that may have a unit, those of a sweep as well."""
    for path in _places(tree):
        dimension = _dimension_at(path, tree, catalog)
        if dimension is not None:
            yield _Dimensional(path, lookup(tree, path), dimension)
    swept = tree.get("sweep")
    for key, values in swept.items() if isinstance(swept, Mapping) else ():
        try:
            dimension = _dimension_at(resolve(tree, key, catalog), tree, catalog)
        except KeyPathError:
            continue
        if dimension is not None and isinstance(values, list):
            for number, value in enumerate(values):
                yield _Dimensional(("sweep", key, number), value, dimension)


def _places(tree: Mapping[str, Any]) -> Iterator[KeyPath]:
    """Yield the key path of every number and text below the keys that may hold dimensions."""

    def below(node: object, path: KeyPath) -> Iterator[KeyPath]:
        if isinstance(node, Mapping):
            for key, value in node.items():
                yield from below(value, (*path, key))
        elif isinstance(node, list):
            for number, value in enumerate(node):
                yield from below(value, (*path, number))
        else:
            yield path

    for key in ("modulus", "surface", "pressures", "save_fields", "models"):
        if key in tree:
            yield from below(tree[key], (key,))


def _dimension_at(path: KeyPath, tree: Mapping[str, Any], catalog: Catalog) -> Dimension | None:
    head, last = path[0], path[-1]
    if head in ("pressures", "save_fields") and isinstance(last, int):
        is_pressure = path in (("pressures", last), ("save_fields", "pressures", last))
        return "pressure" if is_pressure else None
    if not isinstance(last, str):
        return None
    if head == "surface" and len(path) == 2:
        if last in WAVELENGTHS:
            return "length"
        kind = lookup(tree, ("surface", "kind")) or "self-affine"
        return _fields(_surfaces().get(kind)).get(last) if isinstance(kind, str) else None
    if head == "pressures" and len(path) == 2:
        return _fields(PressureRange).get(last)
    if head == "modulus":
        return _fields(Body).get(last) or _fields(ContactModulus).get(last)
    if head == "models" and len(path) == 3:
        try:
            model = catalog.find(str(lookup(tree, (*path[:2], "kind"))))
        except (KeyError, ModelError):
            return None
        return _fields(model).get(last)
    return None


@functools.cache
def _surfaces() -> dict[str, type[BaseModel]]:
    """Return the surfaces by kind."""
    union = get_args(Surface)[0]
    classes = [get_args(one)[0] for one in get_args(union)]
    return {get_args(one.model_fields["kind"].annotation)[0]: one for one in classes}


@functools.cache
def _fields(owner: type[BaseModel] | None) -> dict[str, Dimension]:
    """Return the dimensions of the keys of a mapping."""
    found = owner.model_fields.items() if owner else ()
    return {
        entry.alias or name: dimension
        for name, entry in found
        if (dimension := dimension_of(entry)) is not None
    }


def _too_many(united: list[_Dimensional], bare: list[_Dimensional]) -> Iterator[Finding]:
    """Yield the few values with a unit, of a spec that otherwise has none."""
    for one in united:
        yield Finding(
            one.path,
            f"has a unit, {show(one.value)}, but {render(bare[0].path)} has none; "
            "give all lengths, wavevectors and pressures a unit, or none",
        )


def _without_unit(bare: list[_Dimensional], united: list[_Dimensional]) -> Iterator[Finding]:
    """Yield the values without a unit, of a spec with units."""
    beside = f", but {render(united[0].path)} has one" if united else " in a spec with units"
    for one in bare:
        example = EXAMPLES[one.dimension]
        yield Finding(
            one.path, f"has no unit{beside}, got {show(one.value)}; write it as in '{example}'"
        )
