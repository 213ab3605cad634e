"""Finished tasks made into results, and into the results file, with where it comes from."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace

from roughbench.outputs import check_output
from roughbench.publish import put, refusals_named
from roughbench.results import MadeWhenAsked, ModelResult, Results
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.journal import log
from roughbench.runner.assemble import assemble
from roughbench.runner.made_with import made_with, written_with
from roughbench.runner.preparation import kind_of_results
from roughbench.runner.provenance import inputs_of, provenance, spent
from roughbench.runner.recording import records
from roughbench.runner.scan import CellState
from roughbench.seal import sha256_of
from roughbench.spec import Spec
from roughbench.store import written_results


def results_of(spec: Spec, cell_states: Sequence[CellState], *, kept: bool = True) -> Results:
    """Return the results; those of each model are made when asked for, unless ``kept``."""
    experiments: dict[str, dict[str, Callable[[], ModelResult]]] = {}
    for cell_state in cell_states:
        models = experiments.setdefault(cell_state.cell.experiment, {})
        models[cell_state.cell.model.name] = functools.partial(_model_result, cell_state)
    made = {name: MadeWhenAsked(models) for name, models in experiments.items()}
    return Results(
        {name: dict(models) for name, models in made.items()} if kept else made,
        spec.text,
        spec.sha256,
        spec.name,
        records([cell_state.cell for cell_state in cell_states]),
        written_with(),
    )


def _model_result(cell_state: CellState) -> ModelResult:
    result = replace(
        assemble(cell_state.cell, cell_state.collect()), made_with=made_with(cell_state)
    )
    cell_state.blocks.clear()  # they are in the result now
    total = spent(cell_state.usages)
    log.debug(
        "%s: %d tasks, %.1f s, peak memory %.2f GB, %d of %d states not converged",
        cell_state.cell,
        total["tasks"],
        total["seconds"],
        total["peak_memory"] / 1e9,
        cell_state.n_unconverged,
        cell_state.cell.n_states,
    )
    return result


def publish(
    folder: RunFolder, spec: Spec, cell_states: Sequence[CellState], command: str
) -> None:
    """Write the results file, unless it is what these shards have made before."""
    inputs = inputs_of(spec, cell_states)
    if folder.provenance().get("inputs_sha256") == inputs and folder.has_its_results():
        log.info("%s is up to date", folder.results)
        return
    results = results_of(spec, cell_states, kept=False)
    target = check_output(folder.results, kind_of_results(folder))
    with refusals_named(folder.results), written_results(results, target) as temporary:
        sha256 = sha256_of(temporary)
        same = target.is_file() and sha256_of(target) == sha256
        folder.write_provenance(provenance(sha256, inputs, spec, cell_states, command))
        if not same:
            check_output(target, kind_of_results(folder))  # again: it took a while
            put(temporary, target)
    log.info("%s is up to date" if same else "wrote %s", folder.results)
