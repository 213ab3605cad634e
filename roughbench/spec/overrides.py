"""``--set key=value``: single values of a spec, given on the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from roughbench.errors import Fault
from roughbench.models.registry import Catalog
from roughbench.spec.reading import read_yaml
from roughbench.spec.tree import KeyPath, KeyPathError, assign, render, resolve
from roughbench.text import on_one_line

_INSTALLED = Catalog()


def apply_overrides(
    tree: Mapping[str, Any], overrides: Sequence[str], catalog: Catalog = _INSTALLED
) -> tuple[Any, dict[KeyPath, str], list[Fault]]:
    """Return the tree with the overrides, which of them set what, and their faults.

    Parameters
    ----------
    tree : dict
        What the spec says.
    overrides : sequence of str
        Each ``key=value``: a key path such as ``surface.H``, ``models[0].grid`` or
        ``models.bem.grid``, and a YAML value such as ``0.8`` or ``[1.0e-4, 0.1]``.
    catalog : Catalog
        Of the models.

    Examples
    --------
    >>> apply_overrides({"surface": {"H": 0.7}}, ["surface.H=0.8"])
    ({'surface': {'H': 0.8}}, {('surface', 'H'): '--set surface.H=0.8'}, [])
    """
    faults: list[Fault] = []
    sources: dict[KeyPath, str] = {}
    for override in overrides:
        source = f"--set {on_one_line(override)}"
        key, equals, text = override.partition("=")
        if not equals:
            faults.append(Fault("must read key=value, such as surface.H=0.8", source=source))
            continue
        document = read_yaml(text)
        faults += [
            Fault(fault.message, on_one_line(key), source=source) for fault in document.faults
        ]
        try:
            path = resolve(tree, key.strip(), catalog)
        except KeyPathError as error:
            faults.append(Fault(str(error), source=source))
            continue
        swept = _swept(tree, path, catalog)
        if swept is not None:
            message = f"the sweep varies this; set sweep.{swept}=[...] or sweep={{}} instead"
            faults.append(Fault(message, render(path), source=source))
            continue
        if not document.faults:
            tree = assign(tree, path, document.tree)
            sources[path] = source
    return tree, sources, faults


def _swept(tree: Mapping[str, Any], path: KeyPath, catalog: Catalog) -> str | None:
    sweep = tree.get("sweep")
    for key in sweep if isinstance(sweep, Mapping) else ():
        try:
            if resolve(tree, key, catalog) == path:
                return str(key)
        except KeyPathError:
            continue
    return None
