"""Measured surfaces: from a file to heights that the models can work with."""

from __future__ import annotations

CHECKS = ("tilt", "jump", "step", "slope", "unit", "quantization", "resolution", "bumps")
"""What :mod:`roughbench.scans.checks` looks for, and a spec may accept."""
