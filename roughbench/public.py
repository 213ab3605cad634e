"""Public names of the package that are imported on first use, each with its module.

So that ``roughbench --help`` answers without NumPy.
"""

from __future__ import annotations

from collections.abc import Mapping

LAZY: Mapping[str, str] = {
    "Curve": "roughbench.models.base",
    "Model": "roughbench.models.base",
    "ModelResult": "roughbench.results",
    "Progress": "roughbench.runner",
    "Results": "roughbench.results",
    "Sample": "roughbench.models.base",
    "Spec": "roughbench.spec",
    "State": "roughbench.models.base",
    "Status": "roughbench.models.base",
    "Style": "roughbench.models.style",
    "characterize": "roughbench.scans.characterization",
    "load": "roughbench.store",
    "load_spec": "roughbench.spec",
    "run": "roughbench.runner",
    "solve_contact": "roughbench.models.halfspace.contact",
    "solve_curve": "roughbench.models.halfspace.contact",
}
