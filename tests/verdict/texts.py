"""The texts of the repository in which the paper may be cited, and how they are cut up."""

from __future__ import annotations

import ast
import io
import itertools
import json
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = (
    *("roughbench", "docs", "configs", "scripts", "examples", "tests"),
    *("website", "packaging", ".github", ".ci"),
)
KINDS = {
    **dict.fromkeys((".py",), "code"),
    **dict.fromkeys((".md", ".j2", ".txt"), "page"),
    **dict.fromkeys((".ipynb",), "notebook"),
    **dict.fromkeys(
        (".yaml", ".yml", ".toml", ".sh", ".js", ".css", ".cff", ".mplstyle", ".def", ""),
        "remarks",
    ),
}
"""Suffix → how a file is read."""
HERE = {Path(__file__), Path(__file__).with_name("test_paper.py")}
TABLE = ROOT / "roughbench/verdict/paper.py"
_NO_PROSE = {"plotly", "__pycache__"}


def files() -> list[Path]:
    """Return all files with prose, but for the table itself and its tests."""
    found = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*"))]
    found += [path for path in sorted(ROOT.iterdir()) if not path.name.startswith(".")]
    return [
        path
        for path in found
        if path.suffix in KINDS
        and path.is_file()
        and path not in {*HERE, TABLE}
        and not _NO_PROSE & set(path.parts)
    ]


def pieces(path: Path, text: str) -> Iterator[str]:
    """Yield texts that belong together: strings and comments of code, paragraphs of pages."""
    is_template = path.suffix == ".txt" and len(path.suffixes) > 1  # spec.yaml.txt
    kind = "remarks" if is_template else KINDS[path.suffix]
    if kind == "notebook":
        for cell in json.loads(text)["cells"]:
            source = "".join(cell["source"])
            yield from _of_code(source) if cell["cell_type"] == "code" else [source]
    elif kind == "code":
        yield from _of_code(text)
    elif kind == "remarks":
        for _, lines in itertools.groupby(text.split("\n"), _is_remark):
            yield re.sub(r"\n\s*(?:#|//|\*)", " ", "\n".join(["", *lines]))
    else:
        yield text


def _is_remark(line: str) -> bool:
    return line.lstrip().startswith(("#", "//", "*"))


def _of_code(text: str) -> Iterator[str]:
    inner = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.JoinedStr):
            parts = [one for one in node.values if isinstance(one, ast.Constant)]
            inner |= {id(one) for one in parts}
            yield " … ".join(str(one.value) for one in parts)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield "" if id(node) in inner else node.value
    comments, last = "", -1
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            if token.start[0] != last + 1:
                yield comments
                comments = ""
            comments += " " + token.string.lstrip("# ")
            last = token.start[0]
    yield comments


_PARAGRAPH = re.compile(
    r"\n\s*\n|\n(?=\| )|\n(?=\s*[-*] )|\n\.\. |\n(?=[-=]{3})|\n(?=\s*``\w+``)|;\s"
)
_SENTENCE = re.compile(r"(?<=[.!?])\s+(?=[A-Z*])")


def sentences(path: Path, text: str) -> Iterator[str]:
    """Yield the sentences of a file, and the rows of its tables."""
    for piece in pieces(path, text):
        for paragraph in _PARAGRAPH.split(piece):
            yield from _SENTENCE.split(re.sub(r"\s+", " ", paragraph))
