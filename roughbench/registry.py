"""What roughbench offers by name: its own, and what installed packages declare."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

from roughbench.errors import RoughbenchError

T = TypeVar("T")


class Registry(Mapping[str, T]):
    """Objects of one kind by name, those of roughbench first, then those of packages, by name.

    An object of a package is imported when it is asked for, not before: its module may import
    any part of roughbench.

    Parameters
    ----------
    group : str
        Entry points with which other packages declare theirs.
    built_in : mapping of str to object

    Raises
    ------
    RoughbenchError
        When names are listed, if one is declared twice; when an object is asked for, if it
        cannot be imported or calls itself by another name.
    """

    def __init__(self, group: str, built_in: Mapping[str, T]) -> None:
        self._group = group
        self._objects = dict(built_in)
        self._built_in = frozenset(built_in)

    @cached_property
    def _declared(self) -> dict[str, EntryPoint]:
        declared: dict[str, EntryPoint] = {}
        points = set(entry_points(group=self._group))  # a package may be found twice
        for point in sorted(points, key=lambda point: (point.name, point.value)):
            if point.name in self._built_in or point.name in declared:
                other = declared.get(point.name)
                first = _owner(other) if other is not None else "roughbench"
                raise RoughbenchError(
                    f"{first} and {_owner(point)} both declare {point.name!r} in "
                    f"{self._group}; rename one of them, or uninstall one of the packages"
                )
            declared[point.name] = point
        return declared

    def __getitem__(self, name: str) -> T:
        if name not in self._objects:
            self._objects[name] = self._load(self._declared[name])
        return self._objects[name]

    def _load(self, point: EntryPoint) -> T:
        where = f"{_owner(point)} declares {point.name!r} in {self._group}"
        try:
            found: T = point.load()
        except Exception as error:  # (whatever the package does when it is imported)
            raise RoughbenchError(
                f"{where}, which cannot be loaded ({type(error).__name__}: {error}); repair or "
                "uninstall it"
            ) from error
        own_name = getattr(found, "name", point.name)
        if own_name != point.name:
            raise RoughbenchError(f"{where}, whose name is {own_name!r}; give both one name")
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(
            [*(name for name in self._objects if name in self._built_in), *self._declared]
        )

    def __len__(self) -> int:
        return len(self._built_in) + len(self._declared)


def _owner(point: EntryPoint) -> str:
    return f"{point.dist.name} ({point.value})" if point.dist is not None else point.value
