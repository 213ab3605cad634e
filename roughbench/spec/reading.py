"""YAML text → a plain tree, the place of every key and value, and all structural faults.

The tree is built from PyYAML's event stream rather than by its constructors: nothing
but mappings, lists and scalars can come out, an alias bomb has no chance to go off, and
every node keeps its line and column.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import yaml

from roughbench.spec.tree import MAX_DEPTH, KeyPath
from roughbench.spec.yaml12 import Loader
from roughbench.text import on_one_line, unsafe_character

MAX_CHARACTERS = 256 * 1024
"""Longest text read as a spec; real ones have a few thousand characters."""

_HINTS = {
    r"character '\t'": "indent with spaces",
    "that cannot start any token": "quote text that starts with a sign",
    "mapping values are not allowed": "check the indentation, and quote text that holds ': '",
    "could not find expected ':'": "every line of a mapping reads `key: value`",
    "expected <block end>": "check the indentation of this line against the one above",
    "expected ',' or": "close the bracket, or put a comma before this",
    "while scanning a quoted": "close the quote",
}


@dataclass(frozen=True, slots=True)
class Place:
    """Line and column, from 1; (0, 0) where no file stands behind it."""

    line: int = 0
    column: int = 0


@dataclass(frozen=True, slots=True)
class StructureFault:
    """A fault of the text itself, with its own place."""

    path: KeyPath
    message: str
    place: Place


@dataclass(slots=True)
class Document:
    """What one YAML text says, and where it says so.

    Attributes
    ----------
    tree : object
        The values (see :mod:`roughbench.spec.tree`); None for an empty text.
    complete : bool
        False where the text broke off, so that there is no tree to look at.
    keys, values : dict
        Key path → place of the key, and of the value.
    faults : list of StructureFault
    refused : set
        Key paths whose value was refused; what else is wrong there is of no interest.
    """

    tree: Any = None
    complete: bool = True
    keys: dict[KeyPath, Place] = field(default_factory=dict)
    values: dict[KeyPath, Place] = field(default_factory=dict)
    faults: list[StructureFault] = field(default_factory=list)
    refused: set[KeyPath] = field(default_factory=set)


class _BreakOff(Exception):  # noqa: N818 (no error by itself: its fault is kept)
    """Reading on makes no sense."""


def read_yaml(text: str) -> Document:
    """Read one YAML document; faults are returned, not raised.

    Examples
    --------
    >>> document = read_yaml("surface: {H: 0.7, q1: 1e5}")
    >>> document.tree
    {'surface': {'H': 0.7, 'q1': 100000.0}}
    >>> document.values["surface", "q1"]
    Place(line=1, column=23)
    """
    document = Document()
    if len(text) > MAX_CHARACTERS:
        fault = f"is longer than {MAX_CHARACTERS} characters; a spec is a short text"
        document.faults.append(StructureFault((), fault, Place(1, 1)))
        document.complete = False
        return document
    unsafe = unsafe_character(text, allowed="\n\r\t")
    if unsafe is not None:  # in comments too: the text goes into results and reports
        position, what = unsafe
        return _broken(document, text, position, f"holds {what}; remove it")
    try:
        reader = _Reader(document, Loader(text))
    except yaml.reader.ReaderError as error:
        what = f"holds a character that YAML does not know, U+{error.character:04X}"
        return _broken(document, text, error.position, what)
    try:
        reader.read()
    except _BreakOff:
        document.complete = False
    finally:
        reader.loader.dispose()
    return document


def _broken(document: Document, text: str, position: int, message: str) -> Document:
    """Return a document of a text that cannot be read as YAML at all."""
    before = text[:position]
    place = Place(before.count("\n") + 1, position - before.rfind("\n"))
    document.faults.append(StructureFault((), message, place))
    document.complete = False
    return document


class _Reader:
    """One pass over the events of a text."""

    def __init__(self, document: Document, loader: Loader) -> None:
        self.document = document
        self.loader = loader

    def read(self) -> None:
        self._next()  # the start of the stream
        if isinstance(self._next(), yaml.StreamEndEvent):
            return
        self.document.tree = self._node(self._next(), ())
        self._next()  # the end of the document
        after = self._next()
        if not isinstance(after, yaml.StreamEndEvent):
            self._fault((), "a spec is one YAML document; remove what follows '---'", after)

    def _next(self) -> yaml.Event:
        try:
            event: yaml.Event = self.loader.get_event()  # type: ignore[no-untyped-call]
        except yaml.MarkedYAMLError as error:
            text = " ".join(filter(None, (error.context, error.problem)))
            hint = next((hint for sign, hint in _HINTS.items() if sign in text), "")
            problem = on_one_line(error.problem or text)
            message = f"is no valid YAML: {problem}" + (f" ({hint})" if hint else "")
            place = _place(error.problem_mark or error.context_mark)
        except (ValueError, OverflowError) as error:  # an escape beyond Unicode, a huge version
            message, place = f"is no valid YAML: {error}", _place(self.loader.get_mark())
        else:
            return event
        self.document.faults.append(StructureFault((), message, place))
        raise _BreakOff

    def _fault(self, path: KeyPath, message: str, event: yaml.Event) -> None:
        self.document.faults.append(StructureFault(path, message, _place(event.start_mark)))

    def _node(self, event: yaml.Event, path: KeyPath) -> Any:
        self.document.values.setdefault(path, _place(event.start_mark))
        if len(path) > MAX_DEPTH:
            self._fault(path[:3], f"is nested deeper than {MAX_DEPTH} levels", event)
            raise _BreakOff
        self._refuse_extras(event, path)
        if isinstance(event, yaml.MappingStartEvent):
            return self._mapping(path)
        if isinstance(event, yaml.SequenceStartEvent):
            return self._sequence(path)
        return self._scalar(event, path) if isinstance(event, yaml.ScalarEvent) else None

    def _refuse_extras(self, event: yaml.Event, path: KeyPath) -> None:
        if isinstance(event, yaml.AliasEvent):
            message = f"aliases are not supported; write the value of *{event.anchor} again"
        elif event.anchor is not None:  # type: ignore[attr-defined]
            message = f"anchors are not supported; remove &{event.anchor}"  # type: ignore[attr-defined]
        elif event.tag is not None:  # type: ignore[attr-defined]
            message = f"tags are not supported; remove {event.tag!r}"  # type: ignore[attr-defined]
        else:
            return
        self._fault(path, message, event)
        self.document.refused.add(path)

    def _scalar(self, event: yaml.ScalarEvent, path: KeyPath) -> Any:
        try:
            value = self.loader.value(event)
            unsafe = unsafe_character(value) if isinstance(value, str) else None
            if unsafe is not None:  # written as an escape, or over several lines
                raise ValueError(f"holds {unsafe[1]}; remove it")
        except ValueError as error:
            self._fault(path, str(error), event)
            self.document.refused.add(path)
            return None
        return value

    def _sequence(self, path: KeyPath) -> list[Any]:
        entries: list[Any] = []
        while not isinstance(event := self._next(), yaml.SequenceEndEvent):
            entries.append(self._node(event, (*path, len(entries))))
        return entries

    def _mapping(self, path: KeyPath) -> dict[str, Any]:
        entries: dict[str, Any] = {}
        while not isinstance(event := self._next(), yaml.MappingEndEvent):
            key = self._key(event, path)
            duplicate = key in entries
            here = (*path, key)
            if duplicate:
                first = self.document.keys[here]
                self._fault(here, f"duplicate key (first on line {first.line})", event)
            elif key:
                self.document.keys.setdefault(here, _place(event.start_mark))
            value = self._node(self._next(), here)
            if key and not duplicate:
                entries[key] = value
        return entries

    def _key(self, event: yaml.Event, path: KeyPath) -> str:
        """Return the key, empty if it was refused; any plain scalar counts as text."""
        if not isinstance(event, yaml.ScalarEvent):
            self._fault(path, "a key must be a word", event)
            self._node(event, (*path, ""))
            return ""
        if event.value == "<<" and event.implicit[0]:
            self._fault(path, "merge keys are not supported; write the keys out", event)
            return ""
        if not event.value.strip():
            self._fault(path, "a key is missing before ':'", event)
            return ""
        unsafe = unsafe_character(event.value)
        if unsafe is not None:
            self._fault(path, f"a key holds {unsafe[1]}; remove it", event)
            return ""
        self._refuse_extras(event, (*path, event.value))
        return str(event.value)


def _place(mark: Any) -> Place:
    return Place(mark.line + 1, mark.column + 1) if mark is not None else Place(1, 1)
