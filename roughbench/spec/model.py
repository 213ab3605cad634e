"""The frozen spec that everything downstream works from."""

from __future__ import annotations

import copy
import functools
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, Field, PrivateAttr

from roughbench.models.base import MOST_REALIZATIONS
from roughbench.models.registry import Catalog
from roughbench.observables import Observable
from roughbench.spec import sweep
from roughbench.spec.fields import Observables, SavedFields, observables_of
from roughbench.spec.measured import MeasuredSurface, ScanSurface
from roughbench.spec.models import AnyModel, catalog_of
from roughbench.spec.modulus import Modulus, contact_modulus
from roughbench.spec.pressures import Pressures, nearest, values_of
from roughbench.spec.strict import STRICT
from roughbench.spec.surfaces import Surface
from roughbench.spec.tree import freeze
from roughbench.spec.with_units import Spelled, spelled
from roughbench.spec.yaml12 import dump

_NOT_COMPUTED = {"name", "sweep"}
"""Keys that the numbers of an experiment do not depend on."""


class Spec(BaseModel):
    """What to compute: surfaces, pressures, models, how many realizations.

    Made by :func:`roughbench.spec.load_spec`, which checks all of it and says where the
    faults are. Two specs are equal when they ask for the same computation.
    """

    model_config = STRICT

    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_.+-]*$",
        max_length=100,
        description="Names the run and its files; default: the name of the spec's file.",
    )
    surface: Surface = Field(description="The roughness.")
    given_pressures: Pressures = Field(
        alias="pressures", description="Pressures p/E*: a range, or a list."
    )
    given_modulus: Modulus | None = Field(
        default=None,
        alias="modulus",
        description="Contact modulus, in a spec with units: {E: 2.5 GPa, nu: 0.5} of a body on "
        "a rigid one, a list of two bodies, or {E*: 3.33 GPa}.",
    )
    realizations: int = Field(
        default=1, ge=1, le=MOST_REALIZATIONS, description="Surfaces in the ensemble."
    )
    seed: int = Field(default=0, ge=0, description="Seed of the random phases.")
    models: tuple[AnyModel, ...] = Field(min_length=1, description="The contenders.")
    sweep: Mapping[str, tuple[Any, ...]] = Field(
        default={},
        description="Key path → list of values; every combination is one experiment.",
    )
    observables: Observables | None = Field(
        default=None,
        description="What is taken from the fields of every state; default: nothing.",
    )
    save_fields: SavedFields | None = Field(
        default=None,
        description="States whose pressure and gap are kept; default: none.",
    )
    twins: int | None = Field(
        default=None,
        ge=1,
        le=MOST_REALIZATIONS,
        description=(
            "Further surfaces with the waves of a measured one and random phases, as an "
            "experiment of their own."
        ),
    )

    _text: str | None = PrivateAttr(default=None)
    _written: Mapping[str, Any] | None = PrivateAttr(default=None)
    _folder: Path = PrivateAttr(default=Path())
    _catalog: Catalog = PrivateAttr(default_factory=Catalog)
    _observed: tuple[Observable, ...] = PrivateAttr(default=())

    def model_post_init(self, context: Any) -> None:
        """Keep the text and the folder of the file that the spec came from."""
        if isinstance(context, dict):
            self._text = context.get("text")
            self._written = context.get("written")
            self._folder = Path(context.get("folder", ""))
            self._catalog = catalog_of(context)
        self._observed = tuple(observables_of(self.observables or (), self._catalog))

    @property
    def observed(self) -> tuple[Observable, ...]:
        """The observables that it names; those of files as they were when it was read."""
        return self._observed

    @property
    def folder(self) -> Path:
        """Where relative paths start, of files with heights and with models."""
        return self._folder

    @property
    def modulus(self) -> float | None:
        """Contact modulus E*, Pa; None for a spec without units, where it is 1."""
        return None if self.given_modulus is None else contact_modulus(self.given_modulus)

    @property
    def pressures(self) -> tuple[float, ...]:
        """Pressures p/E*, ascending."""
        return self._reduced(values_of(self.given_pressures))

    def _reduced(self, pressures: tuple[float, ...]) -> tuple[float, ...]:
        modulus = self.modulus
        return pressures if modulus is None else tuple(p / modulus for p in pressures)

    @property
    def kept_pressures(self) -> tuple[float, ...]:
        """Those of the pressures at which fields are kept, ascending."""
        saved = self.save_fields.pressures if self.save_fields is not None else ()
        given = self._reduced(saved)
        return tuple(sorted({nearest(p, self.pressures) for p in given}))

    @property
    def text(self) -> str:
        """The YAML text: as it was given, or written anew where no text says it all."""
        return dump(self.as_given()) if self._text is None else self._text

    @functools.cached_property  # of a sweep, it takes long
    def sha256(self) -> str:
        """Hash of what is to be computed; blind to the name, formatting, written defaults.

        Heights in a file count by the path as written, not by their content.
        """
        canonical = json.dumps(self.resolved(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()

    def as_given(self) -> dict[str, Any]:
        """Return the tree of what the spec says, without defaults; units as written."""
        if self._written is not None:
            return copy.deepcopy(dict(self._written))
        return _listed(self.model_dump(by_alias=True, exclude_unset=True))

    def resolved(self) -> dict[str, Any]:
        """Return the tree of each experiment with all defaults, without the name."""
        return {
            name: _listed(
                spec.model_dump(by_alias=True, exclude_none=True, exclude=_NOT_COMPUTED)
            )
            for name, spec in self.experiments()
        }

    def experiments(self) -> list[tuple[str, Spec]]:
        """Expand the sweep: name and spec of every experiment, in the order written.

        Returns
        -------
        list of (str, Spec)
            One spec without a sweep for each; a spec that sweeps nothing is ``main``, or
            ``scan`` of a measured scan. Twins of a measured surface are one more of each.
        """
        if not self.sweep:
            return self._with_twins("scan" if isinstance(self.surface, ScanSurface) else "main")
        tree = self.as_given()
        context = {"folder": self._folder, "catalog": self._catalog}
        specs = [
            (variant, validated(spelled(variant.tree, self._catalog), variant.tree, context))
            for variant in sweep.variants(tree, self._catalog)
        ]
        names = sweep.names(
            [(variant, spec.model_dump(by_alias=True)) for variant, spec in specs]
        )
        return [
            experiment
            for name, (_, spec) in zip(names, specs, strict=True)
            for experiment in spec._with_twins(name)  # noqa: SLF001  (of its own class)
        ]

    def _with_twins(self, name: str) -> list[tuple[str, Spec]]:
        """Return this experiment, and that on the twins of its surface."""
        if self.twins is None or not isinstance(self.surface, MeasuredSurface):
            return [(name, self)]
        twins = self.model_copy(update={"surface": self.surface.twins()})
        own = "twins" if name in ("scan", "main") else f"twins,{name}"
        return [(name, self), (own, twins)]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Spec):
            return NotImplemented
        return self.resolved() == other.resolved()

    def __hash__(self) -> int:
        return hash(self.sha256)


def validated(spelling: Spelled, tree: Mapping[str, Any], context: Mapping[str, Any]) -> Spec:
    """Return the spec of a tree.

    Parameters
    ----------
    spelling : Spelled
        Of the tree.
    tree : mapping
        As it was written, which a spec with units keeps.
    context : mapping
        What its parts have to know.

    Raises
    ------
    pydantic.ValidationError
    """
    if spelling.has_units:
        context = {**context, "has_units": True, "written": tree}
    return Spec.model_validate(freeze(spelling.tree), context=dict(context))


def _listed(tree: Any) -> Any:
    if isinstance(tree, dict):
        return {key: _listed(value) for key, value in tree.items()}
    return [_listed(value) for value in tree] if isinstance(tree, tuple) else tree
