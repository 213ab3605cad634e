"""A theory in a file of its own, as a reader would write it, and packages that declare one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

THEORY = '''\
"""A/A0 = erf(0.9 √2 p/(E* ξ)), and nothing else."""

from typing import ClassVar, Literal

from scipy.special import erf

import helper
import roughbench as rb


class Erf09(rb.Model):
    """A/A0 = erf(0.9 √2 p/(E* ξ))."""

    title: ClassVar[str] = "Erf 0.9"
    needs: ClassVar[str] = "spectrum"
    style: ClassVar[rb.Style] = rb.Style("#123456", ((4.0, 2.0),))
    kind: Literal["erf09"] = "erf09"
    factor: float = 0.9

    def curve(self, sample, pressures):
        scale = helper.scaled(self.factor) / sample.spectrum.rms_slope
        return rb.Curve(pressure=pressures, area=erf(scale * pressures))
'''
HELPER = "import math\n\n\ndef scaled(factor):\n    return factor * math.sqrt(2.0)\n"


def write_theory(folder: Path) -> Path:
    """Write the model and the file beside it that it imports."""
    folder.mkdir(exist_ok=True, parents=True)
    (folder / "helper.py").write_text(HELPER, encoding="utf-8")
    path = folder / "mytheory.py"
    path.write_text(THEORY, encoding="utf-8")
    return path


def spec_of(*models: dict[str, Any]) -> dict[str, Any]:
    """Return a spec that computes in milliseconds."""
    return {
        "name": "outside",
        "surface": {"H": 0.7, "q0": 1.0, "qr": 4.0, "q1": 32.0, "slope": 0.1},
        "pressures": [1e-4, 1e-3, 1e-2],
        "models": list(models),
    }


def install(folder: Path, package: str, *entries: str) -> None:
    """Write what an installer leaves of a package that declares entry points."""
    info = folder / f"{package}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    text = "\n".join(["[roughbench.models]", *entries, ""])
    (info / "entry_points.txt").write_text(text)
