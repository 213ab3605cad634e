"""Classes in Python files: ``mytheory.py:Erf09`` → the class, here and in other processes.

Models and observables may come so, and figures. A file is loaded together with the files beside
it that it imports, as a package of its own.
"""

from __future__ import annotations

from roughbench.source_files.classes import (
    ClassOrigin,
    blamed,
    carry,
    load_class,
    load_reference,
    names_file,
    origin_of,
)
from roughbench.source_files.files import SourceFiles, installed_files, read_files

__all__ = [
    "ClassOrigin",
    "SourceFiles",
    "blamed",
    "carry",
    "installed_files",
    "load_class",
    "load_reference",
    "names_file",
    "origin_of",
    "read_files",
]
