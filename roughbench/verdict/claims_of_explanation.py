"""Our tests of the paper's explanation: coupling, dimension, repetition.

The preprint's abstract attributes the failure of the foundation to the neglect of the elastic
coupling, the published one to its incorrect treatment. Both readings are tested: the neglect
by springs under the surface itself, which share the half-space's mean response alone, the
treatment by the scale that the foundation gives its pressures.
"""

from __future__ import annotations

from roughbench.verdict.between import power_of_size, repetition
from roughbench.verdict.criteria import (
    FACTORS,
    PRESSURES,
    SAME_SEPARATION,
    TO_BE_FAR_OFF,
    TO_FOLLOW,
)
from roughbench.verdict.experiments import EXACT
from roughbench.verdict.judging import Claim, Criterion
from roughbench.verdict.measures import factor, pressure_factor
from roughbench.verdict.rules import near

_GROUP = "explanation"
_NOUNS = {
    "area": "the contact area",
    "separation": "the mean separation",
    "stiffness": "the stiffness",
}


def _criterion(quantity: str, whose: str, *, is_far_off: bool) -> Criterion:
    """Return the criterion of a quantity; of ū it is the pressure at equal ū."""
    rule = TO_BE_FAR_OFF if is_far_off else TO_FOLLOW
    if quantity == "separation":
        return Criterion(f"{whose}: {PRESSURES}", pressure_factor(), rule)
    return Criterion(f"{whose}: {FACTORS[quantity]}", factor(quantity), rule)


EXPLANATION = (
    *(
        Claim(
            f"coupling-{quantity}",
            "abstract of the preprint, Secs. 5, 6",
            "The foundation fails because it neglects the long-range elastic coupling: "
            f"springs that share its mean response alone are off in {noun} on the surface "
            "itself as well.",
            ("winkler",),
            (
                _criterion(
                    quantity,
                    "Winkler’s independent springs, under the surface",
                    is_far_off=True,
                ),
            ),
            group=_GROUP,
        )
        for quantity, noun in _NOUNS.items()
    ),
    Claim(
        "size-foundation",
        "abstract as published",
        "The foundation treats the elastic coupling incorrectly: the scale of its pressures is "
        "tied to the size of the cell as 1/L.",
        ("foundation",),
        (Criterion(SAME_SEPARATION, power_of_size, near(-1.0, 0.2)),),
        "a spec with bem, foundation and a sweep over surface.length",
        _GROUP,
    ),
    *(
        Claim(
            f"dimension-{quantity}",
            "Secs. 5, 6",
            "The reduced dimension is not the problem: a line with elastic coupling follows "
            f"the surface in {noun}.",
            ("line",),
            (_criterion(quantity, "the exact solution of a line", is_far_off=False),),
            group=_GROUP,
        )
        for quantity, noun in _NOUNS.items()
    ),
    Claim(
        "repetition",
        "Sec. 5",
        "With a roll-off the surface is as if repeated (q_r/q₀)² times: the scatter of K "
        "between surfaces falls as q₀/q_r.",
        EXACT,
        (
            Criterion(
                "s of scatter(K) ∼ (q_r/q₀)ˢ at one pressure, surfaces that differ in q_r "
                "alone: {rule}",
                repetition,
                near(-1.0, 0.3),
            ),
        ),
        "a spec with bem, 16 realizations and sweep: {surface.qr: [1.0, 2.0, 4.0, 8.0]}",
        _GROUP,
    ),
)
