"""How the gap is distributed over the points out of contact."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from roughbench.observables.base import IN_CONTACT, Observable
from roughbench.observables.fields import Field, Profile
from roughbench.quantities import Variable

GAP_EDGES = np.geomspace(1e-4, 10.0, 101)
"""g/h_rms."""


class GapDensity(Observable):
    """The distribution of the gap over the points out of contact.

    Over g/h_rms, the density in this unit among *all* points: its integral, with the
    shares ``below`` and ``above`` the bins and in ``contact``, is one.
    ``separation`` is ū/h_rms.
    """

    name = "gap_pdf"
    title = "Distribution of the gap"
    x, y = "gap $g/h_rms$", "density"
    is_in_heights = True
    values = Variable("density of the gap out of contact over all points, per h_rms")
    places = Variable("gap / h_rms")
    scalars: ClassVar = {
        "contact": IN_CONTACT,
        "separation": Variable("mean separation / h_rms"),
        "below": Variable("share of points with a gap below the bins"),
        "above": Variable("share of points with a gap above the bins"),
    }

    def compute(self, field: Field) -> Profile:
        """Return it for one state."""
        gap = field.gap[~field.contact] / field.rms_height
        counts, _ = np.histogram(gap, GAP_EDGES)
        points = field.pressure.size
        return Profile(
            self.name,
            edges=GAP_EDGES,
            places=np.sqrt(GAP_EDGES[1:] * GAP_EDGES[:-1]),
            values=counts / points / np.diff(GAP_EDGES),
            scalars={
                "contact": 1.0 - gap.size / points,
                "separation": float(gap.sum()) / points,
                "below": float((gap < GAP_EDGES[0]).sum()) / points,
                "above": float((gap > GAP_EDGES[-1]).sum()) / points,
            },
        )


gap_pdf = GapDensity()
