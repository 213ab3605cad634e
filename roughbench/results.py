"""What a run leaves: arrays by experiment, model and name, with their dimensions and units."""

from __future__ import annotations

import html
import json
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.ensemble import STATISTICS
from roughbench.errors import UnknownNameError
from roughbench.quantities import compared, modulus_power_of
from roughbench.spec.tree import did_you_mean
from roughbench.surface_record import SurfaceRecord as SurfaceRecord
from roughbench.units import in_words, prefix
from roughbench.variables import long_name_of, modulus_power, quantity_of, units_of

Array = NDArray[Any]
"""float64, float32, int64 or int32, as the results file knows them."""
Attribute = str | int | float

MODULUS = "contact_modulus"
"""Attribute of results with units: E*, Pa."""

MOST_LINES = 6
"""Experiments of a short text, and pressures or models of a small table."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ModelResult:
    """The curves of one model in one experiment.

    Attributes
    ----------
    label : str
        Name of the model in the results.
    kind, title : str
        Kind of the model in a spec, and its name in legends and tables.
    attributes : mapping of str to str, int or float
        ``length``, ``rms_height`` and ``rms_slope`` of the spectrum, the surface's and
        the model's parameters. Of a spec with units lengths are in m, and
        ``contact_modulus`` is E* in Pa.
    variables : mapping of str to ndarray
        Arrays by name; also ``result["area_mean"]``.
    described : mapping of str to (str, str)
        Unit and description of variables that only their file knows: those of packages that
        are not installed.
    """

    label: str
    kind: str
    title: str
    attributes: Mapping[str, Attribute]
    variables: Mapping[str, Array]
    described: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        if name not in self.variables:
            quantity = quantity_of(name)
            if quantity is not None and quantity not in self.variables:
                raise UnknownNameError(
                    f"{self.title} ({self.label}) does not give {name}: it "
                    f"knows no {long_name_of(quantity)}"
                )
            raise _unknown("variable", name, list(self.variables), self._names())
        return self.variables[name]

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    @property
    def n_realizations(self) -> int:
        """Number of realizations."""
        return int(self.variables["status"].shape[0])

    @property
    def n_states(self) -> int:
        """Number of states: realizations × pressures."""
        return int(self.variables["status"].size)

    @property
    def n_unconverged(self) -> int:
        """Number of states that did not converge and are left out of the averages."""
        return int(np.count_nonzero(self.variables["status"]))

    @property
    def is_random(self) -> bool:
        """Whether it looked at random heights, so that realizations differ."""
        if self.is_measured:
            return "drawn" in self.attributes
        return "grid_points" in self.attributes

    @property
    def is_measured(self) -> bool:
        """Whether its surface was measured, or its spectrum was."""
        return self.attributes.get("surface") in ("file", "scan")

    @property
    def warnings(self) -> tuple[str, ...]:
        """What makes answers on its measured surface doubtful, a sentence each."""
        try:
            found = json.loads(str(self.attributes.get("warnings", "[]")))
        except ValueError:
            return ()
        return tuple(map(str, found)) if isinstance(found, list) else ()

    @property
    def modulus(self) -> float | None:
        """Contact modulus E*, Pa; None without units, where pressures are p/E*."""
        found = self.attributes.get(MODULUS)
        return None if found is None else float(found)

    @property
    def has_units(self) -> bool:
        """Whether variables are in SI; else pressures are p/E*, lengths in any one unit."""
        return MODULUS in self.attributes

    def units(self, name: str) -> str:
        """Return the unit of a variable: "1" is none.

        With units it is one of SI, such as "Pa/m"; else "length" is the spec's length unit.
        """
        if name in self.described:
            return self.described[name][0]
        dimension = 1 if self.attributes.get("dimension") == 1 else 2
        return units_of(name, dimension, si=self.has_units)

    def long_name(self, name: str) -> str:
        """Return the description of a variable in words."""
        if name in self.described:
            return self.described[name][1]
        return long_name_of(name, si=self.has_units)

    def prefixed(self, name: str, of: str = "") -> tuple[float, str]:
        """Return a factor and a unit that suit all values of a variable, as nm for m.

        Parameters
        ----------
        name : str
        of : str
            Variable of the same unit that is shown; default: itself.
        """
        unit = self.units(name)
        if not self.has_units:
            return 1.0, unit
        return prefix(np.ravel(self[of or name]).tolist(), unit)

    def in_si(self, modulus: float) -> ModelResult:
        """Return what was computed with E* = 1 and lengths in m as of a contact modulus.

        Parameters
        ----------
        modulus : float
            E*, Pa.
        """
        attributes = {**self.attributes, MODULUS: float(modulus)}
        units = {name: unit for name, (unit, _) in self.described.items()}
        variables = dict(_Scaled(self.variables, float(modulus), units))
        return replace(self, attributes=attributes, variables=variables)

    def reduced(self) -> ModelResult:
        """Return these results without units: p/E*, K/E* and U/(A0 E*), lengths in m.

        What compares models, and laws between dimensionless numbers, works with these. They
        are themselves where there are no units.
        """
        if self.modulus is None:
            return self
        attributes = {name: one for name, one in self.attributes.items() if name != MODULUS}
        units = {name: unit for name, (unit, _) in self.described.items()}
        variables = _Scaled(self.variables, 1.0 / self.modulus, units)
        return replace(self, attributes=attributes, variables=variables)

    def __repr__(self) -> str:
        many = f"{self.n_realizations} realization{'s' * (self.n_realizations != 1)}"
        head = f"ModelResult {self.label!r}: {self.title}, {many}, {_extent(self)}"
        names = f"variables: {', '.join(self._names())}"
        shown = textwrap.wrap(names, 88, max_lines=3, placeholder=" …")
        return "\n".join([head, *(f"  {line}" for line in shown)])

    def _repr_html_(self) -> str:
        shown = [name for name in compared() if f"{name}_mean" in self]
        pressure = np.asarray(self["pressure"], float)
        chosen = np.linspace(0, pressure.size - 1, min(MOST_LINES, pressure.size))
        per_pascal, unit = self.prefixed("pressure")
        scales = {name: self.prefixed(name, f"{name}_mean") for name in shown}
        rows = [
            [
                f"{pressure[k] * per_pascal:.3g}",
                *(_mean(self, name, int(k), scales[name][0]) for name in shown),
            ]
            for k in chosen.round().astype(int)
        ]
        words = [f"{self.long_name(name)}, {scales[name][1]}" for name in shown]
        first = f"p, {unit}" if self.has_units else "p/E*"
        headings = [first, *(text.removesuffix(", 1") for text in words)]
        left_out = pressure.size - len(rows)
        note = f"{left_out} more pressures" if left_out else ""
        return _table(repr(self).splitlines()[0], headings, rows, note)

    def _names(self) -> list[str]:
        """Return the variables without those that are statistics of another."""
        ends = tuple(f"_{statistic}" for statistic in STATISTICS)
        return [name for name in self.variables if not name.endswith(ends)]


class _Scaled(Mapping[str, Array]):
    """Variables times E* to the power that each has of it; made whenever one is asked for.

    Of a variable that only its file knows, its unit tells the power.
    """

    def __init__(
        self,
        variables: Mapping[str, Array],
        modulus: float,
        units: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._variables, self._modulus, self._units = variables, modulus, units

    def __getitem__(self, name: str) -> Array:
        values = self._variables[name]
        power = (
            modulus_power_of(self._units[name]) if name in self._units else modulus_power(name)
        )
        return values * self._modulus**power if power else values

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)


class Models(dict[str, ModelResult]):
    """The models of one experiment, by label."""

    def __missing__(self, label: str) -> ModelResult:
        raise _unknown("model", label, list(self))


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
    """

    experiments: Mapping[str, Mapping[str, ModelResult]]
    spec_text: str
    spec_sha256: str
    name: str = ""
    surfaces: Mapping[str, SurfaceRecord] = field(default_factory=dict)

    def __getitem__(self, experiment: str) -> Mapping[str, ModelResult]:
        if experiment not in self.experiments:
            raise _unknown("experiment", experiment, list(self.experiments))
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
        lines = [self._head()]
        for name, models in list(self.experiments.items())[:MOST_LINES]:
            labels = (f"{label} ({one.n_realizations})" for label, one in models.items())
            words = f"{name}: {', '.join(labels)}"
            lines.append(textwrap.shorten(words, 96, placeholder=" …"))
        if len(self) > MOST_LINES:
            lines.append(f"… {len(self) - MOST_LINES} more")
        return "\n  ".join(lines)

    def _repr_html_(self) -> str:
        rows = [
            [
                experiment,
                one.label,
                one.title,
                str(one.n_realizations),
                _extent(one),
                f"{one.n_states - one.n_unconverged} of {one.n_states}",
            ]
            for experiment, one in self.models()
        ]
        most = 2 * MOST_LINES
        headings = ["experiment", "label", "model", "realizations", "pressures", "converged"]
        note = f"{len(rows) - most} more models" if len(rows) > most else ""
        return _table(self._head(), headings, rows[:most], note)

    def _head(self) -> str:
        many = f"{len(self)} experiment{'s' * (len(self) != 1)}"
        return f"Results {self.name!r}: {many}, label (realizations)"


def _unknown(
    kind: str, name: object, known: Sequence[str], shown: Sequence[str] | None = None
) -> UnknownNameError:
    """Return the error for a name that is not there, with the one that was probably meant."""
    hint = did_you_mean(str(name), known)
    if not hint.startswith(" (did"):
        hint = did_you_mean("", shown or known)
    return UnknownNameError(f"no {kind} is named {name!r}{hint}")


def _extent(result: ModelResult) -> str:
    """Return how many pressures there are, and between which."""
    pressure = np.asarray(result.variables["pressure"], float)
    if pressure.size == 0:
        return "no pressures"
    low, high = (
        in_words(p, "Pa") if result.has_units else f"{p:.3g}"
        for p in (pressure.min(), pressure.max())
    )
    symbol = "p" if result.has_units else "p/E*"
    if pressure.size == 1:
        return f"1 pressure, {symbol} = {low}"
    return f"{pressure.size} pressures, {symbol} = {low} … {high}"


def _mean(result: ModelResult, name: str, k: int, factor: float) -> str:
    mean, error = (float(result[f"{name}_{kind}"][k]) * factor for kind in ("mean", "sem"))
    return f"{mean:.4g} ± {error:.2g}" if np.isfinite(error) else f"{mean:.4g}"


def _table(
    caption: str, headings: Sequence[str], rows: Sequence[Sequence[str]], note: str
) -> str:
    """Return a small table as HTML, for notebooks."""

    def cells(texts: Sequence[str], tag: str) -> str:
        inner = "".join(f"<{tag}>{html.escape(text)}</{tag}>" for text in texts)
        return f"<tr>{inner}</tr>"

    body = "".join(cells(row, "td") for row in rows)
    return (
        f"<table><caption>{html.escape(caption)}</caption>"
        f"<thead>{cells(headings, 'th')}</thead><tbody>{body}</tbody></table>"
        + (f"<p>{html.escape(note)}</p>" if note else "")
    )
