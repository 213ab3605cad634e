"""The claims of Lyashenko, Pastewka and Persson (2013), and how each is decided.

A model follows the exact solution if it stays within a factor :data:`FOLLOWS` (e to the rms
of the logarithm of the ratio), and is far off from a factor :data:`FAR_OFF` on; in between,
neither is shown, however small the error.
"""

from __future__ import annotations

from roughbench.fits.laws import AREA_TOLERANCE, SLOPE_TOLERANCE, STIFFNESS_TOLERANCE
from roughbench.verdict.experiments import EXACT
from roughbench.verdict.judging import Claim, Criterion
from roughbench.verdict.measures import (
    MANY_SCALES,
    ROLLOFF,
    SMALL_AREA,
    SYMBOLS,
    closing_ratio,
    factor,
    factor_of_cutoff,
    fitted,
    has_the_rolloff,
    is_as_published,
    kappa,
    kappa_over_rolloff,
    power_of_size,
    spectrum_exponent,
    stiffness_exponent,
)
from roughbench.verdict.rules import PowerLaw, about, at_least, at_most, near

FOLLOWS, FAR_OFF = 1.5, 2.0
TO_FOLLOW = at_most(FOLLOWS, fails_above=FAR_OFF, of_ratio=True)
TO_BE_FAR_OFF = at_least(FAR_OFF, fails_below=FOLLOWS, of_ratio=True)

_FEW_CONTACTS = PowerLaw("1/(1+H)", lambda h: 1.0 / (1.0 + h))
_COUPLED = PowerLaw("−(1+H)", lambda h: -(1.0 + h))
_OVERLAP = PowerLaw("−(2+H)", lambda h: -(2.0 + h))
_SPRINGS = PowerLaw("−(2+2H)", lambda h: -(2.0 + 2.0 * h))

_BEM = "any spec with bem, at pressures from 1e-6 to 0.1"
_FEW = "a spec with bem, at pressures from 1e-7 and a large q1/q0"
_SLOPE = f"d ln K/d ln p, over two pressures, is 1 ± {SLOPE_TOLERANCE:g}"
_PLATEAU = f"width of the range on which {_SLOPE}, of the {{}}: {{{{rule}}}}"
_FACTOR = "factor between the model's {} and the exact one{} where the exact solution has {}"
_OWN_UNITS = ", each with the rms height of its own surfaces,"
_FACTORS = {
    quantity: _FACTOR.format(SYMBOLS[quantity], unit, law) + ": {rule}"
    for quantity, unit, law in (
        ("area", "", "A ∼ p"),
        ("separation", _OWN_UNITS, "K ∼ p"),
        ("stiffness", _OWN_UNITS, "K ∼ p"),
    )
}
_NOUNS = {
    "area": "the contact area",
    "separation": "the mean separation",
    "stiffness": "the stiffness",
}
_SAME_SEPARATION = "s of p ∼ Lˢ at the same ū, cells that differ in L alone: {rule}"
_AT_SMALL_AREA = f"A/A₀ is about {SMALL_AREA * 100:g} %: {{rule}}"
_MANY_SCALES = f"for q₁ ≥ {MANY_SCALES:g} q_r"

CLAIMS = (
    Claim(
        "area-linear",
        "eq. (3)",
        "The real contact area is proportional to the pressure, A/A₀ = κ p/(E*ξ), until "
        "A approaches A₀.",
        EXACT,
        (
            Criterion(
                "width of the range on which the exact A/p stays within "
                f"±{AREA_TOLERANCE * 100:g} % of one value: {{rule}}",
                fitted("kappa_decades", "decades of A ∼ p"),
                at_least(2.0, "decade"),
            ),
        ),
        _BEM,
    ),
    Claim(
        "kappa",
        "eq. (3)",
        "The factor is κ ≈ 2.",
        EXACT,
        (Criterion(f"exact κ: {{rule}}, {_MANY_SCALES}", kappa, near(2.0, 0.2)),),
        _BEM,
    ),
    Claim(
        "area-rolloff",
        "Fig. 3(a)",
        "The contact area does not depend on the roll-off.",
        EXACT,
        (
            Criterion(
                "ratio of the exact κ of surfaces that differ in q_r alone: {rule}, "
                f"{_MANY_SCALES}",
                kappa_over_rolloff,
                near(1.0, 0.1),
            ),
        ),
        "a spec with bem and sweep: {surface.qr: [1.0, 8.0]}",
    ),
    Claim(
        "area-persson",
        "Fig. 3(a)",
        "Persson's theory describes the contact area.",
        ("persson",),
        (Criterion(_FACTORS["area"], factor("area", is_as_published), TO_FOLLOW),),
    ),
    Claim(
        "area-foundation",
        "abstract of the preprint, Fig. 3(a)",
        "The one-dimensional foundation is far off in the contact area.",
        ("foundation",),
        (Criterion(_FACTORS["area"], factor("area"), TO_BE_FAR_OFF),),
    ),
    Claim(
        "closing-foundation",
        "Sec. 3, Fig. 3(a)",
        "In the foundation the area approaches A₀ at much lower pressure.",
        ("foundation",),
        (
            Criterion(
                "pressure at which A/A₀ = ½, exact over foundation: {rule}",
                closing_ratio,
                at_least(FAR_OFF, of_ratio=True),
            ),
        ),
    ),
    Claim(
        "separation-logarithmic",
        "eqs. (2), (9)",
        "The mean separation falls with the logarithm of the pressure, ū = u₀ ln(p₀/p), so "
        "that the stiffness is proportional to it, K = p/u₀.",
        EXACT,
        (
            Criterion(
                _PLATEAU.format("exact solution"),
                fitted("plateau_decades", "decades of slope 1"),
                at_least(1.0, "decade"),
            ),
        ),
        _BEM,
    ),
    Claim(
        "alpha",
        "eq. (2)",
        "u₀ = αh_rms with α of order one.",
        EXACT,
        (
            Criterion(
                "exact u₀ over the rms height of the realized surfaces: {rule}",
                fitted("alpha_realized", "α"),
                near(0.5, 0.1),
            ),
        ),
        _BEM,
    ),
    Claim(
        "separation-persson",
        "Fig. 3(b)",
        "Persson's theory describes the mean separation.",
        ("persson",),
        (Criterion(_FACTORS["separation"], factor("separation", is_as_published), TO_FOLLOW),),
    ),
    Claim(
        "separation-foundation",
        "abstract of the preprint, Fig. 3(b)",
        "The one-dimensional foundation is far off in the mean separation.",
        ("foundation",),
        (Criterion(_FACTORS["separation"], factor("separation"), TO_BE_FAR_OFF),),
    ),
    Claim(
        "three-regions",
        "Sec. 5, Fig. 4(a)",
        "The stiffness has three regions: K ∼ p^(1/(1+H)) where a few contacts carry all, "
        "K ∼ p, and a steep rise to full contact.",
        EXACT,
        (
            Criterion(
                "exact exponent at the lowest pressures {rule}",
                stiffness_exponent(_FEW_CONTACTS),
                near(_FEW_CONTACTS, 0.05),
            ),
            Criterion(
                f"{{rule}} of d ln K/d ln p within 1 ± {SLOPE_TOLERANCE:g}",
                fitted("plateau_decades", "decades of slope 1"),
                at_least(1.0, "decade"),
            ),
            Criterion(
                "slope above it {rule}",
                fitted("exponent_above", "largest d ln K/d ln p above them"),
                at_least(1.5),
            ),
        ),
        "a spec with bem, at pressures from 1e-7 to 0.1 and a large q1/q0",
    ),
    Claim(
        "rolloff-decades",
        "Sec. 6",
        f"With a roll-off at {ROLLOFF:g} q₀ the region K ∼ p extends over about three decades.",
        EXACT,
        (
            Criterion(
                "width of the range on which the exact K/p stays within "
                f"±{STIFFNESS_TOLERANCE * 100:g} % of one value: {{rule}}",
                fitted("log_decades", "decades of K ∼ p", has_the_rolloff),
                near(3.0, 0.5, "decade"),
            ),
        ),
        f"a spec with bem and qr = {ROLLOFF:g} q0",
    ),
    Claim(
        "finite-size-exponent",
        "eq. (10)",
        "At the lowest pressures, in a finite system, K ∼ p^(1/(1+H)).",
        EXACT,
        (
            Criterion(
                "exact exponent: {rule}",
                stiffness_exponent(_FEW_CONTACTS),
                near(_FEW_CONTACTS, 0.05),
            ),
        ),
        _FEW,
    ),
    Claim(
        "finite-size-prefactor",
        "eq. (10)",
        "There K h_rms/E* ≈ (h_rms/(L²q_r))^(H/(1+H)) (p/E*)^(1/(1+H)): the prefactor θ is "
        "about one.",
        EXACT,
        (
            Criterion(
                "exact θ, with the rms height of the realized surfaces: {rule}",
                fitted("theta_realized", "θ"),
                about(1.0, FOLLOWS),
            ),
        ),
        _FEW,
    ),
    Claim(
        "finite-size-foundation",
        "Sec. 5, Fig. 4(b)",
        "The foundation has K ∼ p^(1/(1+H)) at the lowest pressures too.",
        ("foundation",),
        (
            Criterion(
                "exponent of the foundation: {rule}",
                stiffness_exponent(_FEW_CONTACTS),
                near(_FEW_CONTACTS, 0.05),
            ),
        ),
        "a spec with bem and foundation, at pressures from 1e-8",
    ),
    Claim(
        "stiffness-foundation-linear",
        "Sec. 5, Fig. 4(b)",
        "The foundation has no region K ∼ p.",
        ("foundation",),
        (
            Criterion(
                _PLATEAU.format("foundation"),
                fitted("plateau_decades", "decades of slope 1"),
                at_most(1.0, "decade"),
            ),
        ),
    ),
    Claim(
        "stiffness-foundation",
        "Sec. 3, Fig. 4",
        "The one-dimensional foundation is far off in the stiffness.",
        ("foundation",),
        (Criterion(_FACTORS["stiffness"], factor("stiffness"), TO_BE_FAR_OFF),),
    ),
    Claim(
        "stiffness-persson",
        "Sec. 5, Fig. 4(a)",
        "Persson's theory describes the stiffness.",
        ("persson",),
        (Criterion(_FACTORS["stiffness"], factor("stiffness", is_as_published), TO_FOLLOW),),
    ),
    *(
        Claim(
            f"coupling-{quantity}",
            "abstract of the preprint",
            "The foundation fails because it neglects the long-range elastic coupling: "
            f"springs without coupling are off in {noun} on the surface itself as well.",
            ("winkler",),
            (
                Criterion(
                    f"Winkler’s independent springs, under the surface: {_FACTORS[quantity]}",
                    factor(quantity),
                    TO_BE_FAR_OFF,
                ),
            ),
        )
        for quantity, noun in _NOUNS.items()
    ),
    *(
        Claim(
            f"dimension-{quantity}",
            "Secs. 5, 6",
            "The reduced dimension is not the problem: a line with elastic coupling follows "
            f"the surface in {noun}.",
            ("line",),
            (
                Criterion(
                    f"the exact solution of a line: {_FACTORS[quantity]}",
                    factor(quantity),
                    TO_FOLLOW,
                ),
            ),
        )
        for quantity, noun in _NOUNS.items()
    ),
    Claim(
        "below-rolloff",
        "Sec. 5",
        "Whether the spectrum is flat or zero below the roll-off hardly matters.",
        EXACT,
        (
            Criterion(
                "factor between the exact curves of both, each with the rms height of its own "
                "surfaces, where A ∼ p or K ∼ p: {rule}",
                factor_of_cutoff,
                at_most(1.2, of_ratio=True),
            ),
        ),
        "a spec with bem and sweep: {surface.below_qr: [rolloff, cutoff]}",
    ),
    Claim(
        "stress-correlation",
        "Sec. 1",
        "With elastic coupling the stress is correlated as q^−(1+H).",
        EXACT,
        (
            Criterion(
                f"exponent of the exact stress spectrum where {_AT_SMALL_AREA}",
                spectrum_exponent("stress_spectrum", _COUPLED),
                near(_COUPLED, 0.2),
            ),
        ),
        "a spec with bem and observables: [stress_spectrum]",
    ),
    Claim(
        "overlap-correlation",
        "Sec. 1",
        "Without coupling, where the bodies overlap, the contact is correlated as q^−(2+H).",
        ("winkler",),
        (
            Criterion(
                "exponent of the contact spectrum of Winkler’s springs where the exact "
                f"{_AT_SMALL_AREA}",
                spectrum_exponent("contact_spectrum", _OVERLAP),
                near(_OVERLAP, 0.2),
            ),
        ),
        "a spec with bem and winkler and observables: [contact_spectrum]",
    ),
    Claim(
        "overlap-stress",
        "beyond the paper",
        "The stress of independent springs is correlated as q^−(2+2H).",
        ("winkler",),
        (
            Criterion(
                "exponent of the stress spectrum of Winkler’s springs where the exact "
                f"{_AT_SMALL_AREA}",
                spectrum_exponent("stress_spectrum", _SPRINGS),
                near(_SPRINGS, 0.2),
            ),
        ),
        "a spec with bem and winkler and observables: [stress_spectrum]",
    ),
    Claim(
        "size-exact",
        "beyond the paper",
        "The exact ū(p) of a given spectrum does not depend on the size of the cell.",
        EXACT,
        (Criterion(_SAME_SEPARATION, power_of_size, near(0.0, 0.2)),),
        "a spec with bem and a sweep over surface.length",
    ),
    Claim(
        "size-foundation",
        "beyond the paper",
        "The foundation's pressure scale goes with the size of the cell as 1/L.",
        ("foundation",),
        (Criterion(_SAME_SEPARATION, power_of_size, near(-1.0, 0.2)),),
        "a spec with bem, foundation and a sweep over surface.length",
    ),
    Claim(
        "asperities",
        "Sec. 1",
        "Models of independent summits fail for the contact area.",
        ("gw", "gw_elliptic"),
        (Criterion(_FACTORS["area"], factor("area"), TO_BE_FAR_OFF),),
    ),
)
"""In the order of the paper's quantities: area, separation, stiffness, the reasons."""
