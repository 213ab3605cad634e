"""The slow, obvious way: dense matrices from explicit sums, and an active-set method."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from roughbench.models.base import Status
from roughbench.models.halfspace.contact import ContactState
from roughbench.spectrum import self_affine
from roughbench.surface import make_profile, make_surface, realization_generator

FloatArray = NDArray[np.float64]
CELL = 2 * math.pi
"""Length of the cell of the rough surfaces."""

Rough = Callable[..., FloatArray]


@dataclass(frozen=True, slots=True)
class Slow:
    """A contact solved without transforms: all arrays are flat."""

    pressure: FloatArray
    separation: float
    energy: float
    stiffness: float
    contact: NDArray[np.bool_]


class Reference:
    """What the solver's answers are held against, sharing no code with it.

    Parameters
    ----------
    heights : array_like, shape (n,) or (n, m)
    length : float or (float, float)
        Along the first axis, of square points; or along both.
    modulus : float
    screening : float
        q_c, 1/length.
    """

    def __init__(
        self,
        heights: ArrayLike,
        length: float | tuple[float, float] = 1.0,
        modulus: float = 1.0,
        screening: float = 0.0,
    ) -> None:
        h = np.asarray(heights, np.float64)
        self.heights = h - h.mean()
        self.rms = float(self.heights.std())
        self.modulus = modulus
        self.screening = screening
        if isinstance(length, tuple):
            self.spacing = np.array(length) / h.shape
        else:
            self.spacing = np.full(h.ndim, length / h.shape[0])
        waves = [
            2 * math.pi * np.fft.fftfreq(n, spacing)
            for n, spacing in zip(h.shape, self.spacing, strict=True)
        ]
        self.wavevectors = np.stack(np.meshgrid(*waves, indexing="ij"), axis=-1)
        self.q = np.sqrt((self.wavevectors**2).sum(axis=-1) + screening**2)
        self.q.flat[0] = 0.0  # a uniform displacement costs nothing

    def matrix(self, power: float = -1.0) -> FloatArray:
        """Dense G (power −1) or S (power 1), from Σ_q cos q·(x_i − x_j), unit by unit."""
        factor = 2 / self.modulus if power < 0 else self.modulus / 2
        shape = self.heights.shape
        places = np.stack(np.unravel_index(np.arange(self.q.size), shape), axis=-1)
        offsets = (places[:, None, :] - places[None, :, :]) * self.spacing
        matrix = np.zeros((self.q.size, self.q.size))
        for vector, q in zip(
            self.wavevectors.reshape(-1, len(shape)), self.q.flat, strict=True
        ):
            if q > 0:
                matrix += factor * q**power * np.cos(offsets @ vector)
        return matrix / self.q.size

    def displacement(self, pressure: FloatArray) -> FloatArray:
        """u = G p by NumPy's transforms."""
        with np.errstate(divide="ignore"):
            compliance = np.where(self.q > 0, 2 / (self.modulus * self.q), 0.0)
        return np.asarray(np.fft.ifftn(compliance * np.fft.fftn(pressure)).real)

    def full_contact_traction(self) -> FloatArray:
        """σ_fc = (E*/2) F⁻¹[|q| h_q]."""
        transform = self.modulus / 2 * self.q * np.fft.fftn(self.heights)
        return np.asarray(np.fft.ifftn(transform).real)

    def solve(self, pressure: float) -> Slow:
        """Active set of Lawson and Hanson's kind: one point enters at a time."""
        matrix, h = self.matrix(), self.heights.ravel()
        n = h.size
        p = np.zeros(n)
        active = np.zeros(n, bool)
        active[np.argmax(h)] = True
        p[active] = n * pressure
        for _ in range(20 * n):
            while True:
                k = int(active.sum())
                system = np.zeros((k + 1, k + 1))
                system[:k, :k] = matrix[np.ix_(active, active)]
                system[:k, k] = -1.0
                system[k, :k] = 1.0
                solution = np.linalg.solve(system, np.append(h[active], n * pressure))
                wanted = np.zeros(n)
                wanted[active] = solution[:k]
                if wanted[active].min() > 0:
                    break
                falling = active & (wanted <= 0)
                ratio = np.ones(n)
                ratio[falling] = p[falling] / (p[falling] - wanted[falling])
                p += ratio.min() * (wanted - p)
                active &= ratio > ratio.min()
                p[~active] = 0.0
            p = wanted
            gap = matrix @ p - h - solution[k]
            if gap[~active].min(initial=0.0) >= -1e-13 * max(self.rms, 1e-300):
                break
            active[np.argmin(np.where(active, np.inf, gap))] = True
        tangent = np.linalg.solve(system, np.append(np.zeros(k), n))
        return Slow(
            pressure=p,
            separation=-float(solution[k]),
            energy=0.5 * float(np.mean(p * (matrix @ p))),
            stiffness=1.0 / float(tangent[k]),
            contact=active,
        )

    def edges(self, pressure: FloatArray) -> tuple[int, int]:
        """Grid edges of a contact, and the free ones, by the rule as written."""
        heights = self.heights
        total = free = 0
        for axis, step in itertools.product(range(pressure.ndim), (1, -1)):
            p = pressure * self.spacing[axis] / self.modulus  # a length

            def at(
                field: FloatArray, offset: int, axis: int = axis, step: int = step
            ) -> FloatArray:
                return np.roll(field, -offset * step, axis)

            edge = (p > 0) & (at(p, -1) == 0)
            behind, beyond = at(p, 1), at(p, 2)
            sides = p
            if p.ndim == 2:
                sides = np.maximum(np.roll(p, 1, 1 - axis), np.roll(p, -1, 1 - axis))
            bend = 2 * heights - at(heights, 1) - at(heights, -1)
            largest = np.maximum.reduce([p, behind, beyond, sides])
            bent = bend > np.where(beyond > 0, 4.0, 30.0) * largest
            given = (behind > 0) & (p > 0.75 * behind) & bent
            total += int(edge.sum())
            free += int((edge & ~given).sum())
        return total, free

    def corrected_area(self, pressure: FloatArray) -> float:
        """A/A0 from contact points and the free edges around them."""
        contact = int((pressure > 0).sum())
        free = self.edges(pressure)[1]
        factor = (math.pi - 1 + math.log(2)) / 24
        if pressure.ndim == 1:
            theta = (np.arange(20000) + 0.5) * math.pi / 20000
            x = self.screening * self.spacing[0]
            rest = (2 - theta / np.tan(theta / 2)) / (theta**2 + x**2)
            factor = math.atan(x / math.pi) / (math.pi * x) if x else 1 / math.pi**2
            factor += float(rest.mean()) / 2
        if pressure.ndim == 2:
            factor /= math.sqrt(1 + 0.15 * math.log(self.spacing[1] / self.spacing[0]) ** 2)
            mean = math.sqrt(self.spacing[0] * self.spacing[1])
            x = self.screening * mean
            factor /= math.sqrt(1 + (x / 3.5) ** 2 + (x / 15) ** 4)
        return (contact - factor * free) / pressure.size

    def verify(
        self,
        state: ContactState,
        pressure: float,
        tolerance: float = 1e-6,
        rounding: float = 1e-10,
    ) -> ContactState:
        """Assert that a converged state is one, from its fields alone; return it.

        ``rounding`` is what the heights' own digits allow, over their rms value.
        """
        assert state.status is Status.CONVERGED
        assert state.certificate.holds(tolerance)
        self.consistent(state, pressure, rounding)
        p = state.pressure
        unit = self.rms if self.rms > 0 else 1.0
        gap = self.displacement(p) - self.heights
        alpha = float((p * gap).sum() / p.sum())
        gap -= alpha
        assert np.abs(p * gap).sum() / (p.sum() * unit) <= tolerance + 0.01 * rounding
        assert gap.min() / unit >= -10 * tolerance - 0.01 * rounding
        assert abs(p.mean() / pressure - 1) <= max(tolerance, 1e-12)
        assert abs(state.mean_separation + alpha) <= rounding * unit
        return state

    def consistent(self, state: ContactState, pressure: float, rounding: float = 1e-10) -> None:
        """Assert that fields, averages and certificate belong together, converged or not."""
        p, unit = state.pressure, self.rms if self.rms > 0 else 1.0
        assert p.shape == state.gap.shape == self.heights.shape
        assert p.dtype == state.gap.dtype == np.float64
        assert p.min() >= 0.0
        u = self.displacement(p)
        gap = u - self.heights
        alpha = float((p * gap).sum() / p.sum())
        gap -= alpha
        np.testing.assert_allclose(state.gap, gap, rtol=0, atol=rounding * unit)
        assert state.mean_separation == pytest.approx(state.gap.mean(), abs=rounding * unit)
        assert state.area_fraction_raw == (p > 0).mean()
        exact = 1e-14 if p.ndim == 2 else 1e-9  # of an integral
        assert state.area_fraction == pytest.approx(self.corrected_area(p), abs=exact)
        assert state.energy == pytest.approx(0.5 * (p * u).mean(), rel=1e-9)
        own = (
            float(np.abs(p * gap).sum() / (p.sum() * unit)),
            float(max(-gap.min(), 0.0)) / unit,
            abs(float(p.mean()) / pressure - 1),
        )
        told = state.certificate
        reported = (told.complementarity, told.penetration, told.load_error)
        assert reported == pytest.approx(own, rel=1e-3, abs=0.1 * rounding)


@pytest.fixture(scope="session")
def reference() -> type[Reference]:
    """Return the slow, obvious way."""
    return Reference


@pytest.fixture(scope="session")
def rough() -> Rough:
    """Return a factory of rough surfaces and lines of rms slope 0.1 on a cell of 2π."""

    def build(
        points: int = 64,
        *,
        seed: int = 0,
        q_rolloff: float = 1.0,
        per_wave: float = 4.0,
        line: bool = False,
    ) -> FloatArray:
        spectrum = self_affine(
            hurst=0.7,
            q_min=1.0,
            q_rolloff=q_rolloff,
            q_max=points / per_wave,
            rms_slope=0.1,
        )
        make = make_profile if line else make_surface
        return make(spectrum, points, CELL, realization_generator(seed, 0))

    return build
