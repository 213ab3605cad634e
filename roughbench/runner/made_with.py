"""What a results file says of its making: versions, code, transforms, threads, platform.

No times, and no names of machines: the same results have the same bytes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from roughbench.rundir.identity import Identity, assembly_digest
from roughbench.rundir.usage import PACKAGES, machine
from roughbench.runner.scan import CellState

_OF_MACHINES = ("python", *PACKAGES, "platform")


def made_with(cell_state: CellState) -> dict[str, str | int]:
    """Return what made the states of a model, as its group in a results file says it.

    Returns
    -------
    dict
        The version of each package, ``python`` and ``platform``, all of them where shards
        were made with several; ``code``, ``fft`` and ``threads`` of the model's identity,
        the latter two where numbers depend on them.
    """
    machines = [usage["machine"] for usage in cell_state.usages]
    return _of(machines) | _of_identity(cell_state.identity)


def written_with() -> dict[str, str | int]:
    """Return what puts a results file together here and now, as its root says it."""
    return _of([machine()]) | {"code": assembly_digest()[:12]}


def _of(machines: Sequence[Mapping[str, str]]) -> dict[str, str | int]:
    known = {name: {its[name] for its in machines if name in its} for name in _OF_MACHINES}
    return {name: " and ".join(sorted(found)) for name, found in known.items() if found}


def _of_identity(identity: Identity) -> dict[str, str | int]:
    of_text = {name: str(identity[name]) for name in ("code", "fft") if name in identity}
    return of_text | {name: int(identity[name]) for name in ("threads",) if name in identity}
