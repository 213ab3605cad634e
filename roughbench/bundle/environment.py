"""What is installed here, and what results were computed with: pinned, to have it again."""

from __future__ import annotations

import platform
import re
from collections.abc import Iterable, Mapping
from importlib import metadata

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
_HEAD = """\
# What {name} was computed with, and draws its figures with: Python {python}.
# python -m venv env && env/bin/pip install -r requirements.txt
"""


def pinned(roots: Iterable[str] = ("roughbench",)) -> dict[str, str]:
    """Return the versions of installed packages, and of all that they depend on.

    Parameters
    ----------
    roots : iterable of str
        Names of distributions; those that are not installed are passed over. Extras are no
        dependencies.

    Examples
    --------
    >>> sorted({"numpy", "h5py"} & set(pinned()))
    ['h5py', 'numpy']
    """
    versions: dict[str, str] = {}
    waiting = [*roots]
    while waiting:
        name = _normal(waiting.pop())
        if name in versions:
            continue
        try:
            found = metadata.distribution(name)
        except metadata.PackageNotFoundError:
            continue
        versions[name] = found.version
        waiting += [
            match[0]
            for text in found.requires or ()
            if "extra ==" not in text and (match := _NAME.match(text))
        ]
    return dict(sorted(versions.items()))


def requirements(name: str, installed: Mapping[str, str], used: Mapping[str, str]) -> str:
    """Return a requirements file.

    Parameters
    ----------
    name : str
        Of the results file.
    installed : mapping of str to str
        See :func:`pinned`.
    used : mapping of str to str
        Versions that the numbers were computed with, as far as they are known; they count
        more than what is installed here.
    """
    versions = {**installed, **{key: used[key] for key in installed if key in used}}
    lines = [f"{key}=={value}" for key, value in versions.items()]
    head = _HEAD.format(name=name, python=used.get("python", platform.python_version()))
    return head + "\n".join(lines) + "\n"


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
