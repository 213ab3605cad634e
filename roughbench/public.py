"""Public names and modules of the package, which are imported on first use.

So that ``roughbench --help`` answers without NumPy.
"""

from __future__ import annotations

from collections.abc import Mapping

LAZY: Mapping[str, str] = {
    "Certificate": "roughbench.models.halfspace.certificate",
    "Characterization": "roughbench.scans.characterization",
    "CompleteCurve": "roughbench.models.states",
    "ContactState": "roughbench.models.halfspace.contact",
    "Curve": "roughbench.models.base",
    "Fields": "roughbench.models.states",
    "Model": "roughbench.models.base",
    "ModelResult": "roughbench.results",
    "Progress": "roughbench.runner",
    "Results": "roughbench.results",
    "Sample": "roughbench.models.base",
    "Scan": "roughbench.scans.topography",
    "ShareOutcome": "roughbench.runner",
    "Spec": "roughbench.spec",
    "Spectrum": "roughbench.spectrum",
    "State": "roughbench.models.base",
    "Status": "roughbench.models.base",
    "Style": "roughbench.models.style",
    "characterize": "roughbench.scans.characterization",
    "load": "roughbench.store",
    "load_spec": "roughbench.spec",
    "make_profile": "roughbench.surface",
    "make_surface": "roughbench.surface",
    "measured_spectrum": "roughbench.spectrum",
    "plot": "roughbench.figures",
    "read_scan": "roughbench.scans.topography",
    "realization_generator": "roughbench.surface",
    "run": "roughbench.runner",
    "run_share": "roughbench.runner",
    "save_fields": "roughbench.field_files",
    "self_affine": "roughbench.spectrum",
    "solve_contact": "roughbench.models.halfspace.contact",
    "solve_curve": "roughbench.models.halfspace.contact",
}
"""Name → the module that defines it."""

MODULES = ("figures", "fits", "neighbours", "observables", "quantities", "runner", "verdict")
"""Modules for users: ``rb.figures`` is there without another import."""
