r"""Heights with a given spectrum: periodic surfaces, the lines mapped from them, grids.

Every Fourier mode draws its random numbers at a place in the stream that depends on
its wavevector alone (square shells outwards), so the same generator gives the *same*
surface on every grid that resolves it, and raising q1 only adds modes to it.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.inputs import whole_number
from roughbench.spectrum import Spectrum, mode_power
from roughbench.spectrum import wavenumbers as wavenumbers  # others import it from here

FloatArray = NDArray[np.float64]
Amplitude = Literal["fixed", "gaussian"]
Undersampled = Literal["error", "truncate", "alias"]


def realization_generator(seed: int, realization: int) -> np.random.Generator:
    """Return the random stream of one realization, independent of all others.

    Parameters
    ----------
    seed : int
        The spec's seed, ≥ 0.
    realization : int
        Index of the realization, from 0.
    """
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(realization,)))


def highest_mode(spectrum: Spectrum, length: float) -> int:
    """Largest n with 2πn/length within the spectrum (rounding forgiven)."""
    return math.floor(spectrum.q_max * length / (2.0 * math.pi) * (1.0 + 1e-12))


def check_grid(n_points: int, spectrum: Spectrum, length: float, remedy: str = "") -> int:
    """Return the highest mode, or refuse a grid too coarse to carry it.

    Raises
    ------
    SurfaceError
        If fewer than two points fall on the shortest wavelength; says which grid
        would do.
    """
    n_modes = highest_mode(spectrum, length)
    if n_modes < 1:
        raise SurfaceError(
            f"the cell of side {length:g} is shorter than the shortest wavelength "
            f"2π/q1 = {2 * math.pi / spectrum.q_max:g}; enlarge length or q1"
        )
    if 2 * n_modes > n_points:
        raise SurfaceError(
            f"{n_points} points per side are too coarse for q1: its {n_modes} waves per "
            f"side need at least {2 * n_modes} points, and {4 * n_modes} resolve them"
            f" with 4 points each{remedy}"
        )
    return n_modes


def make_surface(
    spectrum: Spectrum,
    n_points: int,
    length: float,
    generator: np.random.Generator | int,
    amplitude: Amplitude = "fixed",
) -> FloatArray:
    r"""Return a periodic random surface h(x) = Σ h_q e^{iq·x}, ⟨|h_q|²⟩ = (2π/L)² C2D(q).

    The modes are q = (2π/L)(n_x, n_y) with q0 ≤ |q| ≤ q1 (a circular cut-off).

    Parameters
    ----------
    spectrum : Spectrum
    n_points : int
        Points per side N; at least two for the shortest wavelength.
    length : float
        Side L of the cell, length.
    generator : numpy.random.Generator or int
        See :func:`realization_generator`; a whole number is the seed of realization 0.
    amplitude : {"fixed", "gaussian"}
        Random phases with the exact amplitude, or complex normal amplitudes.

    Returns
    -------
    ndarray of float64, shape (N, N)
        Heights with zero mean, length.

    Raises
    ------
    SurfaceError
        If the grid is too coarse for the spectrum.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.8, q_min=1, q_rolloff=1, q_max=8, rms_slope=0.1)
    >>> coarse, fine = (
    ...     make_surface(spectrum, n, 2 * np.pi, realization_generator(1, 0)) for n in (16, 32)
    ... )
    >>> bool(np.allclose(coarse, fine[::2, ::2], atol=1e-15))
    True
    """
    n_modes = check_grid(n_points, spectrum, length)
    step = 2.0 * math.pi / length
    unit = _unit_modes(generator, 2 * n_modes * (n_modes + 1), amplitude)
    ny = np.arange(n_modes + 1)
    modes = np.zeros((n_points, n_points // 2 + 1), complex)
    for nx in range(-n_modes, n_modes + 1):
        amplitude_q = step * np.sqrt(spectrum.psd_2d(step * np.hypot(nx, ny)))
        row = amplitude_q * unit[_place_in_stream(nx, ny)]
        if nx <= 0:
            row[0] = 0.0  # on the axis n_y = 0 the modes n_x > 0 stand for both signs
        else:
            modes[-nx % n_points, 0] += np.conj(row[0])
        modes[nx % n_points, : n_modes + 1] += row
    if 2 * n_modes == n_points:  # at the Nyquist column both ±n_y fall on one entry
        nyquist = modes[:, -1]
        modes[:, -1] = nyquist + np.conj(nyquist[(-np.arange(n_points)) % n_points])
    heights: FloatArray = np.fft.irfft2(modes, s=(n_points, n_points), norm="forward")
    return heights


def make_profile(
    spectrum: Spectrum,
    n_points: int,
    length: float,
    generator: np.random.Generator | int,
    amplitude: Amplitude = "fixed",
    undersampled: Undersampled = "error",
) -> FloatArray:
    r"""Return the line h(x) = 2 Re Σ_n h_n e^{2πinx/L}, ⟨|h_n|²⟩ = (2π/L) C1D(2πn/L).

    C1D = πqC2D keeps the height and the full slope of the surface (Popov's mapping).

    Parameters
    ----------
    spectrum : Spectrum
    n_points : int
        Points N on the line.
    length : float
        Period L, length.
    generator : numpy.random.Generator or int
        As for :func:`make_surface`.
    amplitude : {"fixed", "gaussian"}
    undersampled : {"error", "truncate", "alias"}
        What to do with modes above N/2: refuse, leave them out, or sample them as they
        are, so that n appears as N − n. Both losses lower the slope: with H = 0.7,
        q1 = 8192 q0 and 8192 points from 0.100 to 0.081 and 0.086.

    Returns
    -------
    ndarray of float64, shape (N,)
        Heights with zero mean, length.

    Raises
    ------
    SurfaceError
        If the line is too coarse for the spectrum and ``undersampled`` is "error".
    """
    n_modes = highest_mode(spectrum, length)
    if undersampled == "error" or n_modes < 1:
        n_modes = check_grid(
            n_points,
            spectrum,
            length,
            remedy="; or choose undersampled: truncate or alias, at the price of slope",
        )
    unit = _unit_modes(generator, n_modes, amplitude)
    if undersampled == "truncate":
        n_modes = min(n_modes, n_points // 2)
    n = np.arange(1, n_modes + 1)
    step = 2.0 * math.pi / length
    h_q = np.sqrt(step * spectrum.psd_1d(step * n)) * unit[:n_modes]
    # Sample the continuous line: mode ±n falls on the entry ±n modulo N.
    modes = np.zeros(n_points, complex)
    np.add.at(modes, n % n_points, h_q)
    np.add.at(modes, -n % n_points, np.conj(h_q))
    heights: FloatArray = np.fft.ifft(modes, norm="forward").real
    return heights - heights.mean()


def make_twin(heights: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Return a surface with the waves of another, each with its amplitude and a random phase.

    Its power spectrum is the same in every direction; its heights are Gaussian for many waves,
    whatever those of the other are.

    Parameters
    ----------
    heights : ndarray of float64, shape (n, m)
        Periodic heights, length.
    generator : numpy.random.Generator
        Gives the phases of white noise, so that they belong to this grid.

    Returns
    -------
    ndarray of float64, shape (n, m)
        Heights with zero mean, length.

    Examples
    --------
    >>> heights = np.cos(2 * np.pi * np.arange(16) / 16) * np.ones((8, 1))
    >>> twin = make_twin(heights, np.random.default_rng(0))
    >>> bool(np.allclose(mode_power(twin), mode_power(heights)))
    True
    """
    modes = np.abs(np.fft.rfft2(heights))
    modes[0, 0] = 0.0
    noise = np.fft.rfft2(generator.standard_normal(heights.shape))
    noise /= np.abs(noise)
    noise *= modes
    twin: FloatArray = np.fft.irfft2(noise, s=heights.shape)
    return twin


def _place_in_stream(nx: int, ny: NDArray[np.int64]) -> NDArray[np.int64]:
    """Place of mode (n_x, n_y ≥ 0) in the random stream, by square shells outwards.

    Shell s = max(|n_x|, n_y) follows the 2s(s-1) modes of the inner shells and holds
    4s: the edge n_y = s, then n_x = s on the axis, then the sides upwards. Modes that
    a surface does not use (n_y = 0, n_x ≤ 0) get an arbitrary valid place.
    """
    shell = np.maximum(abs(nx), ny)
    on_side = np.where(ny > 0, 2 * shell + 2 * ny + (nx > 0), 2 * shell + 1)
    place = 2 * shell * (shell - 1) + np.where(ny == shell, nx + shell, on_side)
    return np.where(shell > 0, place, 0)


def _unit_modes(
    generator: np.random.Generator | int, count: int, amplitude: Amplitude
) -> NDArray[np.complex128]:
    """Random complex numbers with ⟨|z|²⟩ = 1, in the order of the stream."""
    if not isinstance(generator, np.random.Generator):
        seed = whole_number(generator, "the seed of a surface", 0, SurfaceError)
        generator = realization_generator(seed, 0)
    if amplitude == "fixed":
        return np.exp(2j * np.pi * generator.random(count))
    normal = generator.standard_normal((count, 2))
    unit: NDArray[np.complex128] = normal.view(np.complex128)[:, 0] / math.sqrt(2.0)
    return unit


def rms_height_and_slope(heights: FloatArray, length: float) -> tuple[float, float]:
    """Return √⟨(h − ⟨h⟩)²⟩ and √⟨|∇h|²⟩ of the heights, by Fourier derivatives.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m)
        Length.
    length : float
        Period along the first axis, length; pixels are square.

    Returns
    -------
    (float, float)
        rms height (length) and rms slope.
    """
    power = mode_power(heights)
    q = wavenumbers(heights.shape, length)
    return math.sqrt(power.sum()), math.sqrt((power * q * q).sum())
