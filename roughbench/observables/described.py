"""Observables as results files describe them: to be drawn where their code is not.

A result carries one attribute for each observable from outside, ``observable_NAME``, with all
that a figure needs; what stands at its values, ``NAME_bin`` and so on, is in the file anyway.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from roughbench.errors import SolverError, StoreError
from roughbench.observables.base import Observable
from roughbench.observables.fields import Field, Profile
from roughbench.quantities import Variable
from roughbench.source_files import origin_of
from roughbench.text import on_one_line

PREFIX = "observable_"
"""Of the attributes."""
_TEXTS = ("name", "variable", "title", "x", "y", "source", "theory_title")


class DescribedObservable(Observable):
    """What a results file says about an observable from outside.

    Attributes
    ----------
    source : str
        File and class, or module and class, that it came from.
    """

    source: str
    _theory_title: str

    def __init__(self, text: str) -> None:
        """Take up what :func:`description` returned.

        Raises
        ------
        ValueError
            If it is none.
        """
        try:
            given: dict[str, Any] = json.loads(text)
            texts = {name: on_one_line(_text(given[name])) for name in _TEXTS}
            self._theory_title = texts.pop("theory_title")
            vars(self).update(
                **texts,
                x_is_log=bool(given["x_is_log"]),
                is_in_heights=bool(given["heights"]),
                values=_variable(given["values"]),
                places=_variable(given["places"]),
                scalars={name: _variable(one) for name, one in given["scalars"].items()},
                attributes=tuple(_text(name) for name in given["attributes"]),
            )
        except (KeyError, TypeError, AttributeError, RecursionError) as error:
            raise ValueError(f"describes no observable: {error}") from None

    def compute(self, field: Field) -> Profile:
        """Refuse: the code is not here."""
        del field
        raise SolverError(f"the observable {self.name} of {self.source} is not here")

    def theory_title(self, attributes: Mapping[str, object]) -> str:
        """Return how it called Persson's theory."""
        del attributes
        return self._theory_title


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is no text")
    return value


def _variable(given: Mapping[str, Any]) -> Variable:
    powers = ("length", "per_dimension", "modulus")
    return Variable(
        on_one_line(_text(given["long_name"])), **{name: int(given[name]) for name in powers}
    )


def is_outside(observable: Observable) -> bool:
    """Whether an observable is of a file or a package, and not of roughbench."""
    return not type(observable).__module__.startswith("roughbench.")


def source_of(observable: Observable) -> str:
    """Return where an observable comes from: file, or module, and class."""
    kind = type(observable)
    if origin := origin_of(kind):
        return f"{origin.files.main}:{origin.name}"
    return f"{kind.__module__}:{kind.__qualname__}"


def description(observable: Observable, attributes: Mapping[str, object]) -> str:
    """Return all that a figure needs to know of an observable, as JSON.

    Parameters
    ----------
    observable : Observable
    attributes : mapping
        Of the result that has it.
    """
    return json.dumps(
        {
            "name": observable.name,
            "variable": observable.variable,
            "title": observable.title,
            "x": observable.x,
            "y": observable.y,
            "x_is_log": observable.x_is_log,
            "heights": observable.is_in_heights,
            "values": asdict(observable.values),
            "places": asdict(observable.places),
            "scalars": {name: asdict(one) for name, one in observable.scalars.items()},
            "attributes": list(observable.attributes),
            "theory_title": observable.theory_title(attributes),
            "source": source_of(observable),
        },
        ensure_ascii=False,
    )


def described(attributes: Mapping[str, object]) -> list[DescribedObservable]:
    """Return the observables from outside that the attributes of a result describe.

    Raises
    ------
    StoreError
        If one of them, of a file that somebody has changed, describes none.
    """
    found = []
    for name, text in attributes.items():
        if name.startswith(PREFIX):
            try:
                found.append(DescribedObservable(str(text)))
            except ValueError as error:
                raise StoreError(f"attribute {name} {error}; compute it again") from None
    return found
