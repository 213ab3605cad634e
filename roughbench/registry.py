"""What roughbench offers by name: its own, and what installed packages declare."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

from roughbench.errors import RoughbenchError
from roughbench.text import on_one_line

T = TypeVar("T")


class Registry(Mapping[str, T]):
    """Objects of one kind by name, those of roughbench first, then those of packages, by name.

    An object that is declared, by a package or among ``declared``, is imported when it is asked
    for, not before: its module may import any part of roughbench.

    Parameters
    ----------
    group : str
        Entry points with which other packages declare theirs.
    built_in : mapping of str to object
    declared : mapping of str to str
        More of roughbench's own, as ``module:object``.
    check : callable, optional
        Given what was loaded, its name, and in words where it comes from; returns the object,
        or raises if it is none of its kind. By default the object's ``name``, if it has one,
        has to be that name.

    Raises
    ------
    RoughbenchError
        When an object is asked for: if it is declared twice, cannot be imported, or does not
        pass the check.
    """

    def __init__(
        self,
        group: str,
        built_in: Mapping[str, T] | None = None,
        declared: Mapping[str, str] | None = None,
        check: Callable[[object, str, str], T] | None = None,
    ) -> None:
        self._group = group
        self._built_in = dict(built_in or {})
        self._own = {
            name: EntryPoint(name, place, group) for name, place in (declared or {}).items()
        }
        self._check = check
        self._loaded: dict[str, T] = {}

    @cached_property
    def _declared(self) -> dict[str, list[EntryPoint]]:
        declared = {name: [point] for name, point in self._own.items()}
        points = set(entry_points(group=self._group))  # a package may be found twice
        for point in sorted(points, key=lambda point: (point.name, point.value)):
            declared.setdefault(point.name, []).append(point)
        return declared

    def look_again(self) -> None:
        """Forget what packages declare: one may have been installed meanwhile."""
        self._loaded.clear()
        self.__dict__.pop("_declared", None)

    def __getitem__(self, name: str) -> T:
        if name in self._loaded:
            return self._loaded[name]
        owners = ["roughbench"] * (name in self._built_in)
        owners += [_owner(point) for point in self._declared.get(name, ())]
        if len(owners) > 1:
            raise RoughbenchError(
                f"{' and '.join(owners)} both declare {name!r} in {self._group}; rename one of "
                "them, or uninstall one of the packages"
            )
        if name in self._built_in:
            self._loaded[name] = self._built_in[name]
        else:
            self._loaded[name] = self._load(self._declared[name][0])
        return self._loaded[name]

    def _load(self, point: EntryPoint) -> T:
        where = f"{_owner(point)}, declared as {point.name!r} in {self._group}"
        try:
            found: T = point.load()
        except (Exception, SystemExit) as error:  # (whatever a package does when imported)
            what = on_one_line(f"{type(error).__name__}: {error}")
            raise RoughbenchError(
                f"{where}, cannot be loaded ({what}); repair or uninstall it"
            ) from error
        if self._check is not None:
            return self._check(found, point.name, where)
        own_name = getattr(found, "name", point.name)
        if own_name != point.name:
            raise RoughbenchError(f"{where}, has the name {own_name!r}; give both one name")
        return found

    def __contains__(self, name: object) -> bool:
        return name in self._built_in or name in self._declared

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self._built_in, *self._declared]))

    def __len__(self) -> int:
        return len({*self._built_in, *self._declared})


def _owner(point: EntryPoint) -> str:
    owner = "roughbench" if point.value.startswith("roughbench.") else "a package"
    if point.dist is not None:
        owner = point.dist.name
    return f"{owner} ({point.value})"
