"""Which library transforms: FFTW where pyFFTW can be imported, else SciPy's pocketfft.

Both agree within rounding, not to the bit, so that the choice belongs to the identity of what
is computed. ``ROUGHBENCH_FFT`` forces it.
"""

from __future__ import annotations

import contextlib
import functools
import os
import sys
from collections.abc import Iterator
from typing import Literal, cast, get_args

from roughbench.errors import RoughbenchError

Backend = Literal["pyfftw", "scipy"]
VARIABLE = "ROUGHBENCH_FFT"


def fft_backend() -> Backend:
    """Return the library that transforms in this process.

    Raises
    ------
    RoughbenchError
        If ``ROUGHBENCH_FFT`` is neither ``pyfftw`` nor ``scipy``, or asks for a pyFFTW that
        cannot be imported.
    """
    asked = os.environ.get(VARIABLE, "")
    if asked not in ("", *get_args(Backend)):
        raise RoughbenchError(f"{VARIABLE} must be pyfftw or scipy, or not set; got {asked!r}")
    missing = _fault_of_pyfftw() if asked != "scipy" else ""
    if asked and missing:
        raise RoughbenchError(
            f"{VARIABLE}=pyfftw, and pyFFTW cannot be imported ({missing}); install it "
            f"(pip install pyfftw), or leave {VARIABLE} away to transform with SciPy"
        )
    return cast(Backend, asked) if asked else "scipy" if missing else "pyfftw"


@functools.cache
def _fault_of_pyfftw() -> str:
    """Return why pyFFTW cannot be imported; empty if it can."""
    try:
        with _not_imported("dask.array.fft"):
            import pyfftw  # noqa: F401
    except (ImportError, OSError) as error:  # not there, or without its library
        return str(error)
    return ""


@contextlib.contextmanager
def _not_imported(module: str) -> Iterator[None]:
    """Let the import of a module fail that nobody has imported yet.

    pyFFTW imports Dask's arrays where they are installed, to offer transforms of them, and with
    them pandas and xarray: a second, in every process. Who wants them imports
    ``pyfftw.interfaces.dask_fft``.
    """
    if module in sys.modules:
        yield
        return
    sys.modules[module] = None  # type: ignore[assignment]  # as the import system has it
    try:
        yield
    finally:
        del sys.modules[module]
