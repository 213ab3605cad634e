"""Classes in Python files: ``mytheory.py:Erf09`` → the class, here and in other processes.

Models and observables may come so, and figures.

A file is loaded together with the files beside it that it imports, as a package of its own.
The package's name is made of the folder and the texts: two files of one name do not meet, and
a file that was edited is another module. Another process, perhaps on a machine without these
files, gets their texts with the object (:func:`carry`).
"""

from __future__ import annotations

import ast
import contextlib
import copyreg
import hashlib
import importlib
import importlib.machinery
import inspect
import os
import re
import sys
import traceback
import types
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.abc import Loader, MetaPathFinder
from pathlib import Path, PurePosixPath
from typing import Any

from roughbench.errors import ModelError, RoughbenchError, explained
from roughbench.text import on_one_line, suggestion

_PREFIX = "roughbench_file_"
_reference = re.compile(r"(?P<path>.+\.py)(?::(?P<name>.*))?", re.DOTALL).fullmatch


@dataclass(frozen=True, slots=True)
class SourceFiles:
    """A Python file and those beside it that it imports.

    Attributes
    ----------
    folder : str
        Absolute.
    main : str
        Name of the file.
    texts : tuple of (str, str)
        Path within the folder and text of each, by path.
    """

    folder: str
    main: str
    texts: tuple[tuple[str, str], ...]

    @property
    def package(self) -> str:
        """Name of the package that they are loaded as."""
        return f"{_PREFIX}{hashlib.sha256(repr(self).encode()).hexdigest()[:16]}"

    @property
    def module(self) -> str:
        """Name of the file's module."""
        return f"{self.package}.{self.main.removesuffix('.py')}"

    def text_of(self, name: str) -> tuple[str, str] | None:
        """Return path and text of a module of the package; None if it has none."""
        path = name.partition(".")[2].replace(".", "/")
        texts = dict(self.texts)
        found = next((p for p in (f"{path}/__init__.py", f"{path}.py") if p in texts), None)
        return None if found is None else (found, texts[found])


@dataclass(frozen=True, slots=True)
class Origin:
    """The files that a class was loaded from, and its name there."""

    files: SourceFiles
    name: str


_packages: dict[str, SourceFiles] = {}
_origins: dict[type, Origin] = {}


def names_file(name: str) -> bool:
    """Whether a name is that of a file: ``mytheory.py:Erf09``, or the same without a class."""
    return _reference(name) is not None


def origin_of(found: type) -> Origin | None:
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


def read_files(path: Path) -> SourceFiles:
    """Read a Python file and those beside it that it imports, directly or not.

    Raises
    ------
    ModelError
        If one cannot be read, or is not Python.
    """
    folder = Path(os.path.abspath(path)).parent  # noqa: PTH100  (links stay as they are)
    return SourceFiles(
        str(folder), path.name, tuple(sorted(_gathered(folder, path.name).items()))
    )


def installed_files(found: type) -> dict[str, str]:
    """Return the texts that an installed class is made of, by path.

    That of its module and of those that it imports, directly or not, from its own package; of
    a module without a package those beside it, if they are not what else is installed.
    """
    path = Path(inspect.getfile(found))
    parts = found.__module__.split(".")
    root = path.parents[len(parts) - (path.name != "__init__.py")]
    name = path.relative_to(root).as_posix()
    if len(parts) == 1 and path.name != "__init__.py" and any(root.glob("*.dist-info")):
        return {name: _read(path)}
    texts = _gathered(root, name)
    inside = f"{parts[0]}/"
    if not name.startswith(inside):
        return texts
    return {other: text for other, text in texts.items() if other.startswith(inside)}


def _gathered(folder: Path, main: str) -> dict[str, str]:
    """Return the texts of a file and of those beside it that it imports, directly or not."""
    texts: dict[str, str] = {}
    waiting = [main]
    while waiting:
        name = waiting.pop()
        if name not in texts:
            texts[name] = _read(folder / name)
            waiting += _beside(folder, name, texts[name])
    return texts


def load_class(files: SourceFiles, name: str, base: type = object) -> type[object]:
    """Return a class of a file.

    Raises
    ------
    ModelError
        If the file cannot be imported, or has no such class.
    """
    _packages[files.package] = files
    try:
        module = importlib.import_module(files.module)
    except (Exception, SystemExit) as error:
        raise ModelError(_place_and_error([files.main, *dict(files.texts)], error)) from error
    found = getattr(module, name, None)
    if not isinstance(found, type):
        raise ModelError(_no_class(files.main, name, module, base))
    if found.__module__.startswith(files.package) and found not in _origins:
        _origins[found] = Origin(files, name)
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


# -- files beside ------------------------------------------------------------------------


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        with contextlib.suppress(OSError):
            beside = [entry.name for entry in path.parent.iterdir() if entry.suffix == ".py"]
            if near := suggestion(path.name, beside):
                message = f"no such file: {on_one_line(path.name)} (did you mean {near!r}?)"
                raise ModelError(message) from None
        raise ModelError(f"no such file: {on_one_line(str(path))}") from None
    except UnicodeDecodeError:
        raise ModelError(f"{path.name} is not UTF-8 text; save it as UTF-8") from None
    except OSError as error:
        raise ModelError(f"cannot read {path.name}: {explained(error)}") from None


def _beside(folder: Path, name: str, text: str) -> Iterator[str]:
    """Yield the files of a folder that one of them imports."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None)
        place = f"{Path(name).name}:{line}" if line else Path(name).name
        raise ModelError(f"{place}: {getattr(error, 'msg', error)}") from None
    above = PurePosixPath(name).parent.parts
    for node in ast.walk(tree):
        modules: list[tuple[str, ...]] = []
        if isinstance(node, ast.Import):
            modules = [tuple(alias.name.split(".")) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            start = above[: len(above) + 1 - node.level] if node.level else ()
            base = (*start, *(node.module.split(".") if node.module else ()))
            modules = [base, *((*base, alias.name) for alias in node.names)]
        for parts in modules:
            yield from _files_of(folder, parts)


def _files_of(folder: Path, parts: Sequence[str]) -> Iterator[str]:
    """Yield the files of a module and of the packages around it, if they lie in the folder."""
    if parts[:1] == ("roughbench",):  # in a checkout it lies there, and belongs to no file
        return
    for depth in range(1, len(parts) + 1):
        inner = "/".join(parts[:depth])
        found = [p for p in (f"{inner}/__init__.py", f"{inner}.py") if (folder / p).is_file()]
        if not found:
            return
        yield found[0]


class _Within(ast.NodeTransformer):
    """Makes imports of files beside relative ones, so that they stay within the package."""

    def __init__(self, names: set[str], level: int) -> None:
        self._names = names
        self._level = level

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.ImportFrom:
        """``from helpers import x`` → ``from .helpers import x``."""
        if not node.level and (node.module or "").partition(".")[0] in self._names:
            node.level = self._level
        return node

    def visit_Import(self, node: ast.Import) -> list[ast.stmt]:
        """``import helpers`` → ``from . import helpers``."""
        made: list[ast.stmt] = []
        for alias in node.names:
            head, _, inner = alias.name.partition(".")
            if head not in self._names:
                made.append(ast.Import([alias]))
                continue
            if inner:
                parent, _, last = alias.name.rpartition(".")
                bound = ast.alias(last, alias.asname or f"_{last}_of_{head}")
                made.append(ast.ImportFrom(parent, [bound], self._level))
            if not inner or not alias.asname:
                bound = ast.alias(head, alias.asname)
                made.append(ast.ImportFrom(None, [bound], self._level))
        return [ast.copy_location(statement, node) for statement in made]


# -- their package -----------------------------------------------------------------------


class _Finder(MetaPathFinder):
    """Finds the modules of files that were read, or have come from another process."""

    def find_spec(
        self,
        fullname: str,
        path: object = None,
        target: object = None,
    ) -> importlib.machinery.ModuleSpec | None:
        """Find a module of a package that is known here."""
        del path, target
        files = _packages.get(fullname.partition(".")[0])
        if files is None:
            return None
        if fullname == files.package:
            return importlib.machinery.ModuleSpec(fullname, None, is_package=True)
        found = files.text_of(fullname)
        if found is None:
            return None
        place = _place(files, *found)
        spec = importlib.machinery.ModuleSpec(
            fullname,
            _TextLoader(files, *found),
            origin=place,
            is_package=found[0].endswith("__init__.py"),
        )
        spec.has_location = True
        return spec


class _TextLoader(Loader):
    """Makes a module of a text, with the name of the file that it stands in."""

    def __init__(self, files: SourceFiles, path: str, text: str) -> None:
        self._files = files
        self._path = path
        self._text = text

    def get_source(self, fullname: str) -> str:
        """Return the text, for tracebacks."""
        del fullname
        return self._text

    def exec_module(self, module: types.ModuleType) -> None:
        """Run the text."""
        place = module.__spec__.origin if module.__spec__ else None
        names = {
            PurePosixPath(path).parts[0].removesuffix(".py") for path, _ in self._files.texts
        }
        level = len(PurePosixPath(self._path).parts)
        tree = _Within(names, level).visit(ast.parse(self._text, place or self._path))
        code = compile(
            ast.fix_missing_locations(tree), place or self._path, "exec", dont_inherit=True
        )
        exec(code, module.__dict__)  # noqa: S102  (what the spec asks for)


def _place(files: SourceFiles, path: str, text: str) -> str:
    """Return a file with this text: the original, or a copy in the cache folder.

    Numba keeps what it compiles beside a file that is there.
    """
    from roughbench.transform import cache_folder

    original = Path(files.folder, path)
    with contextlib.suppress(OSError, UnicodeDecodeError):
        if original.read_text(encoding="utf-8-sig") == text:
            return str(original)
    with contextlib.suppress(OSError):
        copy = cache_folder() / "files" / files.package / path
        copy.parent.mkdir(parents=True, exist_ok=True)
        partial = copy.with_name(f".{copy.name}.{os.getpid()}")
        partial.write_text(text, encoding="utf-8")
        partial.replace(copy)
        return str(copy)
    return str(original)


sys.meta_path.append(_Finder())
