"""What contenders of surfaces share: the option ``grid``, the choice to do without heights."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from roughbench.models.base import Model, Needs

GridOption = Annotated[int | None, Field(ge=2)]
"""Points per side, at least two; None leaves them to the model."""


class HeightsOrSpectrum(Model):
    """A contender of surfaces, or of the spectrum alone, as one of its options says."""

    sampling: ClassVar[tuple[str, ...]] = ("grid",)

    idle_grid: ClassVar[str]
    """What to do about ``grid`` where the spectrum alone counts."""

    @property
    @abstractmethod
    def uses_heights(self) -> bool:
        """Whether it works on the heights of surfaces."""

    @property
    def needs(self) -> Needs:
        """Surfaces, or the spectrum alone."""
        return "surface" if self.uses_heights else "spectrum"

    def unused_options(self) -> Mapping[str, str]:
        """Without heights, their grid."""
        return {} if self.uses_heights else {"grid": self.idle_grid}
