"""Which models there are: built in, from installed packages, from files.

A built-in model stands in a table, one from a package in its entry points, group
``roughbench.models``: ``erf09 = "mytheory:Erf09"``. Both are loaded, and checked, by the same
registry when their kind is asked for.
"""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar, get_args

from roughbench.errors import ModelError, RoughbenchError
from roughbench.models.base import Curve, FloatArray, Model, Needs, Sample
from roughbench.registry import Registry
from roughbench.source_files import load_reference, names_file, origin_of

GROUP = "roughbench.models"
BUILT_IN: Mapping[str, str] = {
    "bem": "roughbench.models.halfspace:HalfSpace",
    "foundation": "roughbench.models.foundation:Foundation",
    "line": "roughbench.models.line:Line",
    "persson": "roughbench.models.persson:Persson",
    "winkler": "roughbench.models.winkler:Winkler",
    "gw": "roughbench.models.gw:GreenwoodWilliamson",
    "gw_elliptic": "roughbench.models.gw_elliptic:Elliptic",
    "bgt": "roughbench.models.bgt:BushGibsonThomas",
    "hertz_top": "roughbench.models.hertz_top:HertzTop",
}
"""Kind in the spec → module and class."""

_KIND = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]*")
_RESERVED = {
    *("surface", "length", "seed", "title", "source", "style", "dimension"),
    *("rms_height", "rms_slope", "hurst", "q_min", "q_rolloff", "q_max", "below_rolloff"),
    *("amplitude", "grid_points", "grid_columns"),
}
"""Attributes that results have beside the options of a model."""


def kinds() -> list[str]:
    """Return every kind that is built in or installed; none is imported for it."""
    return list(MODELS)


def load(kind: str) -> type[Model]:
    """Return the model of a kind that is built in or installed.

    Raises
    ------
    ModelError
        If it cannot be imported, is no model, or two packages declare it.
    KeyError
        If there is no such kind.
    """
    try:
        return MODELS[kind]
    except ModelError:
        raise
    except RoughbenchError as error:
        raise ModelError(str(error)) from error


def checked(found: object, where: str) -> type[Model]:
    """Return a class that is a model, with all that a model has to declare.

    Raises
    ------
    ModelError
        That says what is missing, and where.
    """
    if not (isinstance(found, type) and issubclass(found, Model)):
        raise ModelError(f"{where} is not a subclass of roughbench.Model")
    if inspect.isabstract(found):
        missing = ", ".join(sorted(found.__abstractmethods__))
        raise ModelError(f"{where} lacks {missing}; see docs/adding-a-model.md")
    if found.curve is Model.curve and found.states is Model.states:
        raise ModelError(f"{where} lacks curve, or states; see docs/adding-a-model.md")
    field = found.model_fields.get("kind")
    values = get_args(field.annotation) if field else ()
    if len(values) != 1 or field is None or field.default != values[0]:
        word = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", found.__name__).lower()
        raise ModelError(f'{where} lacks its kind: Literal["{word}"] = "{word}"')
    if not isinstance(values[0], str) or not _KIND.fullmatch(values[0]):
        raise ModelError(
            f"{where}: its kind must have a letter or digit first, then letters, digits and "
            f"any of _.+-, got {values[0]!r}"
        )
    needs = inspect.getattr_static(found, "needs")
    if isinstance(needs, str) and needs not in get_args(Needs):
        raise ModelError(
            f"{where}: needs must be {' or '.join(get_args(Needs))}, got {needs!r}"
        )
    if taken := sorted(_RESERVED & set(found.model_fields)):
        raise ModelError(
            f"{where}: results have an attribute {taken[0]!r} already; rename the option"
        )
    return found


def _of_kind(found: object, kind: str, where: str) -> type[Model]:
    model = checked(found, where)
    if kind_of(model) != kind:
        raise ModelError(f"{where}, is of kind {kind_of(model)!r}; give both one name")
    return model


MODELS: Registry[type[Model]] = Registry(GROUP, declared=BUILT_IN, check=_of_kind)
"""Kind in the spec → model; a model is imported when it is asked for."""


def kind_of(model: type[Model]) -> str:
    """Return the kind of a model that :func:`checked` has let pass."""
    return str(model.model_fields["kind"].default)


def source_of(model: Model) -> str:
    """Return where a model from outside comes from, as ``mytheory.py:Erf09``; else empty."""
    if model.reference:
        return model.reference
    target = f"{type(model).__module__}:{type(model).__qualname__}"
    return "" if BUILT_IN.get(model.kind) == target else target


@functools.cache
def declared(kind: str) -> type[Model] | None:
    """Return the model of a kind that results name; None if it cannot be had here."""
    try:
        return load(kind)
    except (KeyError, ModelError):
        return None


def is_theory(kind: str) -> bool:
    """Whether models of a kind never look at heights, but at the spectrum alone."""
    model = declared(kind)
    return model is not None and inspect.getattr_static(model, "needs") == "spectrum"


def is_reference(kind: str) -> bool:
    """Whether others are compared with models of a kind, the exact solution."""
    model = declared(kind)
    return model is not None and model.is_reference


def presses_lines(kind: str, attributes: Mapping[str, object]) -> bool:
    """Return whether results are of a model on lines, not on surfaces.

    Parameters
    ----------
    kind : str
    attributes : mapping
        Of the results: ``dimension``, where they have it, is that of a model that is not here.

    Examples
    --------
    >>> presses_lines("foundation", {}), presses_lines("bem", {})
    (True, False)
    >>> presses_lines("unknown", {"dimension": 1})
    True
    """
    if "dimension" in attributes:
        return attributes["dimension"] == 1
    model = declared(kind)
    return model is not None and inspect.getattr_static(model, "needs", "") == "line"


def has_option(kind: str, name: str) -> bool:
    """Whether models of a kind have an option of this name.

    Examples
    --------
    >>> has_option("winkler", "heights"), has_option("bem", "heights")
    (True, False)
    """
    model = declared(kind)
    return model is not None and name in model.model_fields


def is_modified(kind: str, attributes: Mapping[str, object]) -> bool:
    """Whether results are of a model with options that make another one of its kind.

    Parameters
    ----------
    kind : str
    attributes : mapping
        Of the results: what the options say.

    Examples
    --------
    >>> is_modified("bem", {"screening": 8.0}), is_modified("bem", {"grid": 512})
    (True, False)
    """
    model = declared(kind)
    return model is not None and any(
        name in attributes and attributes[name] != model.model_fields[name].default
        for name in model.modifying
    )


class Unavailable(Model, extra="allow"):
    """Stands for a model that is not here, where only what the spec says counts."""

    needs: ClassVar[Needs] = "spectrum"
    title: ClassVar[str] = "not available here"

    kind: str

    def curve(self, sample: Sample, pressures: FloatArray) -> Curve:
        """Refuse: nothing can be computed."""
        del sample, pressures
        raise ModelError(f"the model {self.kind!r} is not here")


class Catalog:
    """Finds the models that a spec names.

    Parameters
    ----------
    folder : Path
        Where relative paths of Python files start.
    outside : mapping of str to str, optional
        Read the spec only for what it says, as that of results, and run no file for it:
        ``kind`` of a model from outside as the spec names it → its own kind. What is neither
        among them nor here is :class:`Unavailable`.
    """

    def __init__(self, folder: Path = Path(), outside: Mapping[str, str] | None = None) -> None:
        self.folder = folder
        self.outside = outside

    def find(self, kind: str) -> type[Model]:
        """Return the model that a spec means by ``kind``.

        Raises
        ------
        ModelError
            If it cannot be loaded.
        KeyError
            If there is no such kind.
        """
        if self.outside is not None and (names_file(kind) or declared(kind) is None):
            return Unavailable
        if not names_file(kind):
            return load(kind)
        model = checked(load_reference(kind, self.folder, Model), Path(kind).name)
        if kind_of(model) in BUILT_IN:
            raise ModelError(
                f"{Path(kind).name} has the kind {kind_of(model)!r}, which roughbench has; "
                "choose another"
            )
        return model

    def own_kind(self, kind: str) -> str:
        """Return the kind of the model itself, by which it is called: ``erf09``."""
        if not names_file(kind):
            return kind
        if self.outside is not None:
            return self.outside.get(kind, kind)
        try:
            return kind_of(self.find(kind))
        except ModelError:
            return kind


__all__ = [
    "BUILT_IN",
    "GROUP",
    "MODELS",
    "Catalog",
    "Unavailable",
    "declared",
    "is_modified",
    "origin_of",
]
