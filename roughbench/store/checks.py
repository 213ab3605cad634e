"""What keeps a damaged or a crafted file from being read: checksum, names, links, sizes."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

from roughbench.errors import StoreError
from roughbench.program import command, program
from roughbench.results import Attribute
from roughbench.seal import check_seal, has_mark
from roughbench.store.format import HDF5_SIGNATURE
from roughbench.text import on_one_line, unsafe_character

_LONGEST_NAME = 1000
"""Characters; a sweep of many keys has long names."""


@contextlib.contextmanager
def damage_named(source: Path) -> Iterator[None]:
    """Turn what h5py raises over a damaged file into an error that names the file."""
    try:
        yield
    except (OSError, KeyError, RuntimeError, ValueError, TypeError) as error:
        raise StoreError(f"{source}: damaged ({error}); {rerun_hint()}") from error


def check_sealed(source: Path) -> None:
    """Refuse a file whose bytes are not those that were written.

    HDF5 checks the arrays on its own, but a damage elsewhere may be read without notice, or
    make it loop for ever.
    """
    with source.open("rb") as file:
        try:
            check_seal(file)
        except ValueError:
            if has_mark(file):
                raise
            file.seek(0)
            begins = file.read(len(HDF5_SIGNATURE))
        else:
            return
    if begins == HDF5_SIGNATURE:
        raise StoreError(
            f"{source}: an HDF5 file, but not written by roughbench, or cut short; give a "
            f"results file of 'roughbench run', or {rerun_hint()}"
        )
    if source.suffix in {".yaml", ".yml"}:
        hint = f"if it is a spec, compute it with: {command('run', source)}"
    else:
        hint = "give a roughbench results file"
    raise StoreError(f"{source}: not an HDF5 file; {hint}")


def rerun_hint() -> str:
    """Say how a results file is had again."""
    return f"run its spec again ({program()} run SPEC.yaml)"


class ReadingBudget:
    """What a file of ours can hold: each object once, and no more bytes than it has.

    A crafted one links the same object a million times, or declares arrays that nobody wrote.
    """

    def __init__(self, source: Path) -> None:
        self.source = source
        self._left = self._size = source.stat().st_size
        self._seen: set[tuple[int, int]] = set()

    def meet(self, item: h5py.Group | h5py.Dataset) -> None:
        """Refuse an object that was met before."""
        info = h5py.h5o.get_info(item.id)
        place = (info.fileno, info.addr)
        if place in self._seen:
            raise ValueError(f"{on_one_line(item.name)} stands in it under two names")
        self._seen.add(place)

    def take(self, n_bytes: int, what: str) -> None:
        """Refuse more bytes in all than the file has."""
        self._left -= n_bytes
        if self._left < 0:
            raise ValueError(f"{what} claims {n_bytes} bytes, the file has {self._size} in all")


def members(
    group: h5py.Group, wanted: type[h5py.Group | h5py.Dataset], budget: ReadingBudget
) -> Iterator[tuple[str, h5py.Group | h5py.Dataset]]:
    """Yield the members of a group; only plain links to the wanted type are followed."""
    for name in group:
        check_name(name)
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise StoreError(
                f"{budget.source}: {group.name}/{name} is a link to another place, which no "
                f"roughbench file has; {rerun_hint()}"
            )
        member = group[name]
        if not isinstance(member, wanted):
            raise ValueError(f"{member.name} should be a {wanted.__name__.lower()}")
        budget.meet(member)
        yield name, member


def check_name(name: str) -> None:
    """Refuse names that mean something to file systems, terminals or spreadsheets."""
    means_else = "/" in name or name[:1] in "=+-@" or name == "."
    if means_else or unsafe_character(name) or len(name) > _LONGEST_NAME:
        shown = on_one_line(name[:_LONGEST_NAME])
        raise ValueError(f"the name {shown!r} is none that roughbench gives")


def read_attribute(owner: h5py.Group, name: str, budget: ReadingBudget) -> Attribute:
    """Return an attribute as a plain Python string or number; look at its size first."""
    attribute = owner.attrs.get_id(name)
    if attribute.shape != ():
        raise ValueError(f"an attribute {on_one_line(name)} of shape {attribute.shape}")
    budget.take(attribute.dtype.itemsize, f"attribute {on_one_line(name)}")
    value = _plain(owner.attrs[name])
    if isinstance(value, str):
        budget.take(len(value), f"attribute {on_one_line(name)}")
    return value


def _plain(value: object) -> Attribute:
    """Return an attribute as a plain Python string or number."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, str | int | float):
        return value
    raise ValueError(f"an attribute of type {type(value).__name__}")
