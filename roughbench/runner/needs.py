"""What of results a figure is drawn from: which models, which quantities, whether fields."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from roughbench.planning.cells import NOTHING, Cell
from roughbench.quantities import QUANTITIES
from roughbench.results import Array, Results
from roughbench.runner.comparison import OF_SAMPLES

Missing = Callable[[Results], str | None]
"""What results lack for a figure; None for nothing."""


@dataclass(frozen=True, slots=True)
class Needs:
    """What of results is needed for something that is drawn from them.

    Attributes
    ----------
    models : frozenset of (str, str)
        Experiment and label.
    quantities : frozenset of str or None
        Variables; None for all.
    fields : bool
        Whether observables or fields are among it.
    """

    models: frozenset[tuple[str, str]]
    quantities: frozenset[str] | None
    fields: bool

    def narrowed(self, cells: list[Cell]) -> list[Cell]:
        """Return the cells that are needed, without observables where these are not."""
        wanted = [cell for cell in cells if (cell.experiment, cell.model.name) in self.models]
        return wanted if self.fields else [replace(cell, asked=NOTHING) for cell in wanted]


def needs_of(results: Results, lacks: Sequence[Missing]) -> Needs:
    """Return what figures need of results that have all of it.

    Found by leaving one thing after the other out, and asking each figure whether it misses
    it: a model is needed if the figure could be drawn of it alone, or not without it, and it
    gives a quantity that the figure misses.

    Parameters
    ----------
    results : Results
    lacks : sequence of callable
        For each figure, what results lack for it.
    """
    models: set[tuple[str, str]] = set()
    quantities: set[str] = set()
    fields, says_all = False, True
    for missing in lacks:
        own = {q for q in QUANTITIES if missing(_without(results, _of_quantity(q)))}
        has_fields = missing(_without(results, _of_fields)) is not None
        for experiment, result in results.models():
            key = (experiment, result.label)
            if own and not has_fields and not own.intersection(result.variables):
                continue
            alone = _restricted(results, lambda one: one == key)  # noqa: B023  (used at once)
            without = _restricted(results, lambda one: one != key)  # noqa: B023
            if missing(alone) is None or missing(without) is not None:
                models.add(key)
        says_all = says_all and bool(own or has_fields)
        quantities |= own
        fields = fields or has_fields
    if fields or not says_all:  # a figure that misses nothing may show anything
        return Needs(frozenset(models), None, fields=True)
    return Needs(frozenset(models), frozenset(quantities), fields=False)


def _restricted(results: Results, keep: Callable[[tuple[str, str]], bool]) -> Results:
    """Return the results of some models alone."""
    experiments = {
        experiment: {label: one for label, one in models.items() if keep((experiment, label))}
        for experiment, models in results.items()
    }
    filled = {name: models for name, models in experiments.items() if models}
    return replace(results, experiments=filled)


class _Others(Mapping[str, Array]):
    """Variables without some, read when they are asked for."""

    def __init__(self, variables: Mapping[str, Array], dropped: Callable[[str], bool]) -> None:
        self._variables = variables
        self._names = [name for name in variables if not dropped(name)]

    def __getitem__(self, name: str) -> Array:
        if name not in self._names:
            raise KeyError(name)
        return self._variables[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def _without(results: Results, dropped: Callable[[str], bool]) -> Results:
    """Return results without some of their variables."""
    return replace(
        results,
        experiments={
            experiment: {
                label: replace(one, variables=_Others(one.variables, dropped))
                for label, one in models.items()
            }
            for experiment, models in results.items()
        },
    )


def _of(name: str, variable: str) -> bool:
    """Whether a variable is of a quantity: its values, or their averages."""
    return variable == name or variable.startswith(f"{name}_")


def _of_quantity(name: str) -> Callable[[str], bool]:
    return lambda variable: _of(name, variable)


_WITHOUT_FIELDS = (*QUANTITIES, "status", "pressure", "realization", "n_converged", *OF_SAMPLES)


def _of_fields(variable: str) -> bool:
    """Whether a variable may have been taken from fields."""
    return not any(_of(name, variable) for name in _WITHOUT_FIELDS)
