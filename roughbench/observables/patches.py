"""The patches of the contact: how many, how large, how long their edges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from roughbench.observables.base import Observable
from roughbench.observables.fields import Field, FloatArray, Profile
from roughbench.quantities import Variable

_LARGEST = 40
"""Binary logarithm of the largest patch that has a bin, in points."""


@dataclass(frozen=True, slots=True)
class Patches:
    """The connected patches of a contact; arrays have shape (n,).

    Attributes
    ----------
    labels : ndarray of int64, shape of the field
        Number of the patch that a point belongs to, from 1; 0 out of contact.
    points : ndarray of int64
        Points of each patch.
    edges : ndarray of int64
        Sides of its points that border on a point out of contact.
    """

    labels: NDArray[np.int64]
    points: NDArray[np.int64]
    edges: NDArray[np.int64]


def find_patches(contact: NDArray[np.bool_]) -> Patches:
    """Return the patches of points that share sides, across the periodic borders too.

    Parameters
    ----------
    contact : ndarray of bool, shape (n, m) or (n,)

    Examples
    --------
    >>> patches = find_patches(np.array([True, True, False, True, False, True]))
    >>> patches.points.tolist(), patches.edges.tolist()
    ([3, 1], [2, 2])
    """
    from scipy.ndimage import label
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    labels, count = label(contact)
    pairs = []
    for axis in range(contact.ndim):
        first, last = np.take(labels, 0, axis).ravel(), np.take(labels, -1, axis).ravel()
        both = (first > 0) & (last > 0)
        pairs.append(np.stack([first[both], last[both]]))
    joined = np.concatenate(pairs, axis=1)
    graph = coo_array((np.ones(joined.shape[1]), joined), shape=(count + 1, count + 1))
    _, component = connected_components(graph, directed=False)
    # Number the patches by their first point; 0, out of contact, is joined to nothing.
    merged = component[labels]
    _, numbers = np.unique(merged, return_inverse=True)
    numbers = numbers.reshape(contact.shape)
    order = np.full(numbers.max() + 1, -1)
    kept = numbers[contact]
    _, first_place = np.unique(kept, return_index=True)
    order[kept[np.sort(first_place)]] = np.arange(1, first_place.size + 1)
    result = np.where(contact, order[numbers], 0)
    points = np.bincount(result.ravel(), minlength=first_place.size + 1)[1:]
    borders = np.zeros(contact.shape, np.int64)
    for axis in range(contact.ndim):
        for step in (1, -1):
            borders += contact & ~np.roll(contact, step, axis)
    sides = np.bincount(result.ravel(), borders.ravel(), first_place.size + 1)[1:]
    return Patches(result.astype(np.int64), points.astype(np.int64), sides.astype(np.int64))


class Clusters(Observable):
    """How many patches of contact of each size there are.

    Number of patches, by their size in points: 1, 2 to 3, 4 to 7, … Single numbers: the
    ``number`` of patches, their ``mean_area`` and the ``largest_area`` as shares of the
    nominal area, and the ``perimeter`` of all of them, length, along the sides of the pixels
    (longer than a smooth edge by 4/π on average). On a line the perimeter is the number of
    edges.
    """

    name = "clusters"
    title = "Patches of contact"
    x, y = "points of a patch", "number of patches"
    values = Variable("number of patches of contact")
    places = Variable("least size of a patch, points")
    scalars: ClassVar = {
        "number": Variable("number of patches of all sizes"),
        "mean_area": Variable("mean area of a patch / A0"),
        "largest_area": Variable("area of the largest patch / A0"),
        "perimeter": Variable("perimeter of all patches", length=-1, per_dimension=1),
    }

    def compute(self, field: Field) -> Profile:
        """Return it for one state."""
        patches = find_patches(field.contact)
        edges: FloatArray = np.exp2(np.arange(_LARGEST + 1, dtype=np.float64))
        counts, _ = np.histogram(patches.points, edges)
        total = field.pressure.size
        number = patches.points.size
        side = field.spacing if field.pressure.ndim == 2 else 1.0
        return Profile(
            self.name,
            edges=edges,
            places=edges[:-1],
            values=counts.astype(float),
            scalars={
                "number": float(number),
                "mean_area": float(patches.points.sum()) / total / max(number, 1),
                "largest_area": float(patches.points.max(initial=0)) / total,
                "perimeter": float(patches.edges.sum()) * side,
            },
        )


clusters = Clusters()
