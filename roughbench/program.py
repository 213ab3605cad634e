"""How this program was called: the commands that it prints can be typed as they stand."""

from __future__ import annotations

import shlex
import shutil
import sys
from pathlib import Path

_NAME = "roughbench"


def command(*words: object) -> str:
    """Return a command line of roughbench for the user's shell.

    Parameters
    ----------
    *words : object
        Arguments; quoted where a shell wants it.

    Examples
    --------
    >>> command("show", "h 08.h5")
    "roughbench show 'h 08.h5'"
    """
    return " ".join([program(), *(shlex.quote(str(word)) for word in words)])


def program() -> str:
    """Return ``roughbench`` where the shell finds this one by that name, else what was typed.

    In another program, such as a script that imports roughbench, it is the name.
    """
    called, module = Path(sys.argv[0]), _called_as_module()
    if module:
        ours, otherwise = Path(sys.executable).with_name(_NAME), shlex.join(module)
    elif called.name == _NAME:
        ours, otherwise = called, shlex.quote(sys.argv[0])
    else:
        return _NAME
    found = shutil.which(_NAME)
    return _NAME if found and _are_one(Path(found), ours) else otherwise


def _called_as_module() -> list[str]:
    """Return ``python -m roughbench`` as it was typed; empty if it was not."""
    n_arguments = len(sys.argv) - 1
    typed = sys.orig_argv[: len(sys.orig_argv) - n_arguments]
    return typed if typed[-2:] == ["-m", _NAME] else []


def _are_one(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:
        return False
