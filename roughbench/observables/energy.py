r"""The elastic energy by wavevector.

A half-space holds :math:`\sum|\sigma_q|^2/(E^*q)` (the mean of the pressure costs
nothing), with a screening :math:`q_c` it is :math:`\sqrt{q^2 + q_c^2}` in place of q, and
independent springs hold :math:`\sum|\sigma_q|^2/2k_w`.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from roughbench.observables.base import Observable
from roughbench.observables.fields import Field, Profile
from roughbench.observables.rings import WAVEVECTOR, modes_of
from roughbench.quantities import Variable


class EnergySpectrum(Observable):
    """The elastic energy U/(A0 E*) held by each ring of wavevectors, length.

    ``total`` is the sum over the rings.
    """

    name = "energy"
    variable = "energy_spectrum"  # energy is a quantity
    title = "Elastic energy by wavevector"
    x, y = "wavevector $q$", "energy per ring"
    values = Variable(
        "elastic energy U/(A0 E*) held by a ring of wavevectors", length=1, modulus=1
    )
    places = WAVEVECTOR
    scalars: ClassVar = {
        "total": Variable(
            "elastic energy U/(A0 E*) held by all wavevectors", length=1, modulus=1
        )
    }

    def compute(self, field: Field) -> Profile:
        """Return it for one state."""
        modes = modes_of(field.pressure, field)
        if field.modulus is None:
            compliance = 1.0 / np.hypot(modes.q, field.screening)
        else:
            compliance = np.full(modes.q.shape, 0.5 / field.modulus)
        held = modes.total(modes.power * compliance)
        total = {"total": float(held.sum())}
        return Profile(self.name, modes.edges, modes.places, held, total)


energy_spectrum = EnergySpectrum()
