"""The states of a cell → the variables of one group of the results."""

from __future__ import annotations

import numpy as np

from roughbench.engines import observing
from roughbench.ensemble import STATISTICS, harmonic_mean, summarize
from roughbench.models.base import Status
from roughbench.planning.cells import Cell
from roughbench.planning.samples import describe
from roughbench.planning.tasks import Block
from roughbench.quantities import QUANTITIES
from roughbench.results import Array, ModelResult
from roughbench.variables import dimensions


def assemble(cell: Cell, block: Block) -> ModelResult:
    """Summarize the states of a cell, in the order of the realizations.

    Parameters
    ----------
    cell : Cell
    block : dict of str to ndarray
        All of its states.

    Returns
    -------
    ModelResult
        Summaries leave out the states that did not converge; ``n_converged`` counts
        those that did. In SI, if the spec has units: up to here everything is computed and
        kept with E* = 1.
    """
    variables: dict[str, Array] = {"pressure": cell.pressure_array()}
    variables |= {
        name: values
        for name, values in block.items()
        if dimensions(name, values.ndim) == (name,)
    }
    variables |= _positions(cell, block)
    variables |= block
    converged = variables["status"] == Status.CONVERGED
    variables["n_converged"] = converged.sum(axis=0, dtype=np.int64)
    for name in QUANTITIES:
        if name in variables:
            summary = summarize(variables[name], converged)
            for statistic in STATISTICS:
                variables[f"{name}_{statistic}"] = getattr(summary, statistic)
    for name, quantity in QUANTITIES.items():
        if quantity.has_harmonic_mean and name in variables:
            variables[f"{name}_harmonic"] = harmonic_mean(variables[name], converged)
    variables |= observing.averages(cell, variables, converged)
    result = ModelResult(
        label=cell.model.name,
        kind=cell.model.kind,
        title=cell.model.title,
        attributes=describe(cell.surface, cell.model, cell.heights)
        | {"seed": cell.seed}
        | observing.attributes(cell),
        variables=variables,
        described=observing.described(cell),
    )
    return result if cell.modulus is None else result.in_si(cell.modulus)


def _positions(cell: Cell, block: Block) -> dict[str, Array]:
    """Return where the points of the fields are, length."""
    if "field_pressure" not in block:
        return {}
    shape = block["field_pressure"].shape[1:]
    spacing = cell.length / shape[0]
    axes = dimensions("field_pressure", 1 + len(shape))[1:]
    return {
        axis: spacing * np.arange(n, dtype=np.float64)
        for axis, n in zip(axes, shape, strict=True)
    }
