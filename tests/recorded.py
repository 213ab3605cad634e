"""A record of a made-up measured surface, as results keep one."""

from __future__ import annotations

from typing import Any

import numpy as np

from roughbench.results import Results
from roughbench.spectrum import self_affine
from roughbench.surface_record import RecordedStep, SurfaceRecord

SIZE = (40e-6, 80e-6)
FIT = {
    "H": 0.78,
    "H_error": 0.03,
    "q0": 1.6e5,
    "q0_error": 1e4,
    "qr": 6.3e5,
    "qr_error": 5e4,
    "q1": 4e7,
    "q1_error": 2e6,
    "slope": 0.12,
    "slope_error": 0.004,
}
WARNINGS = (
    (
        "The roughness is not resolved: 34 % of the slope sits in the last octave; "
        "measure with smaller pixels."
    ),
)


def a_record(**changes: Any) -> SurfaceRecord:
    """Return the record of a surface of 40 µm × 80 µm, 128 × 256 points."""
    generator = np.random.default_rng(12)
    n, m = 128, 256
    qy = 2 * np.pi * np.fft.fftfreq(n, SIZE[0] / n)[:, None]
    qx = 2 * np.pi * np.fft.rfftfreq(m, SIZE[1] / m)
    q = np.hypot(qy, qx)
    amplitude = np.maximum(q, FIT["qr"]) ** -(1 + FIT["H"])
    amplitude[0, 0] = 0.0
    waves = amplitude * np.exp(2j * np.pi * generator.random(amplitude.shape))
    heights = np.fft.irfft2(waves, (n, m))
    heights *= 82e-9 / heights.std()
    density, edges = np.histogram(heights, 48, density=True)
    rings = np.geomspace(1.6e5, 9e6, 40)
    law = self_affine(hurst=0.78, q_min=1.6e5, q_rolloff=6.3e5, q_max=4e7, rms_slope=0.12)
    power = law.psd_2d(rings) * generator.lognormal(0.0, 0.1, rings.size)
    fields: dict[str, Any] = {
        "heights": heights,
        "size": SIZE,
        "spectrum": (rings, power),
        "fit": FIT,
        "height_density": (0.5 * (edges[1:] + edges[:-1]), density),
        "steps": (
            RecordedStep("as read", "256 × 512 points of plate.al3d", (256, 512), 4.1e-7, 0.16),
            RecordedStep("plane", "a plane removed: 22 nm per µm", (256, 512), 8.4e-8, 0.13),
            RecordedStep("mirror", "mirrored at both borders", (512, 1024), 8.2e-8, 0.12),
        ),
        "parameters": {
            "Sa": 6.5e-8,
            "Sq": 8.2e-8,
            "Ssk": -0.21,
            "Sku": 3.2,
            "Sdq": 0.12,
            "Sdr": 0.007,
            "peak_to_valley": 6.1e-7,
            "m0": 6.7e-15,
            "m2": 0.0072,
            "m4": 3.1e10,
            "nayak": 4.0,
        },
        "warnings": WARNINGS,
        "source": "plate.al3d",
    }
    return SurfaceRecord(**(fields | changes))


def with_record(results: Results, experiment: str, record: SurfaceRecord) -> Results:
    """Return results whose experiment pressed a measured surface."""
    return Results(
        results.experiments,
        results.spec_text,
        results.spec_sha256,
        results.name,
        {experiment: record},
    )
