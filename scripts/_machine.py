"""Say on what a benchmark ran."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

import roughbench


def describe_machine(*packages: str) -> str:
    """Return processor, cores and the versions of Python, roughbench and ``packages``."""
    processor = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        names = [
            row for row in cpuinfo.read_text().splitlines() if row.startswith("model name")
        ]
        processor = names[0].partition(":")[2].strip() if names else processor
    versions = ", ".join(
        [f"roughbench {roughbench.__version__}"]
        + [f"{name} {metadata.version(name)}" for name in packages]
    )
    return (
        f"{processor}, {os.cpu_count()} cores; {platform.system()} {platform.machine()}\n"
        f"Python {platform.python_version()}, {versions}"
    )
