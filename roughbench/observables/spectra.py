r"""Stress, contact and energy by wavevector.

For a function f on the grid, :math:`C_f(q) = (L/2\pi)^2\langle|f_q|^2\rangle` over the
modes of a ring of wavevectors, in the convention of :mod:`roughbench.spectrum`: its
integral :math:`2\pi\int qC_f\,dq` is the variance of f. (On a line
:math:`(L/2\pi)\langle|f_q|^2\rangle`, two-sided.)

On a self-affine surface at small loads the exponents are

=========================================  ============
stress and contact, elastically coupled    −(1 + H)
contact of independent springs (overlap)   −(2 + H)
stress of independent springs              −(2 + 2H)
=========================================  ============

and Persson's theory the stress spectrum

.. math:: C_\sigma(q) = \tfrac14 E^{*2}q^2C(q)\,P\,[\gamma + (1-\gamma)P^2], \qquad
          P = \mathrm{erf}\frac{\sqrt2\,p}{E^*\xi(q)} .
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SolverError
from roughbench.observables.fields import Field, FloatArray, Profile
from roughbench.spectrum import Spectrum, wavenumbers

IntArray = NDArray[np.int64]

RINGS_PER_DECADE = 10
_AXIS = "wavevector, 1/length"


def stress_spectrum(state: Field) -> Profile:
    """Return C_σ(q) of the contact pressure in units of E*, length² (length on a line).

    Returns
    -------
    Profile
        ``variance`` is that of σ/E*, the integral of it.
    """
    return _spectrum("stress_spectrum", state.pressure, state)


def contact_spectrum(state: Field) -> Profile:
    """Return C(q) of the contact indicator, 1 in contact and else 0, length².

    Returns
    -------
    Profile
        ``variance`` is c(1 − c) with the share c of points in contact.
    """
    return _spectrum("contact_spectrum", state.contact.astype(float), state)


def energy_spectrum(state: Field) -> Profile:
    r"""Return the elastic energy U/(A0 E*) held by each ring of wavevectors, length.

    A half-space holds :math:`\sum|\sigma_q|^2/(E^*q)` (the mean of the pressure costs
    nothing), independent springs :math:`\sum|\sigma_q|^2/2k_w`.

    Returns
    -------
    Profile
        ``total`` is the sum over the rings.
    """
    power, weight, q, ring, edges = _modes(state.pressure, state)
    compliance = 1.0 / q if state.modulus is None else np.full(q.shape, 0.5 / state.modulus)
    held: FloatArray = np.bincount(ring, weight * power * compliance, edges.size - 1).astype(
        np.float64
    )
    return Profile(
        "energy",
        _AXIS,
        edges,
        _places(weight, q, ring, edges.size - 1),
        held,
        {"total": float(held.sum())},
    )


def _spectrum(name: str, values: FloatArray, state: Field) -> Profile:
    power, weight, q, ring, edges = _modes(values, state)
    count = edges.size - 1
    number = np.bincount(ring, weight, count)
    total = np.bincount(ring, weight * power, count)
    volume = state.spacing**values.ndim * values.size / (2.0 * math.pi) ** values.ndim
    density = np.full(count, math.nan)
    np.divide(total * volume, number, out=density, where=number > 0.0)
    return Profile(
        name,
        _AXIS,
        edges,
        _places(weight, q, ring, count),
        density,
        {"variance": float(total.sum())},
    )


def _modes(
    values: FloatArray, state: Field
) -> tuple[
    FloatArray, FloatArray, FloatArray, np.ndarray[tuple[int], np.dtype[np.int64]], FloatArray
]:
    """Return |f_q|², how many modes each stands for, |q|, and its ring; without q = 0."""
    transform = np.fft.rfftn(values, norm="forward")
    power = (np.abs(transform) ** 2).ravel()[1:]
    weight = np.full(transform.shape, 2.0)
    weight[..., 0] = 1.0
    if values.shape[-1] % 2 == 0:
        weight[..., -1] = 1.0
    q = wavenumbers(values.shape, state.length).ravel()[1:]
    lowest = 2.0 * math.pi / (state.spacing * max(values.shape))
    # The first edge is below the longest wave by half a ring.
    steps = RINGS_PER_DECADE * np.log10(q / lowest) + 0.5
    ring = np.floor(steps + 1e-9).astype(np.int64)
    edges = lowest * 10.0 ** ((np.arange(ring.max() + 2) - 0.5) / RINGS_PER_DECADE)
    return power, weight.ravel()[1:], q, ring, edges


def _places(
    weight: FloatArray,
    q: FloatArray,
    ring: IntArray,
    count: int,
) -> FloatArray:
    """Return the geometric mean of the wavevectors of each ring, nan for none."""
    number = np.bincount(ring, weight, count)
    total = np.bincount(ring, weight * np.log(q), count)
    mean = np.full(count, math.nan)
    np.divide(total, number, out=mean, where=number > 0.0)
    return np.exp(mean)


def exponent(profiles: Sequence[Profile], q_low: float, q_high: float) -> tuple[float, float]:
    """Return the exponent of a spectrum between two wavevectors, and its standard error.

    Parameters
    ----------
    profiles : sequence of Profile
        One a realization.
    q_low, q_high : float
        1/length; at least three rings between them.

    Returns
    -------
    (float, float)
        Mean over the realizations of the least-squares slopes of ln C over ln q, and its
        standard error (nan for one realization).

    Raises
    ------
    SolverError
        If there are fewer than three rings, or one of them holds no power.
    """
    slopes = []
    for profile in profiles:
        inside = (profile.places >= q_low) & (profile.places <= q_high)
        values = profile.values[inside]
        if values.size < 3 or not (values > 0.0).all():
            raise SolverError(
                f"{profile.name} has {values.size} rings between q = {q_low:g} and "
                f"{q_high:g}; a slope needs three with power"
            )
        slopes.append(float(np.polyfit(np.log(profile.places[inside]), np.log(values), 1)[0]))
    if not slopes:
        raise SolverError("an exponent needs at least one realization")
    error = (
        float(np.std(slopes, ddof=1)) / math.sqrt(len(slopes)) if len(slopes) > 1 else math.nan
    )
    return float(np.mean(slopes)), error


def persson_stress_spectrum(
    spectrum: Spectrum, q: ArrayLike, nominal: float, gamma: float = 0.45
) -> FloatArray:
    """Return Persson's C_σ(q) of a surface in units of E*; the equation stands above.

    Parameters
    ----------
    spectrum : Spectrum
    q : array_like of float64
        1/length.
    nominal : float
        p/E* > 0.
    gamma : float
        0 < γ ≤ 1.

    Returns
    -------
    ndarray of float64
        length².

    Raises
    ------
    SolverError
        If the pressure or γ is out of its range.
    """
    if not nominal > 0.0 or not 0.0 < gamma <= 1.0:
        raise SolverError("Persson's stress spectrum needs p > 0 and 0 < γ ≤ 1")
    wave = np.asarray(q, float)
    slope = np.array([math.sqrt(spectrum.moment(2, k)) for k in wave.ravel()])
    with np.errstate(divide="ignore"):
        argument = math.sqrt(2.0) * nominal / slope
    contact = np.array([math.erf(x) for x in argument]).reshape(wave.shape)
    damped = contact * (gamma + (1.0 - gamma) * contact**2)
    return np.asarray(0.25 * wave**2 * spectrum.psd_2d(wave) * damped)
