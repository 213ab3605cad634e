"""Observables on disk: averages as JSON, fields as NumPy archives."""

from __future__ import annotations

import io
import json
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roughbench.observables import Average
from roughbench.observe.driver import GAMMA, Observations, Observed, Saved
from roughbench.publish import commit, make_folder


def write_observations(observations: Observations, folder: Path) -> list[Path]:
    """Write ``observables.json`` and one ``.npz`` for each saved field.

    Parameters
    ----------
    observations : Observations
    folder : Path
        Made if it does not exist.

    Returns
    -------
    list of Path
        What was written; each file appears in one step.

    Raises
    ------
    StoreError
        If the folder cannot be made, or a file not be written.
    """
    make_folder(folder)
    paths = []
    if any(observations.experiments.values()):
        text = json.dumps(_content(observations), indent=1, ensure_ascii=False, allow_nan=False)
        paths.append(commit(f"{text}\n".encode(), folder / "observables.json"))
    return paths + [_write_field(saved, folder) for saved in observations.saved]


def file_name(saved: Saved) -> str:
    """Return the name of a saved field, without its suffix."""
    return (
        f"{saved.experiment}-{saved.label}-realization{saved.realization}-p{saved.pressure:g}"
    )


def _write_field(saved: Saved, folder: Path) -> Path:
    state, image = saved.state, io.BytesIO()
    np.savez_compressed(
        image,
        pressure=state.pressure,
        gap=state.gap,
        length=state.length,
        rms_slope=state.rms_slope,
        rms_height=state.rms_height,
        nominal_pressure=saved.pressure,
        realization=saved.realization,
        status=int(saved.status),
    )
    return commit(image.getvalue(), folder / f"{file_name(saved)}.npz")


def _content(observations: Observations) -> dict[str, object]:
    return {
        "name": observations.name,
        "spec_sha256": observations.spec_sha256,
        "without_fields": observations.without_fields,
        "experiments": {
            experiment: {label: _model(found) for label, found in models.items()}
            for experiment, models in observations.experiments.items()
        },
    }


def _model(found: Observed) -> dict[str, object]:
    return {
        "kind": found.kind,
        "title": found.title,
        "n_realizations": found.count,
        "n_unconverged": list(found.unconverged),
        "pressures": list(found.pressures),
        "observables": {name: _observable(name, found) for name in found.averages},
    }


def _observable(name: str, found: Observed) -> dict[str, object]:
    columns = found.averages[name]
    first = next((column for column in columns if column is not None), None)
    content: dict[str, object] = {}
    if first is not None:
        content |= {
            "axis": first.axis,
            "edges": _numbers(first.edges),
            "places": _numbers(first.places),
        }
    content["mean"] = [None if c is None else _numbers(c.mean) for c in columns]
    content["sem"] = [None if c is None else _numbers(c.sem) for c in columns]
    content["scalars"] = [None if c is None else _scalars(c) for c in columns]
    if name in found.persson:
        content["persson"] = [_numbers(values) for values in found.persson[name]]
        if name == "stress_spectrum":
            content["persson_gamma"] = GAMMA
    if name in found.exponents and found.wavevectors is not None:
        content["exponent"] = {
            "from": found.wavevectors[0],
            "to": found.wavevectors[1],
            "mean": [_number(mean) for mean, _ in found.exponents[name]],
            "sem": [_number(sem) for _, sem in found.exponents[name]],
        }
    return content


def _scalars(column: Average) -> dict[str, dict[str, float | None]]:
    return {
        name: {"mean": _number(mean), "sem": _number(sem)}
        for name, (mean, sem) in column.scalars.items()
    }


def _numbers(values: NDArray[np.float64]) -> list[float | None]:
    return [_number(value) for value in values.tolist()]


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
