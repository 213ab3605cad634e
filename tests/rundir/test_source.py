"""What counts as a change of the code: what it computes, not what it says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from roughbench.models.base import Model
from roughbench.models.foundation import Foundation
from roughbench.models.halfspace import HalfSpace
from roughbench.rundir import identity, source

TEXT = '''
"""Springs."""
from __future__ import annotations
import numpy as np
from numba import njit

STIFF = 2.5  # per length
"""Of a spring."""


class Springs(Model):
    """Independent springs."""

    number: int = Field(default=64, ge=1, description="Springs on the line.")

    @property
    def title(self) -> str:
        """Name."""
        return f"{self.number:>{len('x')}} springs, {STIFF!r}{self.number=}" "!"


@njit(cache=True)
def press(heights, /, *rest, depth: float = 1e-3, **more):
    """Return forces."""
    match heights:
        case [first, *_] if first > 0:
            pass
    if (n := len(heights)) > 3 and not rest:
        return [STIFF * max(0, depth - h) for h in heights if h is not ...]
    try:
        return {1: 2j, **more}[n]
    except (KeyError, ValueError) as error:
        raise RuntimeError("none") from error
'''
DIGEST = "7fdc285f44fa5570"
"""The same on every version of Python."""


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('"""Springs."""', '"""Independent springs: roughbench.models.persson."""'),
        ("  # per length", ""),
        ('"""Of a spring."""', "# nothing"),
        ('    """Independent springs."""\n\n', ""),
        ("Springs on the line.", "How many springs there are."),
        ('        """Name."""\n', ""),
        ("(STIFF", "(  STIFF"),
        ("    match heights", "\n\n\n    match heights"),
        ('"none"', "'none'"),
        ("2.5 ", "2.50 "),
    ],
)
def test_words_and_layout_do_not_count(before: str, after: str) -> None:
    assert before in TEXT or before == "(STIFF"
    assert source.digest(TEXT.replace(before, after)) == source.digest(TEXT)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("2.5", "2.6"),
        ("1e-3", "1e-4"),
        ("max(0", "min(0"),
        ("> 3", ">= 3"),
        ("default=64", "default=65"),
        ("ge=1", "gt=1"),
        ("depth - h", "h - depth"),
        ("@njit(cache=True)\n", ""),
        ("cache=True", "cache=True, fastmath=True"),
        ("h is not ...", "h is ..."),
        ("{1: 2j, **more}", "{1: 2j}"),
        ("STIFF!r", "STIFF"),
        ("import numpy as np", "import numpy"),
        ("'x'", "'xy'"),
    ],
)
def test_whatever_computes_counts(before: str, after: str) -> None:
    assert before in TEXT
    assert source.digest(TEXT.replace(before, after)) != source.digest(TEXT)


def test_the_digest_is_the_same_on_every_version_of_python() -> None:
    assert source.digest(TEXT)[:16] == DIGEST


@pytest.mark.parametrize("model", [Foundation, HalfSpace])
def test_words_in_the_package_keep_the_identity_and_numbers_change_it(
    model: type[Model], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Path.read_text
    edit: list[tuple[str, str, str]] = []

    def read(path: Path, *arguments: str, **options: str) -> str:
        text = real(path, *arguments, **options)
        for name, pattern, replacement in edit:
            if path.parts[-2:] == ("roughbench", name):
                text, count = re.subn(pattern, replacement, text, count=1)
                assert count == 1
        return text

    monkeypatch.setattr(Path, "read_text", read)

    def digest() -> str:
        identity._code_of.cache_clear()
        return identity.code_digest(model)

    before = digest()
    edit[:] = [("surface.py", "Heights with a given", "See roughbench.models.gw. Some")]
    assert digest() == before
    edit[:] = [("surface.py", "floor", "ceil")]
    assert digest() != before
    edit[:] = [("spectrum.py", r"\*= 2\.0  # the other", "*= 2.5  # the other")]
    assert digest() != before
    monkeypatch.undo()
    identity._code_of.cache_clear()
    assert digest() == before


def test_what_makes_rows_of_curves_is_part_of_the_identity(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A change of what is kept of a state left finished runs as they were."""
    real = Path.read_text
    changed: list[str] = []

    def read(path: Path, *arguments: str, **options: str) -> str:
        return real(path, *arguments, **options) + "\nMORE = 1\n" * (path.name in changed)

    monkeypatch.setattr(Path, "read_text", read)
    found = set()
    for name in ("", "blocks.py", "compute.py"):
        changed[:] = [name]
        identity._code_of.cache_clear()
        found.add(identity.code_digest(Foundation))
    assert len(found) == 3
    monkeypatch.undo()
    identity._code_of.cache_clear()


def test_the_loops_of_the_solver_are_part_of_the_identity(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    real = Path.read_text
    changed = "\nMORE = 1\n"

    def read(path: Path, *arguments: str, **options: str) -> str:
        return real(path, *arguments, **options) + changed * (path.parent.name == "loops")

    identity._code_of.cache_clear()
    before = {model: identity.code_digest(model) for model in (Foundation, HalfSpace)}
    monkeypatch.setattr(Path, "read_text", read)
    identity._code_of.cache_clear()
    assert identity.code_digest(Foundation) == before[Foundation]
    assert identity.code_digest(HalfSpace) != before[HalfSpace]
    identity._code_of.cache_clear()


def test_a_word_discards_nothing_that_was_observed(monkeypatch: pytest.MonkeyPatch) -> None:
    before = identity.observing_digest()
    real = Path.read_text
    for change, same in (("\n'''Words.'''\n", True), ("\nMORE = 1\n", False)):
        monkeypatch.setattr(
            Path, "read_text", lambda path, change=change, **o: real(path, **o) + change
        )
        identity.observing_digest.cache_clear()
        assert (identity.observing_digest() == before) == same
    monkeypatch.undo()
    identity.observing_digest.cache_clear()
