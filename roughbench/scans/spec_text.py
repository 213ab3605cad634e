"""A spec to start from, for a scan that has been characterized."""

from __future__ import annotations

import json
import math
import os
import re
from pathlib import Path

from roughbench.scans.characterization import Characterization
from roughbench.system import split_dataset
from roughbench.units import in_words

MARK = "# Written by roughbench characterize"
"""How the text begins."""
PLACEHOLDER = ("2.5 GPa", 0.5, 2.5e9 / (1.0 - 0.5**2))
"""E, ν and E* in Pa of a material that the user has to replace."""
AREAS = (1e-3, 0.3)
"""Contact areas of Persson's theory, A/A0, that the pressures run between."""


def spec_text(
    found: Characterization,
    folder: str | Path,
    *,
    size: str | None = None,
    unit: str | None = None,
    channel: str | None = None,
) -> str:
    r"""Return a spec in YAML that computes with a scan as it was prepared.

    The pressures are those at which Persson's area
    :math:`A/A_0 = \mathrm{erf}(\sqrt2\,p/E^*\xi)` is :data:`AREAS`, with the rms slope ξ of
    the prepared heights.

    Parameters
    ----------
    found : Characterization
        Of a file.
    folder : path
        Where the spec will stand; the path of the scan is relative to it.
    size, unit, channel : str, optional
        As they were given to read the file.
    """
    source = found.scan.source
    file, dataset = split_dataset(source)
    path = Path(os.path.relpath(file, folder)).as_posix()
    stem = re.sub(r"[^A-Za-z0-9_.+-]", "_", Path(path).stem).strip("_.") or "scan"
    said = found.preparation
    surface = ["kind: scan", f"path: {_scalar(path + f':{dataset}' * bool(dataset))}"]
    if channel:
        surface.append(f"channel: {_scalar(channel)}")
    if size:
        sides = [part.strip() for part in size.split(",")]
        surface.append(f"size: [{sides[0]}, {sides[-1]}]  # x (columns), y (rows)")
    if unit:
        surface.append(f"unit: {_scalar(unit)}")
    surface.append(f"detrend: {said.detrend}")
    if found.raw.missing:
        surface.append(f"fill: {100.0 * said.fill:g} %")
    surface.append(_edges(found))
    if said.outliers is not None:
        surface.append(f"outliers: {said.outliers:g}")
    if said.resample is not None:
        surface.append(f"resample: {said.resample}")
    modulus, ratio, contact_modulus = PLACEHOLDER
    ends = pressures(found.prepared.Sdq, contact_modulus)
    low, high = (in_words(pressure, "Pa", 2) for pressure in ends)
    lines = [
        f"{MARK} of {Path(path).name}.",
        f"name: {_scalar(stem)}",
        "surface:",
        *(f"  {line}" for line in surface),
        "# A placeholder: put in the modulus and Poisson's ratio of your material, and scale",
        "# the pressures with it; they make Persson's area run from 0.1 % to 30 %.",
        f"modulus: {{E: {modulus}, nu: {ratio}}}",
        f"pressures: {{min: {low}, max: {high}, points: 15}}",
        "twins: 8  # surfaces of the same spectrum with random phases, to compare with",
        "seed: 1",
        "models:",
        "  - kind: bem",
        "  - kind: foundation",
        "  - kind: persson",
    ]
    return "\n".join(lines) + "\n"


def pressures(slope: float, contact_modulus: float) -> tuple[float, float]:
    """Return the pressures at which Persson's area is :data:`AREAS`, in the modulus' unit.

    Examples
    --------
    >>> low, high = pressures(0.1, 1.0)
    >>> f"{low:.3e} {high:.3e}"
    '6.267e-05 1.927e-02'
    """
    from scipy.special import erfinv

    low, high = (contact_modulus * slope * float(erfinv(a)) / math.sqrt(2.0) for a in AREAS)
    return low, high


def _edges(found: Characterization) -> str:
    if found.preparation.edges is not None:
        return f"edges: {found.preparation.edges}"
    if found.surface.windowed:
        return "edges: mirror  # the borders of the scan do not meet"
    return "edges: periodic  # the borders of the scan meet"


def _scalar(text: str) -> str:
    """Return a text as YAML reads it back: bare where nothing in it means anything."""
    plain = re.fullmatch(r"[A-Za-z./µ][\w./+µ-]*", text) is not None
    words = ("null", "true", "false", "yes", "no", "on", "off", "y", "n")
    return text if plain and text.lower() not in words else json.dumps(text, ensure_ascii=False)
