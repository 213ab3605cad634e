"""What a reader finds in a file: one image, and which channels there were to choose from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.text import on_one_line, suggestion

FloatArray = NDArray[np.float64]

_MOST_SHOWN = 12


@dataclass(frozen=True, slots=True)
class Image:
    """Values of one channel as they stand in the file.

    Parameters
    ----------
    values : ndarray of float64, shape (rows, columns)
        In the file's unit; nan where a point is missing.
    unit : float or None
        Metres per unit of the values, None where the file does not say it.
    size : (float, float) or None
        Points times their spacing along (y, x), in m; None where the file does not say it.
    channel : str
        "" where the file does not name it.
    notes : tuple of str
        What was assumed.
    aspect : float or None
        Spacing along y over that along x, where the file says no more of the size.
    """

    values: FloatArray
    unit: float | None = None
    size: tuple[float, float] | None = None
    channel: str = ""
    notes: tuple[str, ...] = ()
    aspect: float | None = None


@dataclass(frozen=True, slots=True)
class Channel:
    """A channel that a file offers.

    Parameters
    ----------
    name : str
    unit : str
        Of its values, in the file's words; "" where it does not say it.
    is_height : bool
        Whether its values may be heights.
    """

    name: str
    unit: str = ""
    is_height: bool = True

    def __str__(self) -> str:
        return on_one_line(f"{self.name} ({self.unit or 'no unit'})")


def choose(channels: Sequence[Channel], wanted: str | None, name: str) -> int:
    """Return the place of the channel of this name, or of the first that holds heights.

    Raises
    ------
    SurfaceError
        If there is none, or none of heights; lists the channels with their units.

    Examples
    --------
    >>> channels = [Channel("Phase", "deg", is_height=False), Channel("Height", "nm")]
    >>> choose(channels, None, "a.spm"), choose(channels, "Height", "a.spm")
    (1, 1)
    >>> choose(channels, "height", "a.spm")
    Traceback (most recent call last):
        ...
    roughbench.errors.SurfaceError: a.spm: no channel 'height'; it holds Phase (deg), Height
    (nm); did you mean channel: Height?
    """
    if wanted is None:
        for place, channel in enumerate(channels):
            if channel.is_height:
                return place
        raise SurfaceError(f"{name}: no channel holds heights; {held(channels)}")
    places = [place for place, channel in enumerate(channels) if channel.name == wanted]
    if not places:
        near = suggestion(wanted, [channel.name for channel in channels])
        hint = f"; did you mean channel: {on_one_line(near)}?" if near else ""
        raise SurfaceError(
            f"{name}: no channel {on_one_line(wanted)!r}; {held(channels)}{hint}"
        )
    if not channels[places[0]].is_height:
        raise SurfaceError(
            f"{name}: channel {channels[places[0]]} holds no heights; {held(channels)}"
        )
    return places[0]


def held(channels: Sequence[Channel]) -> str:
    """Say which channels there are, with their units."""
    shown = [str(channel) for channel in channels[:_MOST_SHOWN]]
    if len(channels) > _MOST_SHOWN:
        shown.append(f"and {len(channels) - _MOST_SHOWN} more")
    return f"it holds {', '.join(shown) or 'none'}"
