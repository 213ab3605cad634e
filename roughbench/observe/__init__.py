"""Observables of a spec's fields: solved, averaged, written.

>>> from roughbench.observe import observe
>>> from roughbench.spec import load_spec
>>> spec = load_spec(
...     {
...         "name": "small",
...         "surface": {"H": 0.7, "q0": 1.0, "qr": 2.0, "q1": 16.0, "slope": 0.1},
...         "pressures": [0.01],
...         "realizations": 2,
...         "models": [{"kind": "winkler"}, {"kind": "persson"}],
...         "observables": ["pressure_pdf", "clusters"],
...     }
... )
>>> found = observe(spec)
>>> found.without_fields
['main/persson']
>>> pressures = found.experiments["main"]["winkler"].averages["pressure_pdf"][0]
>>> round(pressures.scalars["mean"][0], 12)  # p/(E*ξ)
0.1
"""

from __future__ import annotations

from roughbench.observe.driver import (
    GAMMA,
    Observations,
    Observed,
    Saved,
    has_field,
    observe,
    solve_field,
)
from roughbench.observe.files import write_observations

__all__ = [
    "GAMMA",
    "Observations",
    "Observed",
    "Saved",
    "has_field",
    "observe",
    "solve_field",
    "write_observations",
]
