"""What the criteria of several claims share: thresholds, which are ours, rules and words.

A model follows the exact solution if it stays within a factor :data:`FOLLOWS` (e to the rms of
the logarithm of the ratio), and is far off from a factor :data:`FAR_OFF` on; in between,
neither is shown, however small the error. K ∼ p and U ∼ p hold over so many decades if the
ratio drifts by less than :data:`DRIFT` over them, where it drifts least.
"""

from __future__ import annotations

from roughbench.verdict.judging import Criterion
from roughbench.verdict.measures import SMALL_AREA, SYMBOLS, fitted
from roughbench.verdict.rules import PowerLaw, at_least, at_most

FOLLOWS, FAR_OFF = 1.5, 2.0
DRIFT = 1.2
"""A band of ±10 %, as for A ∼ p, allows 1.22."""

TO_FOLLOW = at_most(FOLLOWS, fails_above=FAR_OFF, of_ratio=True)
TO_BE_FAR_OFF = at_least(FAR_OFF, fails_below=FOLLOWS, of_ratio=True)
NOT_TO_DRIFT = at_most(DRIFT, of_ratio=True)

FEW_CONTACTS = PowerLaw("1/(1+H)", lambda h: 1.0 / (1.0 + h))
COUPLED = PowerLaw("−(1+H)", lambda h: -(1.0 + h))
OVERLAP = PowerLaw("−(2+H)", lambda h: -(2.0 + h))
SPRINGS = PowerLaw("−(2+2H)", lambda h: -(2.0 + 2.0 * h))

BEM = "a spec with bem, at pressures from 1e-6 to 0.1"
FEW = (
    "a spec with bem, surface.qr = q0 and surface.q1 of at least 512 q0, at pressures from 1e-7"
)
"""With a roll-off it is q1/q_r that has to be as large, at lower pressures."""
FEW_OF_EACH = (
    "a spec with bem, surface.q1 of at least 512 times every surface.qr, at pressures from 1e-8"
)
NEAR_ONE_PERCENT = "at a pressure with A/A₀ near 1 %"
TWO_LOADS = "at pressures with A/A₀ from 0.001 to 0.1 of which two are a factor 3 apart"

_FACTOR = "factor between the model's {} and the exact one{} where the exact solution has {}"
_OWN_UNITS = ", each with the rms height of its own surfaces,"
FACTORS = {
    quantity: _FACTOR.format(SYMBOLS[quantity], unit, law) + ": {rule}"
    for quantity, unit, law in (
        ("area", "", "A ∼ p"),
        ("separation", _OWN_UNITS, "K ∼ p"),
        ("stiffness", _OWN_UNITS, "K ∼ p"),
    )
}
PRESSURES = (
    "factor between the pressures of model and exact solution at equal ū/h_rms, each with the "
    "rms height of its own surfaces, where the exact solution has K ∼ p: {rule}"
)
SAME_SEPARATION = "s of p ∼ Lˢ at the same ū, cells that differ in L alone: {rule}"
AT_SMALL_AREA = f"A/A₀ is about {SMALL_AREA * 100:g} %: {{rule}}"


def drift(decades: int, whose: str) -> Criterion:
    """Return the criterion that K/p drifts by little over so many decades."""
    span = f"{decades} decade{'s' * (decades != 1)}"
    return Criterion(
        f"factor by which K/p of {whose} changes over {span}, where it changes least: {{rule}}",
        fitted(f"drift_{decades}", f"drift of K/p over {span}"),
        NOT_TO_DRIFT,
    )
