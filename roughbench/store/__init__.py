"""Results on disk: the only package that knows the layout of the HDF5 file.

``/<experiment>/<label>`` holds one model's arrays with dimension scales ``realization``
and ``pressure``, and those of observables and fields (:mod:`roughbench.variables`); the root
holds ``format``, ``format_version``, ``name``, ``spec`` and ``spec_sha256``. Behind the HDF5
file stands the checksum of its bytes.
"""

from __future__ import annotations

from roughbench.results import ModelResult, Results
from roughbench.store.format import FORMAT_VERSION, HDF5_SIGNATURE, RESULTS, RESULTS_OR_STUMP
from roughbench.store.reading import load, opened, whose
from roughbench.store.writing import image, write_results, written_results

__all__ = [
    "FORMAT_VERSION",
    "HDF5_SIGNATURE",
    "RESULTS",
    "RESULTS_OR_STUMP",
    "ModelResult",
    "Results",
    "image",
    "load",
    "opened",
    "whose",
    "write_results",
    "written_results",
]
