"""What a run leaves: the curves of every model, by experiment and label."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, overload

from roughbench.results import display, tabular
from roughbench.results.model_result import ModelResult
from roughbench.surface_record import SurfaceRecord

if TYPE_CHECKING:
    from roughbench.labelled import DataFrame, Dataset, DataTree


class Models(dict[str, ModelResult]):
    """The models of one experiment, by label."""

    def __missing__(self, label: str) -> ModelResult:
        raise display.unknown_name("model", label, list(self))


class MadeWhenAsked(Mapping[str, ModelResult]):
    """Results of models that are made whenever one is asked for, and not kept.

    Parameters
    ----------
    make : mapping of str to callable
        By label.
    """

    def __init__(self, make: Mapping[str, Callable[[], ModelResult]]) -> None:
        self._make = make

    def __getitem__(self, label: str) -> ModelResult:
        return self._make[label]()

    def __iter__(self) -> Iterator[str]:
        return iter(self._make)

    def __len__(self) -> int:
        return len(self._make)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Results(Mapping[str, Mapping[str, ModelResult]]):
    """The results of a run: ``results["main"]["bem"]["area_mean"]``.

    Attributes
    ----------
    experiments : mapping of str to mapping of str to ModelResult
        By experiment (``main`` without a sweep) and label, in the order of the spec.
    spec_text : str
        The spec as YAML.
    spec_sha256 : str
        Hash of the resolved spec.
    name : str
        Name of the run.
    surfaces : mapping of str to SurfaceRecord
        By experiment: the measured surface that it pressed, of those that pressed one.
    made_with : mapping of str to str or int
        What the file was put together with: as :attr:`ModelResult.made_with`.
    partial : mapping of str to (int, int)
        Of a run that is not finished: model, such as ``main/bem`` → realizations there are, of
        how many; of those models that lack some. Empty for whole results.
    """

    experiments: Mapping[str, Mapping[str, ModelResult]]
    spec_text: str
    spec_sha256: str
    name: str = ""
    surfaces: Mapping[str, SurfaceRecord] = field(default_factory=dict)
    made_with: Mapping[str, str | int] = field(default_factory=dict)
    partial: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    def __getitem__(self, experiment: str) -> Mapping[str, ModelResult]:
        if experiment not in self.experiments:
            raise display.unknown_name("experiment", experiment, list(self.experiments))
        return Models(self.experiments[experiment])

    def __iter__(self) -> Iterator[str]:
        return iter(self.experiments)

    def __len__(self) -> int:
        return len(self.experiments)

    @property
    def has_units(self) -> bool:
        """Whether variables are in SI; a file has units everywhere or nowhere."""
        return next((result.has_units for _, result in self.models()), False)

    def reduced(self) -> Results:
        """Return these results without units, see :meth:`ModelResult.reduced`."""
        if not self.has_units:
            return self
        experiments = {
            experiment: {label: result.reduced() for label, result in models.items()}
            for experiment, models in self.experiments.items()
        }
        return replace(self, experiments=experiments)

    def models(self) -> Iterator[tuple[str, ModelResult]]:
        """Every (experiment, result), in the order of the spec."""
        for experiment, models in self.experiments.items():
            for result in models.values():
                yield experiment, result

    @overload
    def to_xarray(self, label: str) -> Dataset: ...

    @overload
    def to_xarray(self, label: None = None) -> DataTree: ...

    def to_xarray(self, label: str | None = None) -> Dataset | DataTree:
        """Return the results as xarray's datasets, with the sweep as dimensions.

        A key of the sweep is a dimension by its last word, ``surface.qr`` as ``qr``, if all
        combinations of its values are there; else ``experiment`` is one. What only some of
        the experiments have is nan in the others.

        Parameters
        ----------
        label : str, optional
            Of a model; default: a tree of all models, ``results.to_xarray()["bem"]``.

        Raises
        ------
        UnknownNameError
            If no experiment has this model.
        RoughbenchError
            Without xarray, or if the experiments have no common array.

        Examples
        --------
        >>> import roughbench as rb
        >>> results = rb.run({
        ...     "surface": {"H": 0.7, "q0": 1.0, "q1": 64.0, "slope": 0.1},
        ...     "pressures": [1e-3, 1e-2],
        ...     "models": [{"kind": "persson"}],
        ...     "sweep": {"surface.qr": [1.0, 8.0]},
        ... })
        >>> persson = results.to_xarray("persson")
        >>> persson.separation_mean.dims
        ('qr', 'pressure')
        >>> float(persson.area_mean.sel(qr=8.0, pressure=1e-3).round(5))
        0.01596
        """
        return tabular.results_tree(self) if label is None else tabular.swept(self, label)

    def to_frame(self, *, averages: bool = True) -> DataFrame:
        """Return all curves as one table of pandas, a row for every pressure.

        Parameters
        ----------
        averages : bool
            Over the realizations; else a row for every realization at every pressure.

        Returns
        -------
        DataFrame
            With the columns ``experiment``, ``model`` and those of the sweep, and nan where
            a model does not give a quantity; units in ``frame.attrs["units"]``.

        Raises
        ------
        RoughbenchError
            Without pandas.

        Examples
        --------
        >>> import roughbench as rb
        >>> results = rb.run({
        ...     "surface": {"H": 0.7, "q0": 1.0, "q1": 64.0, "slope": 0.1},
        ...     "pressures": [1e-3, 1e-2],
        ...     "models": [{"kind": "persson"}],
        ... })
        >>> frame = results.to_frame()
        >>> frame[["model", "pressure", "area_mean"]].round(5).values.tolist()
        [['persson', 0.001, 0.01596], ['persson', 0.01, 0.15852]]
        """
        return tabular.results_frame(self, averages=averages)

    @property
    def outside_kinds(self) -> dict[str, str]:
        """Kind of each model from outside, by what the spec may call it."""
        models = [result for _, result in self.models()]
        return {
            str(result.attributes["source"]): result.kind
            for result in models
            if "source" in result.attributes
        }

    def __repr__(self) -> str:
        return display.results_text(self)

    def _repr_html_(self) -> str:
        return display.results_table(self)
