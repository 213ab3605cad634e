"""Check the lines of docs/conventions.md against other codes, in the peers' environment.

    python conventions.py FOLDER > lines.json

FOLDER holds what roughbench computed: heights, pressures and gaps as .npy, and numbers.json.
Of roughbench only ``roughbench.neighbours`` is imported, which needs NumPy alone. Prints the
versions, and for each line what roughbench has, what the code has after the conversion that
the page says, and how far both may be apart (relative).
"""

from __future__ import annotations

import json
import math
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench import neighbours

FloatArray = NDArray[np.float64]
ROUNDING, SOLVED = 1e-12, 1e-5
Line = tuple[str, float, float, float]


class Case:
    """A problem that roughbench has solved, with E* = 2.

    Attributes
    ----------
    heights, pressure, gap : ndarray of float64
    size : list of float
        (y, x).
    numbers : dict
        Of the spectrum, the heights and the state.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.heights, self.pressure, self.gap = (
            np.load(folder / f"{name}-{field}.npy") for field in ("heights", "pressure", "gap")
        )
        self.numbers: dict[str, Any] = json.loads((folder / "numbers.json").read_text())[name]
        self.size: list[float] = self.numbers["size"]

    def apart(self, key: str, found: neighbours.PressedFields) -> list[Line]:
        """Compare fields: largest differences over the largest values."""
        pressure = np.abs(found.pressure - self.pressure).max() / self.pressure.max()
        gap = np.abs(found.gap - self.gap).max() / self.gap.max()
        ours = self.numbers
        return [
            (f"{key}-pressure", 1.0, 1.0 + float(pressure), SOLVED),
            (f"{key}-gap", 1.0, 1.0 + float(gap), SOLVED),
            (f"{key}-separation", ours["separation"], found.mean_separation, SOLVED),
            (f"{key}-modulus", ours["modulus"], found.modulus, ROUNDING),
        ]


def surface_topography(case: Case) -> list[Line]:
    """Compare axes, units, roughness and spectra."""
    h, ours = case.heights, case.numbers
    topography = neighbours.topography(h, tuple(case.size), "nm")
    back = neighbours.surface_of(topography)
    same = np.array_equal(back.heights, h) and back.size == tuple(case.size)
    x, y = topography.positions()
    step_x, step_y = (side / n for side, n in zip(case.size[::-1], h.shape[::-1], strict=True))
    flat = ours["flat"]
    q, spectrum = (np.ma.compressed(one) for one in topography.power_spectrum_from_area())
    low = (q > 1.5 * flat["q_min"]) & (q < 0.7 * flat["q_rolloff"])
    line = neighbours.topography(np.array(ours["line"]), ours["line_length"])
    _, profile = line.power_spectrum_from_profile(resampling_method=None)
    n = len(ours["line_psd"])
    return [
        ("st-axes", 1.0, 1.0 if same and back.unit == "nm" else 0.0, ROUNDING),
        ("st-axes", step_x, float(x[1, 0] - x[0, 0]), ROUNDING),
        ("st-axes", step_y, float(y[0, 1] - y[0, 0]), ROUNDING),
        ("st-rms-height", ours["rms_height"], topography.rms_height_from_area(), ROUNDING),
        ("st-rms-slope", ours["slope_by_differences"], topography.rms_gradient(), 1e-9),
        ("st-spectrum", flat["psd"], float(spectrum[low].mean()) / (2 * math.pi) ** 2, 1e-9),
        (
            "st-spectrum-line",
            1.0,
            1.0
            + float(np.abs(profile[1 : n + 1] / (2 * math.pi) / ours["line_psd"] - 1).max()),
            1e-9,
        ),
    ]


def contact_mechanics(case: Case) -> list[Line]:
    """Compare forces on points, gap, contact and modulus."""
    h, ours = case.heights, case.numbers
    system = neighbours.contactmechanics_system(h, tuple(case.size), ours["modulus"])
    area = math.prod(case.size)
    system.minimize_proxy(
        external_force=ours["pressure"] * area, pentol=1e-11 * h.std(), maxiter=10_000
    )
    found = neighbours.fields_of(system)
    share = float(system.compute_contact_area()) / area
    return [
        *case.apart("cm", found),
        ("cm-force", ours["pressure"], float(system.force.sum()) / area, 1e-9),
        ("cm-contact", ours["area_raw"], share, 1e-9),
    ]


def tamaas(case: Case) -> list[Line]:
    """Compare tractions, gap, contact with and without perimeter, roughness and spectrum."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    h, ours = case.heights, case.numbers
    model, surface = neighbours.tamaas_model(h, tuple(case.size), ours["modulus"])
    solver = tm.PolonskyKeerRey(model, surface, 1e-12)
    solver.max_iter = 100_000
    solver.solve(ours["pressure"])
    found = neighbours.fields_of(model)
    u = np.asarray(model.displacement)
    statistics = tm.Statistics2D
    traction = np.asarray(model.traction)
    points = h.size
    energy = 0.5 * float((traction * (u - u.mean())).mean())
    other = tm.ModelFactory.createModel(tm.model_type.basic_2d, case.size, list(h.shape))
    other.E, other.nu = 2.0, 0.3
    corrected = statistics.contact(traction, ours["free_edges"])
    lines = [
        *case.apart("tamaas", found),
        ("tamaas-E", 2.0 / (1 - 0.3**2), float(other.E_star), ROUNDING),
        ("tamaas-energy", ours["energy"], energy, SOLVED),
        ("tamaas-contact", ours["area_raw"], statistics.contact(traction), 1e-9),
        ("tamaas-perimeter", ours["area"], corrected, 1e-9),
        ("tamaas-edges", ours["edges"], float(ours["free_edges"]), 5e-3),
        (
            "tamaas-rms-height",
            ours["rms_height"],
            statistics.computeRMSHeights(h) * math.sqrt((points - 1) / points),
            ROUNDING,
        ),
    ]
    if case.size[0] == case.size[1]:
        side, flat = case.size[0], ours["flat"]
        slope = statistics.computeSpectralRMSSlope(h) / side
        power = np.real(statistics.computePowerSpectrum(h))[2, 3] * (side / (2 * math.pi)) ** 2
        law = tm.Isopowerlaw2D()
        law.q0, law.q1, law.q2, law.hurst = 4, 8, 64, 0.7
        lines += [
            ("tamaas-rms-slope", ours["rms_slope"], slope, 1e-9),
            ("tamaas-spectrum", flat["psd"], float(power), 1e-9),
            (
                "tamaas-cutoffs",
                ours["height_per_slope"],
                law.rmsHeights() / law.rmsSlopes(),
                1e-9,
            ),
        ]
    return lines


def aspher(case: Case) -> list[Line]:
    """Compare initial gap, pressures, gap and contact."""
    import aspher as code

    ours = case.numbers
    arguments = neighbours.aspher_arguments(
        case.heights, tuple(case.size), ours["pressure"], ours["modulus"]
    )
    result = code.solve_nested(**arguments, tol=1e-11, precision="double")
    found = neighbours.fields_of(result, length=tuple(case.size), modulus=ours["modulus"])
    return [
        *case.apart("aspher", found),
        ("aspher-contact", ours["area_raw"], float(result.contact_area), 1e-9),
    ]


def main() -> None:
    """Compare and print."""
    folder = Path(sys.argv[1])
    square, oblong = Case(folder, "square"), Case(folder, "oblong")
    lines: list[Line] = []
    versions: dict[str, str] = {}
    parts = {
        "SurfaceTopography": lambda: surface_topography(square),
        "ContactMechanics": lambda: contact_mechanics(square) + contact_mechanics(oblong),
        "tamaas": lambda: tamaas(square) + tamaas(oblong),
        "aspher": lambda: aspher(square),
    }
    for package, part in parts.items():
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
        lines += part()
    json.dump({"versions": versions, "lines": lines}, sys.stdout)


if __name__ == "__main__":
    main()
