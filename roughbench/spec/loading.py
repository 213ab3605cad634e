"""From a file, a text or a dict to a frozen spec, or to all its faults.

``load_spec`` is for what shall be computed, and looks whether the files are there that the
spec names. ``parse_spec`` is for the text that results carry, which may be read anywhere.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from roughbench.errors import Fault, SpecError, explained
from roughbench.models.base import Model
from roughbench.models.registry import Catalog, Unavailable
from roughbench.program import command
from roughbench.spec import sweep
from roughbench.spec.checks import check_file, check_fit, check_twins
from roughbench.spec.fields import SavedFields
from roughbench.spec.messages import translate, without_echoes
from roughbench.spec.model import Spec, validated
from roughbench.spec.models import AnyModel, catalog_of
from roughbench.spec.names import default_name
from roughbench.spec.overrides import apply_overrides
from roughbench.spec.pressures import PressureRange, Pressures, values_of
from roughbench.spec.reading import MAX_CHARACTERS, Document, Place, read_yaml
from roughbench.spec.surfaces import AnySurface, Surface
from roughbench.spec.tree import (
    Finding,
    KeyPath,
    freeze,
    plain,
    render,
)
from roughbench.spec.with_units import in_written_keys, spelled
from roughbench.text import on_one_line, suggestion

_SURFACE: TypeAdapter[AnySurface] = TypeAdapter(Surface)
_MODEL: TypeAdapter[Model] = TypeAdapter(AnyModel)
_PRESSURES: TypeAdapter[PressureRange | tuple[float, ...]] = TypeAdapter(Pressures)
_SAVED_FIELDS: TypeAdapter[SavedFields] = TypeAdapter(SavedFields)

_HDF5 = b"\x89HDF\r\n\x1a\n"

Source = str | os.PathLike[str] | Mapping[str, Any] | Spec


@dataclass(slots=True)
class _Given:
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


def load_spec(
    source: Source, overrides: Sequence[str] = (), *, folder: str | os.PathLike[str] = ""
) -> Spec:
    """Return the spec that ``source`` describes.

    Parameters
    ----------
    source : path, str, mapping or Spec
        A file; or YAML text (a str of several lines, or one that starts with ``{``); or
        the same as a mapping. Relative paths of height files start at the file's folder,
        else at the current one.
    overrides : sequence of str
        ``key=value`` each, as behind ``--set`` on the command line.
    folder : path
        Where relative paths of height files start in a text; default: the current folder.

    Raises
    ------
    SpecError
        With every fault of the spec, each with line and column where a text is at hand.

    Examples
    --------
    >>> spec = load_spec('''
    ... surface: {H: 0.7, q0: 1, q1: 128, slope: 0.1}
    ... pressures: {min: 1e-5, max: 0.2, points: 20}
    ... models:
    ...   - kind: persson
    ... ''', overrides=["surface.qr=8"])
    >>> spec.surface.q_rolloff, len(spec.pressures), spec.models[0].name
    (8.0, 20, 'persson')
    """
    if isinstance(source, Spec):
        if not overrides:
            return source
        given = _Given(Document(source.as_given()), source.name, source.folder)
    elif isinstance(source, Mapping):
        given = _from_mapping(source)
    elif isinstance(source, str) and ("\n" in source or source.lstrip().startswith("{")):
        given = _Given(read_yaml(source), folder=Path(folder), text=source)
    else:
        given = _from_file(source)
    return _build(given, overrides)


def parse_spec(
    text: str,
    *,
    folder: str | os.PathLike[str] = "",
    outside: Mapping[str, str] | None = None,
) -> Spec:
    """Return the spec that a text is, whether the files that it names are there or not.

    Parameters
    ----------
    text : str
        YAML, such as the ``spec`` of a results file.
    folder : path
        Where relative paths start; default: the current folder.
    outside : mapping of str to str, optional
        Run no Python file that the spec names as a model, and let pass what is not installed:
        kind in the spec → kind in the results
        (:attr:`roughbench.results.Results.outside_kinds`).

    Raises
    ------
    SpecError
        With every fault of the text.
    """
    given = _Given(read_yaml(text), folder=Path(folder), text=text, outside=outside)
    return _build(given, (), files=False)


def _from_mapping(source: Mapping[str, Any]) -> _Given:
    tree, findings = plain(source)
    given = _Given(Document(tree))
    if findings:
        raise SpecError([_fault(finding, given) for finding in findings])
    return given


def _from_file(source: str | os.PathLike[str]) -> _Given:
    path = Path(source)
    name = on_one_line(os.fspath(source))
    try:
        with path.open("rb") as stream:
            data = stream.read(4 * MAX_CHARACTERS + 1)
        if data.startswith(_HDF5):
            hint = f"if it has results, see them with: {command('show', path)}"
            raise SpecError([Fault(f"is an HDF5 file, not a spec; {hint}", source=name)])
        text = data.decode("utf-8-sig")
    except FileNotFoundError:
        near = suggestion(path.name, _neighbours(path))
        hint = f" (did you mean {str(path.with_name(near))!r}?)" if near else ""
        raise SpecError([Fault(f"no such file{hint}", source=name)]) from None
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        message = "is not UTF-8 text; save it as UTF-8"
        raise SpecError([Fault(message, "", line, column, name)]) from None
    except (OSError, ValueError) as error:
        reason = explained(error) if isinstance(error, OSError) else str(error)
        raise SpecError([Fault(f"cannot be read: {reason}", source=name)]) from None
    return _Given(read_yaml(text), path.stem, path.parent, name, text)


def _neighbours(path: Path) -> list[str]:
    try:
        return [entry.name for entry in path.parent.iterdir()]
    except OSError:
        return []


def _build(given: _Given, overrides: Sequence[str], *, files: bool = True) -> Spec:
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
            faults.append(_fault(Finding((), message), given))
        raise SpecError(faults)

    tree, given.overrides, override_faults = apply_overrides(
        tree, overrides, given.context["catalog"]
    )
    tree = {"name": default_name(given.name), **tree}
    text = None if overrides else given.text
    context = given.context
    spec, findings = _validate(tree, context | {"text": text}, files=files)
    findings += _validate_sweep(tree, findings, context, files=files)
    faults += [_fault(f, given) for f in findings if not _refused(f.path, document.refused)]
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


def _fault(finding: Finding, given: _Given) -> Fault:
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
