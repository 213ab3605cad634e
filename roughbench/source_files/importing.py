"""Files, or their texts, imported as a package of their own.

The package's name is made of the folder and the texts: two files of one name do not meet, and
a file that was edited is another module.
"""

from __future__ import annotations

import ast
import contextlib
import importlib.machinery
import os
import sys
import types
from importlib.abc import Loader, MetaPathFinder
from pathlib import Path, PurePosixPath

from roughbench.source_files.files import SourceFiles

_packages: dict[str, SourceFiles] = {}


def make_importable(files: SourceFiles) -> None:
    """Let the modules of a package be imported in this process."""
    _packages[files.package] = files


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
