"""Loops over the vectors of a working set alone."""

from __future__ import annotations

import numpy as np

from roughbench.models.halfspace.loops import NEVER_FREE, loop


@loop
def contact_sums(a, b, size, p, r):
    """Return the number of points with p > 0 and Σr over them."""
    one = p.dtype.type(1)
    zero = one - one
    n = 0.0
    total = 0.0
    for tile in range(a, b):
        p_here = p[tile * size : (tile + 1) * size]
        r_here = r[tile * size : (tile + 1) * size]
        n_here = here = zero
        for k in range(size):
            loaded = p_here[k] > 0
            n_here += one if loaded else zero
            residual = r_here[k]
            here += residual if loaded else zero
        n += n_here
        total += here
    return n, total


@loop
def mark_contact(a, b, size, p, value, r):
    """r = ``value`` where p > 0, ``NEVER_FREE`` elsewhere."""
    for k in range(a * size, b * size):
        r[k] = value if p[k] > 0 else NEVER_FREE


@loop
def add(a, b, size, factor, values, total):
    """total += factor·values."""
    for tile in range(a, b):
        values_here = values[tile * size : (tile + 1) * size]
        total_here = total[tile * size : (tile + 1) * size]
        for k in range(size):
            total_here[k] += factor * values_here[k]


@loop
def drop_residues(a, b, size, p, r, alpha, stiffness):
    """p = 0 where a gap ρ = r − α > 0 is more than p could close alone, p < ``stiffness``·ρ."""
    for k in range(a * size, b * size):
        if p[k] < stiffness * (r[k] - alpha):
            p[k] = 0


@loop
def use_residual(a, b, size, vectors, one, alpha):
    """s = ρ on free points, zero on the others; returns the number of these and Σs."""
    p, r, _, z, _ = vectors
    zero = one - one
    n_free = 0.0
    total = 0.0
    for tile in range(a, b):
        base = tile * size
        p_here, r_here = p[base : base + size], r[base : base + size]
        z_here = z[base : base + size]
        n_here = here = zero
        for k in range(size):
            rho = r_here[k] - alpha
            free = (p_here[k] > 0) | (rho < 0)
            rho = rho if free else zero
            z_here[k] = rho
            n_here += one if free else zero
            here += rho
        n_free += n_here
        total += here
    return n_free, total


@loop
def trial_load(a, b, size, p, d, tau):
    """Σ of the loads of the tiles, as :func:`.relaxation.update_direction` returns it."""
    zero = tau - tau
    total = 0.0
    for tile in range(a, b):
        p_here = p[tile * size : (tile + 1) * size]
        d_here = d[tile * size : (tile + 1) * size]
        load = zero
        for k in range(size):
            load += p_here[k] + tau * d_here[k]
        total += max(load, zero)
    return total


@loop
def largest_step(a, b, size, p, s):
    """Largest t with p + ts ≥ 0."""
    one = p.dtype.type(1)
    far = one / (one - one)
    reach = np.full(size, far, p.dtype)
    for tile in range(a, b):
        p_here = p[tile * size : (tile + 1) * size]
        s_here = s[tile * size : (tile + 1) * size]
        for k in range(size):
            ratio = -p_here[k] / s_here[k]
            reach[k] = min(reach[k], ratio if s_here[k] < 0 else far)
    return np.float64(reach.min())
