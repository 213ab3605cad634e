"""Claims that the paper does not make."""

from __future__ import annotations

from roughbench.verdict.between import power_of_size
from roughbench.verdict.criteria import (
    AT_SMALL_AREA,
    NEAR_ONE_PERCENT,
    SAME_SEPARATION,
    SPRINGS,
)
from roughbench.verdict.experiments import EXACT
from roughbench.verdict.fields import spectrum_exponent
from roughbench.verdict.judging import Claim, Criterion
from roughbench.verdict.rules import near

_GROUP = "beyond"

BEYOND = (
    Claim(
        "overlap-stress",
        "beyond the paper",
        "The stress of independent springs is correlated as q^−(2+2H).",
        ("winkler",),
        (
            Criterion(
                "exponent of the stress spectrum of Winkler’s springs where the exact "
                f"{AT_SMALL_AREA}",
                spectrum_exponent("stress_spectrum", SPRINGS),
                near(SPRINGS, 0.2),
            ),
        ),
        f"a spec with bem and winkler and observables: [stress_spectrum], {NEAR_ONE_PERCENT}",
        _GROUP,
    ),
    Claim(
        "size-exact",
        "beyond the paper",
        "The exact ū(p) of a given spectrum does not depend on the size of the cell.",
        EXACT,
        (Criterion(SAME_SEPARATION, power_of_size, near(0.0, 0.2)),),
        "a spec with bem and a sweep over surface.length",
        _GROUP,
    ),
)
