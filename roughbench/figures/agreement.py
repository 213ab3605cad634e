r"""Where two stiffnesses agree: the criterion behind the vertical lines of Fig. 4.

Popov's stiffness leaves the analytical one where

.. math:: |\ln (K_\mathrm{Popov} / K_\mathrm{Persson})| = \ln 2

(:data:`FACTOR`): at the ends of the widest range of pressure, in :math:`\ln p`, in which
the two curves as drawn differ by less than this factor. Between the pressures of the
results :math:`\ln(K_\mathrm{Popov}/K_\mathrm{Persson})` is taken as linear in
:math:`\ln p`; from a finite value to an infinite one the *inverse* ratio is. Persson's
stiffness contains the finite-size term if the spec says so. The factor is a choice, and
a coarse one: the standard errors of 100 realizations are some 3 %, but Persson's
prefactor depends on γ by 30 % and eq. (10)'s on θ by a factor 2. :func:`departures`
returns the pressures, for this factor or another.

With the paper's surfaces (H = 0.7, q1 = 8192 q0, ξ = 0.1; γ = 0.45; 100 realizations of
32768 springs; 71 pressures from 1e-8 to 0.1) the two agree within a factor 2 for p/E* from
2.0e-5 to 1.6e-3 (qr = q0) and from 3.4e-6 to 2.1e-4 (qr = 8 q0). The larger of Persson's
stiffness and eq. (10) with θ = 1 moves only the first, to 1.6e-5. With a factor 1.5 it is
4.9e-5 to 1.3e-3 and 1.1e-5 to 1.2e-4.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from roughbench.figures.axes import BARE, Axes
from roughbench.figures.curves import curve_of
from roughbench.fits.windows import Part, part_between, widest_run
from roughbench.models.registry import is_modified
from roughbench.results import ModelResult, Results

FACTOR = 2.0
"""Largest ratio of two stiffnesses that counts as agreement."""


@dataclass(frozen=True, slots=True)
class Agreement:
    """The widest range of pressure in which two stiffnesses agree within a factor.

    Attributes
    ----------
    factor : float
        The criterion.
    found : bool
        Whether they agree anywhere.
    lower, upper : float or None
        p/E* where they part; None where they agree up to the last pressure there is.
    """

    factor: float
    found: bool
    lower: float | None = None
    upper: float | None = None

    @property
    def pressures(self) -> tuple[float, ...]:
        """The pressures of departure, none to two of them."""
        return tuple(p for p in (self.lower, self.upper) if p is not None)


def agreement(
    pressure: ArrayLike, stiffness: ArrayLike, reference: ArrayLike, factor: float = FACTOR
) -> Agreement:
    """Return where two curves agree within a factor, by the criterion of this module.

    Parameters
    ----------
    pressure : array_like of float64, shape (P,)
        p/E* > 0, ascending.
    stiffness, reference : array_like of float64, shape (P,)
        Positive, in one unit, may be inf; states with nan, or with both infinite, are
        passed over.
    factor : float
        Greater than 1.

    Examples
    --------
    >>> p = [1.0, 10.0, 100.0]
    >>> agreement(p, [1.0, 10.0, 100.0], [10.0, 10.0, 10.0], factor=3.0).pressures
    (3.33..., 30.0...)
    >>> agreement(p, [1.0, 1.0, 1.0], [5.0, 5.0, 5.0]).found
    False
    """
    if not factor > 1.0:
        raise ValueError(f"the factor must be greater than 1, got {factor}")
    with np.errstate(invalid="ignore"):
        ratio = np.asarray(stiffness, float) / np.asarray(reference, float)
    known = ~np.isnan(ratio)
    x = np.log(np.asarray(pressure, float)[known])
    ratio = ratio[known]
    parts = (_part(a, b, factor) for a, b in itertools.pairwise(ratio))
    start, end = widest_run(x, parts)
    if math.isnan(start):
        return Agreement(factor, found=False)
    return Agreement(
        factor,
        found=True,
        lower=math.exp(start) if start > x[0] else None,
        upper=math.exp(end) if end < x[-1] else None,
    )


def _part(a: float, b: float, factor: float) -> Part:
    """Return the part of the way from a ratio to the next that is within the factor of 1."""
    low, high = 1.0 / factor, factor
    if np.isinf(a) or np.isinf(b):
        with np.errstate(divide="ignore"):
            a, b = np.divide(1.0, (a, b))
    elif a > 0.0 and b > 0.0:
        a, b, low, high = np.log((a, b, low, high))
    return part_between(*(np.asarray(value) for value in (a, b, low, high)))


def departures(results: Results, factor: float = FACTOR) -> dict[str, Agreement | None]:
    """Return for every experiment where the foundation and Persson's theory agree.

    Parameters
    ----------
    results : Results
    factor : float
        The criterion.

    Returns
    -------
    dict of str to Agreement or None
        By experiment; None where one of the two is missing, or their pressures differ.
        Of several models of one kind the first counts.
    """
    reduced = results.reduced()
    return {name: agreement_in(reduced, name, factor) for name in reduced}


def agreement_in(
    results: Results, experiment: str, factor: float, shown: Axes = BARE
) -> Agreement | None:
    """Return where foundation and theory agree in one experiment (see departures).

    Pressures are those that axes show.
    """
    popov = _first(results, experiment, "foundation")
    persson = _first(results, experiment, "persson")
    if popov is None or persson is None:
        return None
    curve, reference = (curve_of(one, "stiffness", shown) for one in (popov, persson))
    if not np.array_equal(curve.pressure, reference.pressure):
        return None
    return agreement(curve.pressure, curve.value, reference.value, factor)


def _first(results: Results, experiment: str, kind: str) -> ModelResult | None:
    own = (
        one
        for one in results[experiment].values()
        if one.kind == kind and not is_modified(kind, one.attributes)
    )
    return next((one for one in own if "stiffness_mean" in one), None)
