"""Classes of files: found by ``mytheory.py:Erf09``, carried to other processes, blamed.

Another process, perhaps on a machine without these files, gets their texts with the object
(:func:`carry`).
"""

from __future__ import annotations

import contextlib
import copyreg
import importlib
import inspect
import re
import traceback
import types
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roughbench.errors import ModelError, RoughbenchError
from roughbench.source_files.files import SourceFiles, read_files
from roughbench.source_files.importing import make_importable
from roughbench.text import on_one_line, suggestion

_reference = re.compile(r"(?P<path>.+\.py)(?::(?P<name>.*))?", re.DOTALL).fullmatch


@dataclass(frozen=True, slots=True)
class ClassOrigin:
    """The files that a class was loaded from, and its name there."""

    files: SourceFiles
    name: str


_origins: dict[type, ClassOrigin] = {}


def names_file(name: str) -> bool:
    """Whether a name is that of a file: ``mytheory.py:Erf09``, or the same without a class."""
    return _reference(name) is not None


def origin_of(found: type) -> ClassOrigin | None:
    """Return where a class comes from that was loaded from a file; None for any other."""
    return _origins.get(found)


def load_reference(reference: str, folder: Path, base: type = object) -> type[object]:
    """Return the class that ``mytheory.py:Erf09`` names.

    Parameters
    ----------
    reference : str
    folder : Path
        Where a relative path starts.
    base : type
        What errors propose are its subclasses.

    Raises
    ------
    ModelError
        If there is no such file or class, or the file cannot be loaded; with its line.
    """
    found = _reference(reference)
    if found is None:
        raise ModelError(f"must read mytheory.py:Erf09, got {on_one_line(reference)!r}")
    return load_class(read_files(folder / found["path"]), found["name"] or "", base)


def load_class(files: SourceFiles, name: str, base: type = object) -> type[object]:
    """Return a class of a file.

    Raises
    ------
    ModelError
        If the file cannot be imported, or has no such class.
    """
    make_importable(files)
    try:
        module = importlib.import_module(files.module)
    except (Exception, SystemExit) as error:
        raise ModelError(_place_and_error([files.main, *dict(files.texts)], error)) from error
    found = getattr(module, name, None)
    if not isinstance(found, type):
        raise ModelError(_no_class(files.main, name, module, base))
    if found.__module__.startswith(files.package) and found not in _origins:
        _origins[found] = ClassOrigin(files, name)
        copyreg.pickle(found, carry)
    return found


def _no_class(file: str, name: str, module: types.ModuleType, base: type) -> str:
    """Say that a file has no such class, and which it has."""
    own = [key for key, value in vars(module).items() if _is_own(value, module, base)]
    if not name and own:
        return f"must name a class too, as in {file}:{own[0]}"
    near = suggestion(name, own)
    kind = "classes" if base is object else f"{base.__name__.lower()}s"
    hint = f" (did you mean {near!r}?)" if near else f"; its {kind}: {', '.join(own) or 'none'}"
    return f"{file} has no class {on_one_line(name)!r}{hint}"


def carry(found: object) -> tuple[Any, ...]:
    """Return what pickle makes an object of a file's class from, wherever it arrives."""
    origin = _origins[type(found)]
    return _carried, (origin.files, origin.name), found.__getstate__()


def _carried(files: SourceFiles, name: str) -> object:
    """Return an object without its state, which pickle then gives it."""
    found = load_class(files, name)
    return found.__new__(found)


def _is_own(value: object, module: types.ModuleType, base: type) -> bool:
    if not isinstance(value, type) or value.__module__ != module.__name__:
        return False
    return issubclass(value, base) and not inspect.isabstract(value)


def _place_and_error(files: Sequence[str], error: BaseException) -> str:
    """Say at which line of some files, the innermost, something failed, and how."""
    if isinstance(error, SyntaxError) and error.lineno:
        return f"{Path(error.filename or files[0]).name}:{error.lineno}: {error.msg}"
    own = {Path(path).name for path in files}
    lines = [
        f"{Path(frame.filename).name}:{frame.lineno}: "
        for frame in traceback.extract_tb(error.__traceback__)
        if Path(frame.filename).name in own
    ]
    return f"{''.join(lines[-1:])}{on_one_line(f'{type(error).__name__}: {error}')}"


def blamed(raised_in: object, error: Exception, where: str) -> Exception:
    """Return an error of a model or an observable from outside as one of its file, with line.

    Parameters
    ----------
    raised_in : object
        What raised it.
    error : Exception
        One of roughbench, or raised in something of roughbench, stays what it is.
    where : str
        In what the message begins with.
    """
    kind = type(raised_in)
    origin = origin_of(kind)
    if isinstance(error, RoughbenchError) or kind.__module__.startswith("roughbench."):
        return error
    names = [path for path, _ in origin.files.texts] if origin else []
    with contextlib.suppress(OSError, TypeError):  # of a class without a file
        names.append(inspect.getfile(kind))
    return ModelError(f"{where}: {_place_and_error(names, error)}")
