"""A Python file together with the files beside it that it imports."""

from __future__ import annotations

import ast
import contextlib
import hashlib
import inspect
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from roughbench.errors import ModelError, explained
from roughbench.text import on_one_line, suggestion

_PREFIX = "roughbench_file_"


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
