"""A results file computed anew from the spec in it, and held against what it says."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roughbench.errors import SpecError, StoreError
from roughbench.results import Results
from roughbench.rundir.folder import RunFolder
from roughbench.runner.comparison import QuantityDeviation, compare
from roughbench.runner.driver import run_to_file
from roughbench.runner.needs import Missing, Needs, needs_of
from roughbench.runner.origins import changed_options, differences, origins
from roughbench.spec import Spec, load_spec
from roughbench.store import opened
from roughbench.text import on_one_line


@dataclass(frozen=True, slots=True)
class Reproduction:
    """What came of computing a results file anew.

    Attributes
    ----------
    results, reproduced : Path
        The file, and the one that was computed.
    deviations : list of QuantityDeviation
    faults : list of str
        What could not be compared.
    origins : list of str
        In what the two differ: versions, code, threads, options.
    origin_is_known : bool
        Whether anything tells by which versions the file was made.
    """

    results: Path
    reproduced: Path
    deviations: list[QuantityDeviation]
    faults: list[str]
    origins: list[str]
    origin_is_known: bool

    @property
    def agrees(self) -> bool:
        """Whether everything was compared, and is within what is allowed."""
        return (
            bool(self.deviations) and not self.faults and all(d.agrees for d in self.deviations)
        )

    def as_dict(self) -> dict[str, Any]:
        """Return all of it, for strict JSON: infinity is a text, nan None."""
        return {
            "results": str(self.results),
            "reproduced": str(self.reproduced),
            "agrees": self.agrees,
            "deviations": [one.as_dict() for one in self.deviations],
            "not_compared": self.faults,
            "differences": self.origins,
            "origin_is_known": self.origin_is_known,
        }


def reproduce(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    folder: str | os.PathLike[str] | None = None,
    lacks: Sequence[Missing] = (),
    tolerance: float | None = None,
    **options: Any,
) -> Reproduction:
    """Compute what is in a results file anew, from the spec in it, and compare.

    Parameters
    ----------
    path : path
        A results file, of this version or an earlier one.
    output : path
        Results file to write; resumes as a run does.
    folder : path, optional
        Where relative paths in the spec start; default: where the run was, if its run
        directory is there, else the folder of the results file.
    lacks : sequence of callable
        Compute only what these figures need.
    tolerance : float, optional
        Relative deviation that passes for agreement; default: as :func:`compare`.
    **options
        As of :func:`roughbench.run`: ``jobs``, ``threads``, ``max_memory``, ``force``,
        ``progress``, ``command``.

    Raises
    ------
    StoreError
        If it is no results file, or ``output`` is it.
    SpecError
        If this version does not understand the spec; what it could then mean is no guess.
    RoughbenchError
        As :func:`roughbench.run`.
    """
    source, target = Path(path), Path(output)
    with opened(source) as old:
        if target.exists() and target.samefile(source):
            raise StoreError(f"{target}: is the file to be reproduced; choose another with -o")
        spec = spec_in(old, source, folder)
        needs = needs_of(old, lacks) if lacks else None
        if needs is not None:
            options["narrowed"] = needs.narrowed
        run_to_file(spec, target, **options)
        with opened(target) as new:
            wanted: Collection[str] | None = needs.quantities if needs is not None else None
            deviations, faults = compare(old, new, quantities=wanted, tolerance=tolerance)
            faults += _absent(old, new, needs)
            before, after = origins(source), origins(target)
            changed = differences(before, after) + changed_options(old, new)
    return Reproduction(source, target, deviations, faults, changed, bool(before))


def spec_in(results: Results, path: Path, folder: str | os.PathLike[str] | None = None) -> Spec:
    """Return the spec that results were computed from, under their name.

    Raises
    ------
    SpecError
        If this version does not understand it, or files that it names are not there.
    """
    if folder is None:
        noted = RunFolder(path).request().get("folder")
        folder = noted if isinstance(noted, str) and Path(noted).is_dir() else path.parent
    text = results.spec_text
    try:
        spec = load_spec(text if "\n" in text else f"{text}\n", folder=folder)
    except SpecError as error:
        error.add_note(
            f"this is the spec in {on_one_line(str(path))}; files that it names are looked for "
            f"in {on_one_line(str(folder))} (--folder names another place)"
        )
        raise
    return spec.model_copy(update={"name": results.name})


def _absent(old: Results, new: Results, needs: Needs | None) -> list[str]:
    """Return the models that were to be computed, and are not there."""
    wanted = (
        needs.models
        if needs is not None
        else [(experiment, result.label) for experiment, result in old.models()]
    )
    return [
        f"{experiment}/{label}: the spec does not give it any more"
        for experiment, label in sorted(wanted)
        if label not in new.experiments.get(experiment, {})
    ]
