"""A spec as it was given made a frozen one, or all its faults, each with its place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from roughbench.errors import Fault, SpecError
from roughbench.models.base import Model
from roughbench.models.registry import Catalog, Unavailable
from roughbench.spec import sweep
from roughbench.spec.checks import check_file, check_fit, check_twins
from roughbench.spec.fields import SavedFields
from roughbench.spec.messages import translate, without_echoes
from roughbench.spec.model import Spec, validated
from roughbench.spec.models import AnyModel, catalog_of
from roughbench.spec.names import default_name
from roughbench.spec.overrides import apply_overrides
from roughbench.spec.pressures import PressureRange, Pressures, values_of
from roughbench.spec.reading import Document, Place
from roughbench.spec.surfaces import AnySurface, Surface
from roughbench.spec.tree import (
    Finding,
    KeyPath,
    freeze,
    render,
)
from roughbench.spec.with_units import in_written_keys, spelled

_SURFACE: TypeAdapter[AnySurface] = TypeAdapter(Surface)
_MODEL: TypeAdapter[Model] = TypeAdapter(AnyModel)
_PRESSURES: TypeAdapter[PressureRange | tuple[float, ...]] = TypeAdapter(Pressures)
_SAVED_FIELDS: TypeAdapter[SavedFields] = TypeAdapter(SavedFields)


@dataclass(slots=True)
class GivenSpec:
    """A spec as it was given, and where each part of it came from."""

    document: Document
    name: str = "spec"
    folder: Path = Path()
    source: str = ""
    text: str | None = None
    overrides: dict[KeyPath, str] = field(default_factory=dict)
    outside: Mapping[str, str] | None = None

    @property
    def context(self) -> dict[str, Any]:
        """What its parts have to know for their validation."""
        return {"folder": self.folder, "catalog": Catalog(self.folder, self.outside)}


def build(given: GivenSpec, overrides: Sequence[str], *, files: bool = True) -> Spec:
    """Return a spec, or raise all its faults.

    Raises
    ------
    SpecError
    """
    document = given.document
    faults = [
        Fault(f.message, render(f.path), f.place.line, f.place.column, given.source)
        for f in document.faults
    ]
    if not document.complete:
        raise SpecError(faults)
    tree = document.tree
    if not isinstance(tree, Mapping):
        got = "is empty" if tree is None else "must be a mapping"
        message = f"{got}; a spec has at least surface, pressures and models"
        if not faults:
            faults.append(fault_at(Finding((), message), given))
        raise SpecError(faults)

    tree, given.overrides, override_faults = apply_overrides(
        tree, overrides, given.context["catalog"]
    )
    tree = {"name": default_name(given.name), **tree}
    text = None if overrides else given.text
    context = given.context
    spec, findings = _validate(tree, context | {"text": text}, files=files)
    findings += _validate_sweep(tree, findings, context, files=files)
    faults += [fault_at(f, given) for f in findings if not _refused(f.path, document.refused)]
    faults.sort(key=lambda fault: (fault.source != given.source, fault.line, fault.column))
    faults += override_faults
    if faults or spec is None:
        raise SpecError(list(dict.fromkeys(faults)))
    return spec


def _validate(
    tree: Any, context: Mapping[str, Any], *, files: bool
) -> tuple[Spec | None, list[Finding]]:
    """Validate one tree; parts that are valid are checked against each other anyway."""
    spec: Spec | None = None
    findings: list[Finding] = []
    catalog = catalog_of(context)
    spelling = spelled(tree, catalog)
    written, tree = tree, spelling.tree
    frozen = freeze(tree)
    try:
        spec = validated(spelling, written, context)
    except ValidationError as error:
        translated = (translate(e, tree, catalog) for e in error.errors(include_url=False))
        # The sweep is checked by sweep.check, which knows what its keys mean.
        findings = [f for f in translated if f is not None and f.path[:1] != ("sweep",)]
    context = {**context, "has_units": spelling.has_units}
    surface = _part(_SURFACE, frozen.get("surface"), context)
    given = frozen.get("models")
    models = [
        (number, model)
        for number, entry in enumerate(given if isinstance(given, tuple) else ())
        if (model := _part(_MODEL, entry, context)) is not None
        and not isinstance(model, Unavailable)
    ]
    pressures = _part(_PRESSURES, frozen.get("pressures"), context)
    saved = _part(_SAVED_FIELDS, frozen.get("save_fields"), context)
    comparable = not spelling.findings
    findings += check_fit(
        tree,
        surface if comparable else None,
        models,
        values_of(pressures) if pressures is not None and comparable else (),
        saved if comparable else None,
        has_units=spelling.has_units,
    )
    findings += check_twins(surface, frozen.get("twins"))
    if files:
        findings += check_file(surface)
    findings = in_written_keys(without_echoes(findings, tree, catalog), spelling)
    return (None if spelling.findings else spec), findings


def _validate_sweep(
    tree: Any, known: Sequence[Finding], context: Mapping[str, Any], *, files: bool
) -> list[Finding]:
    """Return what is wrong with the sweep, or with a combination of its values."""
    catalog = catalog_of(context)
    findings = sweep.check(tree, catalog)
    if findings or not tree.get("sweep"):
        return findings
    seen = set(known)
    for variant in sweep.variants(tree, catalog):
        for finding in _validate(variant.tree, context, files=files)[1]:
            if finding not in seen:
                seen.add(finding)
                findings.append(sweep.blame(finding, variant))
    return findings


_Part = TypeVar("_Part")


def _part(adapter: TypeAdapter[_Part], tree: Any, context: Mapping[str, Any]) -> _Part | None:
    try:
        return adapter.validate_python(tree, context=context)
    except ValidationError:
        return None


def _refused(path: KeyPath, refused: set[KeyPath]) -> bool:
    """Whether a fault at ``path`` only repeats that the text there was refused."""
    return any(path[: len(other)] == other or other[: len(path)] == path for other in refused)


def fault_at(finding: Finding, given: GivenSpec) -> Fault:
    """Return a finding with the place in the text, or the override, that it is about."""
    path, document = finding.path, given.document
    subject = render(path)
    for depth in range(len(path), 0, -1):
        if path[:depth] in given.overrides:
            return Fault(finding.message, subject, source=given.overrides[path[:depth]])
    place = document.values.get(path) if finding.at == "value" else None
    if finding.at == "key":
        place = document.keys.get(path, document.values.get(path))
    while place is None and path:  # a missing key stands at its parent's
        path = path[:-1]
        place = document.keys.get(path, document.values.get(path))
    place = place or Place()
    return Fault(finding.message, subject, place.line, place.column, given.source)
