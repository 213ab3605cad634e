"""Observables of Python files: ``tour.py:GapHistogram``, as a spec names them."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Iterable
from pathlib import Path

from roughbench.errors import ModelError
from roughbench.observables.base import Observable
from roughbench.quantities import Variable
from roughbench.source_files import load_reference
from roughbench.text import on_one_line

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_DECLARED = {"name": str, "title": str, "x": str, "y": str} | dict.fromkeys(
    ("values", "places"), Variable
)


def load_observable(reference: str, folder: Path, taken: Iterable[str] = ()) -> Observable:
    """Return the observable that a file and a class in it name.

    Parameters
    ----------
    reference : str
        As ``tour.py:GapHistogram``.
    folder : Path
        Where a relative path starts.
    taken : iterable of str
        Names that it must not have.

    Raises
    ------
    ModelError
        If there is no such file or class, it cannot be loaded, or is no observable; says what
        is missing.
    """
    where = Path(reference).name
    found: type = load_reference(reference, folder, Observable)
    observable = _made(found, where)
    if observable.name in taken:
        raise ModelError(
            f"{where} has the name {observable.name!r}, which another observable has; choose "
            "another"
        )
    return observable


@functools.cache  # one object of each class
def _made(found: type, where: str) -> Observable:
    if not issubclass(found, Observable):
        raise ModelError(f"{where} is not a subclass of roughbench.observables.Observable")
    page = "see docs/adding-an-observable.md"
    if inspect.isabstract(found):
        missing = ", ".join(sorted(found.__abstractmethods__))
        raise ModelError(f"{where} lacks {missing}; {page}")
    for name, kind in _DECLARED.items():
        if not isinstance(value := getattr(found, name, None), kind):
            is_there = "" if value is None else f", got {on_one_line(repr(value))}"
            raise ModelError(f"{where} lacks {name}, a {kind.__name__}{is_there}; {page}")
    for name in (found.name, found.variable, *found.scalars):
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            raise ModelError(
                f"{where}: names must have a letter first, then letters, digits and _, got "
                f"{on_one_line(repr(name))}"
            )
    for name in ("title", "x", "y"):
        if getattr(found, name).count("$") % 2:
            raise ModelError(f"{where}: {name} has a $ without another, which ends the formula")
    try:
        return found()
    except Exception as error:  # (whatever its constructor does)
        raise ModelError(
            f"{where} cannot be made without arguments: {type(error).__name__}: "
            f"{on_one_line(str(error))}"
        ) from error
