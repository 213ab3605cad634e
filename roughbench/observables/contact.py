"""The spectrum of the contact: where the bodies touch, not how hard."""

from __future__ import annotations

from roughbench.observables.fields import Field, FloatArray
from roughbench.observables.rings import SpectralDensity
from roughbench.quantities import Variable


class ContactSpectrum(SpectralDensity):
    """C(q) of the contact indicator, 1 in contact and 0 elsewhere.

    ``variance`` is c(1 − c) with the share c of points in contact.
    """

    name = "contact_spectrum"
    title = "Spectrum of the contact"
    y = "$C_c(q)$; of lines $C_c/πq$"
    values = Variable(
        "power spectrum C(q) of the contact, 1 in it and 0 elsewhere", per_dimension=1
    )
    scalars = SpectralDensity.described("the contact, 1 in it and 0 elsewhere", "the contact")

    def function(self, field: Field) -> FloatArray:
        """Return 1 in contact and 0 elsewhere."""
        return field.contact.astype(float)


contact_spectrum = ContactSpectrum()
