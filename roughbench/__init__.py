r"""Rough contact on one bench: exact solver, Popov's foundation, Persson's theory.

**The way of the data.** A *spec* says everything about a computation. It is YAML in a
file, or the same as a mapping:

>>> import roughbench as rb
>>> spec = {
...     "name": "tour",
...     "surface": {"H": 0.7, "q0": 1.0, "qr": 8.0, "q1": 128.0, "slope": 0.1},
...     "pressures": [1e-4, 1e-3, 1e-2],
...     "realizations": 4,
...     "seed": 2013,
...     "models": [{"kind": "foundation", "springs": 512}, {"kind": "persson"}],
... }

:func:`run` makes the *surfaces* (lines for the foundation; Persson's theory takes the
spectrum alone), has each *model* compute its curve on every one of them, and averages
over the *ensemble*:

>>> results = rb.run(spec)
>>> foundation, persson = results["main"]["foundation"], results["main"]["persson"]
>>> foundation["area"].shape
(4, 3)

Every quantity has its mean, standard error, median and 16 % and 84 % quantiles, as
functions of the pressure p/E\*:

>>> persson["area_mean"].round(5).tolist()
[0.0016, 0.01596, 0.15852]
>>> bool((foundation["area_mean"] > 2 * persson["area_mean"]).all())
True

At p/E\* = 0.01 every spring of the foundation is in contact, and its stiffness infinite:

>>> foundation["stiffness_mean"].tolist()[-1], foundation.units("stiffness_mean")
(inf, '1/length')

A *results file* keeps all of it, written whole or not at all, for :func:`load`, for
xarray, and for the commands ``roughbench show``, ``plot`` and ``export``:

>>> import tempfile
>>> path = tempfile.mkdtemp() + "/tour.h5"
>>> _ = rb.run(spec, output=path)
>>> list(rb.load(path)["main"])
['foundation', 'persson']

An array of xarray or a table of pandas come of it too; a sweep is a dimension then:

>>> results.to_xarray("foundation").area.dims
('realization', 'pressure')

:func:`solve_contact` and :func:`solve_curve` solve given heights exactly, without a spec; a
file has them (:func:`read_scan`), or a spectrum:

>>> spectrum = rb.self_affine(hurst=0.8, q_min=1, q_rolloff=2, q_max=8, rms_slope=0.1)
>>> heights = rb.make_surface(spectrum, 32, length=6.283185, generator=2013)
>>> rb.solve_contact(heights, 0.01, length=6.283185).to_xarray().gap.dims
('y', 'x')

Everything that this package raises on purpose is a :class:`RoughbenchError`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from roughbench.errors import (
    Fault,
    ModelError,
    RoughbenchError,
    SolverError,
    SpecError,
    StoreError,
    SurfaceError,
    UnitError,
)
from roughbench.public import LAZY, MODULES

if TYPE_CHECKING:
    from roughbench import figures as figures
    from roughbench import fits as fits
    from roughbench import neighbours as neighbours
    from roughbench import observables as observables
    from roughbench import quantities as quantities
    from roughbench import runner as runner
    from roughbench import verdict as verdict
    from roughbench.field_files import save_fields
    from roughbench.figures import plot
    from roughbench.models.base import Curve, Model, Sample, State, Status
    from roughbench.models.halfspace.certificate import Certificate
    from roughbench.models.halfspace.contact import ContactState, solve_contact, solve_curve
    from roughbench.models.states import CompleteCurve, Fields
    from roughbench.models.style import Style
    from roughbench.results import ModelResult, Results
    from roughbench.runner import Progress, ShareOutcome, run, run_share
    from roughbench.scans.characterization import Characterization, characterize
    from roughbench.scans.topography import Scan, read_scan
    from roughbench.spec import Spec, load_spec
    from roughbench.spectrum import Spectrum, measured_spectrum, self_affine
    from roughbench.store import load
    from roughbench.surface import make_profile, make_surface, realization_generator

    __version__: str

__all__ = [
    "Certificate",
    "Characterization",
    "CompleteCurve",
    "ContactState",
    "Curve",
    "Fault",
    "Fields",
    "Model",
    "ModelError",
    "ModelResult",
    "Progress",
    "Results",
    "RoughbenchError",
    "Sample",
    "Scan",
    "ShareOutcome",
    "SolverError",
    "Spec",
    "SpecError",
    "Spectrum",
    "State",
    "Status",
    "StoreError",
    "Style",
    "SurfaceError",
    "UnitError",
    "__version__",
    "characterize",
    "load",
    "load_spec",
    "make_profile",
    "make_surface",
    "measured_spectrum",
    "plot",
    "read_scan",
    "realization_generator",
    "run",
    "run_share",
    "save_fields",
    "self_affine",
    "solve_contact",
    "solve_curve",
]


def __getattr__(name: str) -> object:
    if name == "__version__":
        return _version()
    if name in MODULES:
        return importlib.import_module(f"{__name__}.{name}")
    if name not in LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(LAZY[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *MODULES})


def _version() -> str:
    """Return the version of the installed package."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("roughbench")
    except PackageNotFoundError:
        return "unknown (not installed)"
