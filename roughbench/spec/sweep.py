"""A sweep: key paths with lists of values, expanded into one tree per combination."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from roughbench.models.registry import Catalog
from roughbench.spec.tree import (
    Finding,
    KeyPath,
    KeyPathError,
    assign,
    lookup,
    render,
    resolve,
    show,
)
from roughbench.units import is_quantity

MAX_EXPERIMENTS = 1000


class Variant(NamedTuple):
    """One combination of swept values.

    Attributes
    ----------
    tree : dict
        The spec with the values in their places, without the sweep.
    choices : tuple of (str, int, tuple)
        Key path as written, number of the value, key path in the tree.
    """

    tree: dict[str, Any]
    choices: tuple[tuple[str, int, KeyPath], ...]


def check(tree: Mapping[str, Any], catalog: Catalog) -> list[Finding]:
    """Return what is wrong with the sweep itself, whatever its values do."""
    given = tree.get("sweep", {})
    if not isinstance(given, Mapping):
        return [
            Finding(("sweep",), f"must map key paths to lists of values, got {show(given)}")
        ]
    findings = []
    targets: dict[KeyPath, str] = {}
    for key, values in given.items():
        try:
            target = resolve(tree, key, catalog)
        except KeyPathError as error:
            findings.append(Finding(("sweep", key), str(error), "key"))
        else:
            if target[0] in ("name", "sweep"):
                findings.append(Finding(("sweep", key), f"{target[0]} cannot vary", "key"))
            if target in targets:
                message = f"means the same as {targets[target]!r}; remove one of them"
                findings.append(Finding(("sweep", key), message, "key"))
            targets[target] = key
        findings += _check_values(key, values)
    if not findings:
        count = math.prod(len(values) for values in given.values())
        if count > MAX_EXPERIMENTS:
            message = f"makes {count} experiments, at most {MAX_EXPERIMENTS} are allowed"
            findings.append(Finding(("sweep",), message, "key"))
    return findings


def _check_values(key: str, values: object) -> Iterator[Finding]:
    if not isinstance(values, list) or not values:
        got = "an empty list" if values == [] else show(values)
        yield Finding(("sweep", key), f"must be a list of values, got {got}")
        return
    seen = set()
    for number, value in enumerate(values):
        if isinstance(value, (Mapping, list)):
            message = f"must be a number or a word, got {show(value)}"
            yield Finding(("sweep", key, number), message)
        elif (isinstance(value, bool), value) in seen:
            yield Finding(("sweep", key, number), f"{show(value)} stands in this list already")
        else:
            seen.add((isinstance(value, bool), value))


def variants(tree: Mapping[str, Any], catalog: Catalog) -> Iterator[Variant]:
    """Yield every combination of a sweep without faults, the last key fastest."""
    swept: Mapping[str, Sequence[object]] = tree["sweep"]
    base = {key: value for key, value in tree.items() if key != "sweep"}
    targets = [resolve(tree, key, catalog) for key in swept]
    for numbers in itertools.product(*(range(len(values)) for values in swept.values())):
        choices = tuple(zip(swept, numbers, targets, strict=True))
        varied = base
        for key, number, target in choices:
            varied = assign(varied, target, swept[key][number])
        yield Variant(varied, choices)


def names(resolved: Sequence[tuple[Variant, Mapping[str, Any]]]) -> list[str]:
    """Return a name for each experiment, such as ``surface.qr=8.0``.

    The values are taken from the resolved trees, so that 8 and 8.0 give the same name;
    only letters that are safe in an HDF5 group's name are kept.
    """
    used: dict[str, None] = {}
    for variant, tree in resolved:
        text = ",".join(
            f"{key}={_word(_value(variant, tree, path))}" for key, _, path in variant.choices
        )
        name = plain = re.sub(r"[^A-Za-z0-9_.,=+\[\]-]", "_", text)
        number = 1
        while name in used:
            number += 1
            name = f"{plain}_{number}"
        used[name] = None
    return [*used]


def _value(variant: Variant, resolved: Mapping[str, Any], path: KeyPath) -> object:
    written = lookup(variant.tree, path)
    if is_quantity(written):
        return _compact(str(written))
    value = lookup(resolved, path)
    # Defaults may be left out of a resolved tree: of these the spec itself tells.
    return written if value is None else value


def _compact(quantity: str) -> str:
    """Write a number with its unit in letters of a name: 0.1um-1 for 0.1 / µm."""
    number, slash, unit = quantity.replace("µ", "u").replace("μ", "u").partition("/")
    below = re.fullmatch(r"\s*([\d.eE+-]+)(?:\s+1)?\s*", number) if slash else None
    text = f"{below[1]}{unit.strip()}-1" if below else f"{number}{slash}{unit}"
    return text.replace(" ", "").replace("/", "_per_")


def _word(value: object) -> str:
    return value if isinstance(value, str) else show(value)


def blame(finding: Finding, variant: Variant) -> Finding:
    """Return a finding in a variant as a fault of the swept value nearest to it."""

    def nearness(choice: tuple[str, int, KeyPath]) -> int:
        pairs = zip(choice[2], finding.path, strict=False)
        return len([*itertools.takewhile(lambda pair: pair[0] == pair[1], pairs)])

    key, number, path = max(variant.choices, key=nearness)
    if finding.path != path:
        return Finding(("sweep", key, number), f"{render(finding.path)}: {finding.message}")
    if finding.at == "key":
        return Finding(("sweep", key), finding.message, "key")
    return Finding(("sweep", key, number), finding.message)
