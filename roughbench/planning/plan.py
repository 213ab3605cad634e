"""What is to be computed: every experiment and model of a spec, and whether it can be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from roughbench.errors import SurfaceError
from roughbench.models.base import Model
from roughbench.observables import OBSERVABLES
from roughbench.planning.cells import NOTHING, Asked, Cell
from roughbench.planning.measured import Heights, read_heights
from roughbench.planning.samples import Surface, check_sample, draws_lines
from roughbench.spec import MeasuredSurface, Spec
from roughbench.variables import check_variables

LINES = 20
"""Lines with the spectrum of a measured surface, where no spec says how many."""


def plan(spec: Spec) -> list[Cell]:
    """Return the cells of a spec, in its order.

    A file with heights is read once: all that a run says of them, and computes with, is
    held to what was found here.

    Raises
    ------
    SurfaceError
        With every file that cannot be read.
    """
    experiments = spec.experiments()
    heights, faults = _read_files(experiments)
    if faults:
        raise SurfaceError("\n".join(faults))
    return [
        Cell(
            experiment=experiment,
            model=model.reduced(variant.modulus),
            surface=variant.surface,
            pressures=variant.pressures,
            n_realizations=_realizations(variant, model, heights),
            seed=variant.seed,
            asked=_asked(variant) if model.has_fields else NOTHING,
            heights=_known(variant.surface, heights),
            modulus=variant.modulus,
        )
        for experiment, variant in experiments
        for model in variant.models
    ]


def _read_files(
    experiments: Sequence[tuple[str, Spec]],
) -> tuple[dict[MeasuredSurface, Heights], list[str]]:
    heights: dict[MeasuredSurface, Heights] = {}
    faults: dict[str, str] = {}
    for name, spec in experiments:
        if not isinstance(spec.surface, MeasuredSurface):
            continue
        surface = spec.surface.original()
        if surface not in heights:
            lowest = min(min(other.pressures) for _, other in experiments)
            try:
                heights[surface] = read_heights(surface, pressure=lowest)
            except SurfaceError as error:
                faults.setdefault(str(error), name)
    return heights, [f"{name}: {fault}" for fault, name in faults.items()]


def _known(surface: Surface, heights: Mapping[MeasuredSurface, Heights]) -> Heights | None:
    return heights[surface.original()] if isinstance(surface, MeasuredSurface) else None


def check(cells: list[Cell]) -> None:
    """Refuse surfaces that a model cannot use, or that make the answer wrong, all at once.

    Raises
    ------
    SurfaceError
    """
    faults = dict(_doubts(cells, wrong=True))
    for cell in cells:
        try:
            check_sample(cell.surface, cell.model, cell.heights)
        except SurfaceError as error:
            faults.setdefault(str(error), str(cell))
    if faults:
        raise SurfaceError("\n".join(f"{where}: {fault}" for fault, where in faults.items()))


def warnings(cells: list[Cell]) -> list[str]:
    """Return what makes answers on measured surfaces doubtful: a line for each."""
    return [f"{where}: {text}" for text, where in _doubts(cells, wrong=False)]


def _doubts(cells: list[Cell], *, wrong: bool) -> list[tuple[str, str]]:
    """Return what is doubtful, or wrong, about measured surfaces, and the experiment."""
    found: dict[str, str] = {}
    for cell in cells:
        for doubt in cell.heights.doubts if cell.heights is not None else ():
            if doubt.is_wrong == wrong:
                found.setdefault(doubt.text, cell.experiment)
    return [*found.items()]


def _asked(spec: Spec) -> Asked:
    known = [*OBSERVABLES, *(one.name for one in spec.observed if one.name not in OBSERVABLES)]
    observables = tuple(sorted(spec.observed, key=lambda one: known.index(one.name)))
    check_variables(observables)
    if spec.save_fields is None:
        return Asked(observables)
    return Asked(observables, spec.kept_pressures, tuple(sorted(spec.save_fields.realizations)))


def _realizations(spec: Spec, model: Model, heights: Mapping[MeasuredSurface, Heights]) -> int:
    """One where there is no randomness; else the model's own number, or the spec's.

    Twins count as the spec says, and lines with the spectrum of a measured surface are
    :data:`LINES` where it says nothing.
    """
    if model.dimension == 0:
        return 1
    if isinstance(spec.surface, MeasuredSurface):
        known = heights[spec.surface.original()]
        if not draws_lines(model, known):
            return spec.twins or 1 if spec.surface.is_twins else 1
        if "realizations" not in spec.model_fields_set:
            return model.realizations or LINES
    return model.realizations or spec.realizations
