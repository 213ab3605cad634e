"""Heights of a line or a surface from ``.npy`` and HDF5 files."""

from __future__ import annotations

from roughbench.heights_file.checks import check_layout, check_memory, check_there
from roughbench.heights_file.hdf5 import fill_values, find_dataset, open_hdf5, read_dataset
from roughbench.heights_file.loading import load_heights
from roughbench.heights_file.npy import read_npy

__all__ = [
    "check_layout",
    "check_memory",
    "check_there",
    "fill_values",
    "find_dataset",
    "load_heights",
    "open_hdf5",
    "read_dataset",
    "read_npy",
]
