"""YAML text → validated, frozen specs; sweeps, overrides, JSON schema, spec hash."""

from __future__ import annotations

from roughbench.spec.loading import Source, load_spec, parse_spec
from roughbench.spec.measured import FileSurface, MeasuredSurface, ScanSurface
from roughbench.spec.model import Spec
from roughbench.spec.pressures import PressureRange
from roughbench.spec.schema import json_schema
from roughbench.spec.surfaces import SelfAffineSurface

__all__ = [
    "FileSurface",
    "MeasuredSurface",
    "PressureRange",
    "ScanSurface",
    "SelfAffineSurface",
    "Source",
    "Spec",
    "json_schema",
    "load_spec",
    "parse_spec",
]
