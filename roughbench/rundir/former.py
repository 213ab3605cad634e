"""Identities that nobody uses any more, and which of them something new was made from."""

from __future__ import annotations

from collections.abc import Iterable

from roughbench.rundir.folder import RunFolder
from roughbench.rundir.identity import Identity, changes, key_of

_MOST_CHANGES = 4
_MOST_COMPARED = 50
"""Identities to compare one with that has no obvious predecessor: it is for words only."""


class FormerIdentities:
    """The identities of shards that no cell uses, each read once."""

    def __init__(self, folder: RunFolder, keys: Iterable[str]) -> None:
        self._folder = folder
        self._keys = sorted(keys)
        self._by_kind: dict[object, list[Identity]] | None = None
        self._by_rest: dict[str, list[Identity]] = {}

    def what_changed(self, new: Identity) -> str:
        """Say what differs between an identity and the nearest of these, if there is one."""
        nearest: list[str] | None = None
        for before in self._candidates(new):
            differences = changes(before, new)
            if nearest is None or len(differences) < len(nearest):
                nearest = differences
        if not nearest:
            return "new"
        more = len(nearest) - _MOST_CHANGES
        shown = nearest[:_MOST_CHANGES] + ([f"and {more} more"] if more > 0 else [])
        return "changed: " + ", ".join(shown)

    def _candidates(self, new: Identity) -> list[Identity]:
        """Return those that differ in one value; else the first few of this kind.

        To look these up keeps the effort proportional to the number of cells.
        """
        if self._by_kind is None:
            self._by_kind = self._read()
        alike = [before for rest in _rests(new) for before in self._by_rest.get(rest, ())]
        return alike or self._by_kind.get(new["model.kind"], [])[:_MOST_COMPARED]

    def _read(self) -> dict[object, list[Identity]]:
        found: dict[object, list[Identity]] = {}
        for key in self._keys:
            identity = self._folder.identity(key)
            if identity is not None and key_of(identity) == key:
                found.setdefault(identity.get("model.kind"), []).append(identity)
                for rest in _rests(identity):
                    self._by_rest.setdefault(rest, []).append(identity)
        return found


def _rests(identity: Identity) -> list[str]:
    """Return for each value a digest of all the others."""
    return [
        f"{name} {key_of({other: value for other, value in identity.items() if other != name})}"
        for name in identity
    ]
