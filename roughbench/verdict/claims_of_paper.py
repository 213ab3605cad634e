"""The claims of Lyashenko, Pastewka and Persson (2013), and how each is decided."""

from __future__ import annotations

from roughbench.fits.laws import AREA_TOLERANCE
from roughbench.verdict.between import (
    earlier_start,
    factor_of_cutoff,
    finite_size_power,
    kappa_over_rolloff,
    widening,
)
from roughbench.verdict.criteria import (
    AT_SMALL_AREA,
    BEM,
    COUPLED,
    FACTORS,
    FAR_OFF,
    FEW,
    FEW_CONTACTS,
    FEW_OF_EACH,
    FOLLOWS,
    NEAR_ONE_PERCENT,
    NOT_TO_DRIFT,
    OVERLAP,
    PRESSURES,
    TO_BE_FAR_OFF,
    TO_FOLLOW,
    TWO_LOADS,
    drift,
)
from roughbench.verdict.experiments import EXACT
from roughbench.verdict.fields import change_with_load, spectrum_exponent
from roughbench.verdict.judging import Claim, Criterion
from roughbench.verdict.measures import (
    MANY_SCALES,
    ROLLOFF,
    SYMBOLS,
    closing_ratio,
    factor,
    fitted,
    has_the_papers_size,
    has_the_rolloff,
    is_as_published,
    kappa,
    pressure_factor,
    stiffness_exponent,
)
from roughbench.verdict.rules import about, at_least, at_most, near
from roughbench.verdict.states import (
    STIFF,
    area_before_stiffness,
    divergence,
    energy_drift,
    energy_height,
    energy_over_u0,
    exponent_below,
    fluctuations,
    same_range,
    start_of_deviation,
)
from roughbench.verdict.theories import theory_fitted

_MANY_SCALES = f"for q₁ ≥ {MANY_SCALES:g} q_r"
_CHANGES = "factor by which K/p changes over 3 decades, where it changes least: {rule}"
_OVER_THREE = ("drift_3", "drift of K/p over 3 decades")
_OTHER_CUTOFF = "q₁ is not the paper's 8192 q₀"
_PAPERS_SIZE = (
    "configs/paper/bem.yaml, with surface.qr = 8 q0 and q1 = 8192 q0, but pressures from 1e-6 "
    "to 1e-2 and 2 or more realizations"
)
_OF_EXACT = Criterion(
    _CHANGES,
    fitted(
        *_OVER_THREE,
        has_the_papers_size,
        among=has_the_rolloff,
        except_of=_OTHER_CUTOFF,
        remedy=_PAPERS_SIZE,
    ),
    NOT_TO_DRIFT,
)
_OF_THEORY = Criterion(
    _CHANGES,
    theory_fitted(
        *_OVER_THREE,
        except_of=_OTHER_CUTOFF,
        remedy="configs/paper/fig4.yaml: surface.qr = 8 q0 and q1 = 8192 q0",
    ),
    NOT_TO_DRIFT,
)

_AREA = (
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
        BEM,
    ),
    Claim(
        "kappa",
        "eq. (3)",
        "The factor is κ ≈ 2.",
        EXACT,
        (Criterion(f"exact κ: {{rule}}, {_MANY_SCALES}", kappa, near(2.0, 0.2)),),
        BEM,
    ),
    Claim(
        "distribution-pressure",
        "Sec. 2",
        "The local pressures are distributed in the same way over a wide range of loads.",
        EXACT,
        (
            Criterion(
                "largest difference of their cumulative distributions at two loads with A ∼ p: "
                "{rule}",
                change_with_load("pressure_pdf"),
                at_most(0.1),
            ),
        ),
        f"a spec with bem and observables: [pressure_pdf], {TWO_LOADS}",
    ),
    Claim(
        "distribution-patches",
        "Sec. 2",
        "The sizes of the contact patches are distributed in the same way over a wide range of "
        "loads.",
        EXACT,
        (
            Criterion(
                "largest difference of their cumulative distributions at two loads with A ∼ p: "
                "{rule}",
                change_with_load("clusters"),
                at_most(0.1),
            ),
        ),
        f"a spec with bem and observables: [clusters], {TWO_LOADS}",
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
        (Criterion(FACTORS["area"], factor("area", is_as_published), TO_FOLLOW),),
    ),
    Claim(
        "area-foundation",
        "abstract of the preprint, Fig. 3(a)",
        "The one-dimensional foundation is far off in the contact area.",
        ("foundation",),
        (Criterion(FACTORS["area"], factor("area"), TO_BE_FAR_OFF),),
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
        "asperities",
        "Sec. 1",
        "Models of independent asperities give a wrong relation of force and contact area.",
        ("gw", "gw_elliptic"),
        (Criterion(FACTORS["area"], factor("area"), TO_BE_FAR_OFF),),
    ),
)

_SEPARATION = (
    Claim(
        "energy-linear",
        "eq. (1)",
        "The elastic energy is proportional to the pressure, U = u₀p, with the u₀ of the mean "
        "separation.",
        EXACT,
        (
            Criterion(
                "factor by which U/p changes over 2 decades, where it changes least: {rule}",
                energy_drift,
                NOT_TO_DRIFT,
            ),
            Criterion(
                "U/p over the u₀ of ū = u₀ ln(p₀/p), both where K ∼ p: {rule}",
                energy_over_u0,
                about(1.0, 1.2),
            ),
        ),
        BEM,
    ),
    Claim(
        "energy-height",
        "eq. (1)",
        "U/p, the energy over the pressure, is of the order of h_rms.",
        EXACT,
        (
            Criterion(
                "U/(p h_rms) where K ∼ p, with the rms height of the realized surfaces: {rule}",
                energy_height,
                about(1.0, 3.0),
            ),
        ),
        BEM,
    ),
    Claim(
        "separation-logarithmic",
        "eqs. (2), (9)",
        "Over a large range the mean separation falls with the logarithm of the pressure, ū = "
        "u₀ ln(p₀/p), so that the stiffness is proportional to it, K = p/u₀.",
        EXACT,
        (drift(2, "the exact solution"),),
        BEM,
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
                about(1.0, 3.0),
            ),
        ),
        BEM,
    ),
    Claim(
        "same-range",
        "Sec. 2, eq. (3)",
        "A ∼ p in the pressure range in which ū ∼ ln p.",
        EXACT,
        (
            Criterion(
                "part of the region K ∼ p (±20 %), in ln p, in which A ∼ p (±10 %): {rule}",
                same_range,
                at_least(0.8),
            ),
        ),
        BEM,
    ),
    Claim(
        "many-contacts",
        "Sec. 2",
        "A ∼ p and ū ∼ ln p hold only where many asperities touch: they begin together.",
        EXACT,
        (
            Criterion(
                "pressure from which on A ∼ p (±10 %), over that from which on K ∼ p (±20 %): "
                "{rule}",
                area_before_stiffness,
                about(1.0, FAR_OFF),
            ),
        ),
        "a spec with bem, at pressures from 1e-7 to 0.1",
    ),
    Claim(
        "fluctuations",
        "Secs. 2, 4",
        "At very low pressures, where few asperities touch, the stiffness fluctuates much from "
        "one surface to another.",
        EXACT,
        (
            Criterion(
                "relative scatter of the exact K between surfaces at the lowest pressure, over "
                "that in the middle of K ∼ p: {rule}",
                fluctuations,
                at_least(FAR_OFF, of_ratio=True),
            ),
        ),
        "a spec with bem, at pressures from 1e-7, and at least 3 realizations",
    ),
    Claim(
        "separation-persson",
        "Fig. 3(b)",
        "Persson's theory describes the mean separation.",
        ("persson",),
        (
            Criterion(FACTORS["separation"], factor("separation", is_as_published), TO_FOLLOW),
            Criterion(PRESSURES, pressure_factor(is_as_published), TO_FOLLOW),
        ),
    ),
    Claim(
        "separation-foundation",
        "abstract of the preprint, Fig. 3(b)",
        "The one-dimensional foundation is far off in the mean separation.",
        ("foundation",),
        (Criterion(PRESSURES, pressure_factor(), TO_BE_FAR_OFF),),
    ),
)

_STIFFNESS = (
    Claim(
        "three-regions",
        "Sec. 5, Fig. 4(a)",
        "The stiffness has three regions: K ∼ p^(1/(1+H)) where a few contacts carry all, "
        "K ∼ p, and a steep rise to full contact.",
        EXACT,
        (
            Criterion(
                "exact exponent at the lowest pressures {rule}",
                stiffness_exponent(FEW_CONTACTS),
                near(FEW_CONTACTS, 0.05),
            ),
            drift(1, "the exact solution"),
            Criterion(
                "slope above it {rule}",
                fitted("exponent_above", "largest d ln K/d ln p above them"),
                at_least(1.5),
            ),
        ),
        "a spec with bem, at pressures from 1e-7 to 0.1, and surface.q1 of at least 512 times "
        "surface.q0",
    ),
    Claim(
        "rolloff-decades",
        "Sec. 6",
        f"With a roll-off at {ROLLOFF:g} q₀ the exact solution has K ∼ p over 3 decades.",
        EXACT,
        (_OF_EXACT,),
        _PAPERS_SIZE,
    ),
    Claim(
        "theory-decades",
        "Sec. 6",
        f"With a roll-off at {ROLLOFF:g} q₀ Persson's theory has K ∼ p over 3 decades.",
        ("persson",),
        (_OF_THEORY,),
        "configs/paper/fig4.yaml: persson with surface.qr = 8 q0 and q1 = 8192 q0",
    ),
    Claim(
        "rolloff-widens",
        "Sec. 5",
        "With a roll-off the linear region of the stiffness is wider, and starts at lower "
        "pressures.",
        EXACT,
        (
            Criterion(
                "decades of K ∼ p (±20 %) with the roll-off less those without: {rule}",
                widening,
                at_least(0.0, "decade"),
            ),
            Criterion(
                "pressure where it starts, over that without: {rule}",
                earlier_start,
                at_most(1.0, of_ratio=True),
            ),
        ),
        "a spec with bem and sweep: {surface.qr: [1.0, 8.0]}",
    ),
    Claim(
        "finite-size-exponent",
        "eq. (10)",
        "At the lowest pressures, in a finite system, K ∼ p^(1/(1+H)).",
        EXACT,
        (
            Criterion(
                "exact exponent: {rule}",
                stiffness_exponent(FEW_CONTACTS),
                near(FEW_CONTACTS, 0.05),
            ),
        ),
        FEW,
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
        FEW,
    ),
    *(
        Claim(
            f"finite-size-{key}",
            "eq. (10)",
            f"The stiffness of few contacts depends on {words} as eq. (10) says.",
            EXACT,
            (
                Criterion(
                    f"power of {symbol} that is left in the exact prefactor θ: {{rule}}",
                    finite_size_power(name, symbol),
                    near(0.0, 0.1),
                ),
            ),
            f"{FEW_OF_EACH if key == 'rolloff' else FEW}, and a sweep over {swept}",
        )
        for key, words, symbol, name, swept in (
            ("length", "the size of the cell", "L", "length", "surface.length"),
            ("rolloff", "the roll-off", "q_r", "q_rolloff", "surface.qr"),
            ("height", "the rms height", "h_rms", "rms_slope", "surface.slope"),
        )
    ),
    Claim(
        "finite-size-foundation",
        "Sec. 5, Fig. 4(b)",
        "The stiffness of the foundation has K ∼ p^(1/(1+H)) at the lowest pressures too.",
        ("foundation",),
        (
            Criterion(
                "exponent of the foundation: {rule}",
                stiffness_exponent(FEW_CONTACTS),
                near(FEW_CONTACTS, 0.05),
            ),
        ),
        "a spec with foundation, at pressures from 1e-8 and surface.q1 of at least 512 times "
        "surface.qr: configs/paper/fig4.yaml",
    ),
    Claim(
        "uncoupled-exponent",
        "Sec. 5",
        "K ∼ p^(1/(1+H)) holds without coupling between contacts as well: that of the highest "
        "asperity alone.",
        ("hertz_top",),
        (
            Criterion(
                "exponent of K of the highest asperity, below the exact K ∼ p: {rule}",
                exponent_below(FEW_CONTACTS),
                near(FEW_CONTACTS, 0.05),
            ),
        ),
        "a spec with bem and hertz_top, at pressures from 1e-7",
    ),
    Claim(
        "stiffness-foundation-linear",
        "Secs. 5, 6, Fig. 4(b)",
        "The foundation has no region K ∼ p.",
        ("foundation",),
        (
            Criterion(
                "factor by which K/p of the foundation changes over 1 decade, where it changes "
                "least: {rule}",
                fitted("drift_1", "drift of K/p over 1 decade"),
                at_least(NOT_TO_DRIFT.inside[1], of_ratio=True),
            ),
        ),
    ),
    Claim(
        "onset-foundation",
        "Sec. 5, Fig. 4(b)",
        "The stiffness of the foundation starts to deviate from the theory where the linear "
        "region of the theory starts.",
        ("foundation",),
        (
            Criterion(
                "pressure of the first deviation by a factor 1.2, with the foundation's own θ "
                "in eq. (10), over the start of the linear region: {rule}",
                start_of_deviation,
                about(1.0, FAR_OFF),
            ),
        ),
        "a spec with foundation, at pressures from 1e-8: configs/paper/fig4.yaml",
    ),
    Claim(
        "divergence-foundation",
        "Sec. 3",
        "The stiffness of the foundation goes to infinity at much lower pressure.",
        ("foundation",),
        (
            Criterion(
                f"pressure at which K h_rms/E* reaches {STIFF:g}, exact over foundation: "
                "{rule}",
                divergence,
                at_least(FAR_OFF, of_ratio=True),
            ),
        ),
        "a spec with bem and foundation, at pressures up to 0.2",
    ),
    Claim(
        "stiffness-foundation",
        "Sec. 3, Fig. 4",
        "The one-dimensional foundation is far off in the stiffness.",
        ("foundation",),
        (Criterion(FACTORS["stiffness"], factor("stiffness"), TO_BE_FAR_OFF),),
    ),
    Claim(
        "stiffness-persson",
        "Sec. 5, Fig. 4(a)",
        "Persson's theory describes the stiffness.",
        ("persson",),
        (Criterion(FACTORS["stiffness"], factor("stiffness", is_as_published), TO_FOLLOW),),
    ),
    Claim(
        "below-rolloff",
        "Sec. 5",
        "Whether the spectrum is flat or zero below the roll-off hardly matters.",
        EXACT,
        tuple(
            Criterion(
                f"factor in {symbol} between the exact curves of both, each with the rms "
                f"height of its own surfaces, where {law}: {{rule}}",
                factor_of_cutoff(quantity),
                at_most(1.2, of_ratio=True),
            )
            for quantity, symbol, law in (
                ("area", SYMBOLS["area"], "A ∼ p"),
                ("separation", SYMBOLS["separation"], "K ∼ p"),
                ("stiffness", SYMBOLS["stiffness"], "K ∼ p"),
            )
        ),
        "a spec with bem, surface.qr above q0 and sweep: {surface.below_qr: [rolloff, cutoff]}",
    ),
)

_CORRELATIONS = (
    Claim(
        "stress-correlation",
        "Sec. 1",
        "With elastic coupling the stress is correlated as q^−(1+H).",
        EXACT,
        (
            Criterion(
                f"exponent of the exact stress spectrum where {AT_SMALL_AREA}",
                spectrum_exponent("stress_spectrum", COUPLED),
                near(COUPLED, 0.2),
            ),
        ),
        f"a spec with bem and observables: [stress_spectrum], {NEAR_ONE_PERCENT}",
    ),
    Claim(
        "overlap-correlation",
        "Sec. 1",
        "Without coupling, where the bodies overlap, the islands of contact are correlated as "
        "q^−(2+H): the paper says the stress, meaning one of equal size on all.",
        ("winkler",),
        (
            Criterion(
                "exponent of the contact spectrum of Winkler’s springs where the exact "
                f"{AT_SMALL_AREA}",
                spectrum_exponent("contact_spectrum", OVERLAP),
                near(OVERLAP, 0.2),
            ),
        ),
        f"a spec with bem and winkler and observables: [contact_spectrum], {NEAR_ONE_PERCENT}",
    ),
)

PAPER = (*_AREA, *_SEPARATION, *_STIFFNESS, *_CORRELATIONS)
