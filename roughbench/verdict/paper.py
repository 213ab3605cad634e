"""What stands where in Lyashenko, Pastewka and Persson (2013): the one table of its places.

Numbers are those of the preprint, whose text is at hand; the published abstract differs in one
word, see :data:`PASSAGES`. A test holds every citation in the package, its specs and its
documentation against this table: what is said with a citation has to be about what stands
there. Places of other publications are therefore cited without these abbreviations.

>>> passage_of("eq. (3)").about
'contact area in proportion to the pressure, A/A₀ = (κ/ξ) p/E*, with κ ≈ 2'
>>> citations("eqs. (2) and (9), Fig. 4(a) and (b)")
['eq. (2)', 'eq. (9)', 'Fig. 4(a)', 'Fig. 4(b)']
"""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Passage:
    """A place of the paper.

    Attributes
    ----------
    place : str
        As it is cited.
    about : str
        What stands there, in our words.
    words : tuple of str
        Regular expressions, one of which is in whatever is said with this citation.
    """

    place: str
    about: str
    words: tuple[str, ...]

    def concerns(self, text: str) -> bool:
        """Return whether a text is about what stands here.

        Examples
        --------
        >>> passage_of("eq. (9)").concerns("κ of eq. (9)")
        False
        """
        return any(re.search(word, text) for word in self.words)


_AREA = (r"\barea", r"\bA/A", r"\bA ∼ p", "κ", r"\bareas\b")
_SEPARATION = ("separation", "ū", "u₀", "u0", "p0", "p₀")
_STIFFNESS = ("stiffness", r"\bK\b", "slope of ln K")
_COUPLING = ("coupl", "elasticity", "springs do not feel")
_FINITE = ("finite", "θ", r"1/\(1 ?\+ ?H\)", "prefactor", "few contacts", "exponent")
_ALL = (*_AREA, *_SEPARATION, *_STIFFNESS)
_REPETITION = ("roll-off", "repeat", "cut-off")

PASSAGES = (
    Passage(
        "abstract of the preprint",
        "the foundation fails qualitatively in area and separation, which is attributed to the "
        "neglect of the long-range elastic coupling",
        (*_AREA, *_SEPARATION, *_COUPLING),
    ),
    Passage(
        "abstract as published",
        "the same, attributed to the incorrect treatment of the long-range elastic coupling",
        (*_AREA, *_SEPARATION, *_COUPLING, "incorrect treatment"),
    ),
    Passage(
        "Sec. 1",
        "theories of asperities and of springs neglect the coupling, and with it miss the "
        "topography of the contact and the relation of force and area; the stress, by which "
        "the overlap model means the islands of contact, is correlated as q^−(2+H) without "
        "and as q^−(1+H) with coupling",
        (*_COUPLING, "correlat", "asperit", "summit", "overlap"),
    ),
    Passage(
        "Sec. 2",
        "A ∼ p and ū ∼ ln p over a large range of pressures, since patches and local pressures "
        "are distributed alike at all of them; only where many asperities touch, below which "
        "surfaces differ much from each other",
        (*_ALL, "distribut", "fluctuat", "scatter", "energy"),
    ),
    Passage(
        "eq. (1)",
        "elastic energy in proportion to the pressure, U = u₀p, with u₀ of the order of h_rms",
        ("energy", r"\bU\b"),
    ),
    Passage(
        "eq. (2)",
        "pressure and mean separation, p = p₀ exp(−ū/u₀), with u₀ = αh_rms, α of order one, "
        "and p₀ = βE*",
        _SEPARATION,
    ),
    Passage(
        "eq. (3)",
        "contact area in proportion to the pressure, A/A₀ = (κ/ξ) p/E*, with κ ≈ 2",
        _AREA,
    ),
    Passage(
        "Sec. 3",
        "numerical results for area and separation: H = 0.7, ξ = 0.1, q₁ = 8192 q₀, q_r = q₀ "
        "and 8 q₀; 100 lines of 8192 springs; the foundation's area approaches A₀ and its "
        "stiffness infinity at much lower pressures",
        (*_ALL, "springs", "lines"),
    ),
    Passage("eq. (4)", "spectrum of the line, C₁D = πqC₂D", ("spectrum", "C₁D", "C1D", "line")),
    Passage(
        "eq. (5)",
        "force of the foundation, the sum of its springs' of stiffness aE*",
        ("force", "spring"),
    ),
    Passage(
        "eq. (6)",
        "contact area of the foundation, (π/4) Σ(a nᵢ)² over connected regions of a finite row",
        (*_AREA, "region"),
    ),
    Passage("eq. (7)", "nominal area of the foundation, (π/4)(aN)²", ("nominal", "A₀", "A0")),
    Passage(
        "eq. (8)",
        "mean separation of the foundation, over all springs",
        _SEPARATION,
    ),
    Passage(
        "Sec. 4",
        "contact stiffness, for many asperities and for a finite system",
        (*_STIFFNESS, *_FINITE, "fluctuat"),
    ),
    Passage(
        "eq. (9)",
        "stiffness in proportion to the pressure, K h_rms/E* = p/(αE*)",
        _STIFFNESS,
    ),
    Passage(
        "eq. (10)",
        "stiffness of a finite system at the lowest pressures, K h_rms/E* ≈ "
        "(h_rms/(L²q_r))^(H/(1+H)) (p/E*)^(1/(1+H)), without prefactor",
        (*_FINITE, *_STIFFNESS),
    ),
    Passage(
        "Sec. 5",
        "numerical results for the stiffness: three regions of K; the linear one widens with "
        "the roll-off, rests on the coupling and is absent from the foundation, which leaves "
        "the theory where it begins; with q_r above q₀ the surface is as if repeated "
        "(q_r/q₀)² times, and whether its spectrum is flat or empty below hardly matters",
        (*_STIFFNESS, *_COUPLING, *_REPETITION, "line"),
    ),
    Passage(
        "Sec. 6",
        "summary: the foundation fails in area and separation for want of coupling; with "
        "q_r = 8 q₀, at q₁ = 8192 q₀, theory and exact solution have K ∼ p over three decades, "
        "the foundation has none",
        (*_ALL, *_COUPLING, "dimension", "line"),
    ),
    Passage("Fig. 1", "the foundation of independent springs", ("spring", "foundation")),
    Passage("Fig. 2", "the spectrum with a roll-off, schematically", ("spectr", "roll-off")),
    Passage("Fig. 3", "area and separation over the pressure", (*_AREA, *_SEPARATION)),
    Passage("Fig. 3(a)", "area over a linear axis of the pressure", _AREA),
    Passage("Fig. 3(b)", "logarithm of the separation over a linear axis", _SEPARATION),
    Passage("Fig. 4", "stiffness over the pressure, both logarithmic", _STIFFNESS),
    Passage("Fig. 4(a)", "stiffness of the theory", (*_STIFFNESS, "theory", "dashed lines")),
    Passage(
        "Fig. 4(b)",
        "stiffness of the foundation; dashed lines, in both panels, where it starts to deviate "
        "from the theory",
        (*_STIFFNESS, "foundation", "dashed lines"),
    ),
)
"""In the paper's order. The published abstract says "incorrect treatment" where the preprint's
says "neglect"."""

SAID_AT = (
    (r"(?:\b3|[Tt]hree) decades", ("Sec. 6",)),
    ("κ", ("eq. (3)", "Fig. 3(a)")),
    ("θ", ("eq. (10)",)),
    (r"\brepeat", ("Sec. 5",)),
    ("fluctuat", ("Sec. 2", "Sec. 4")),
    ("correlat", ("Sec. 1",)),
    (r"\bneglect", ("abstract of the preprint", "Sec. 1", "Sec. 5")),
    (r"\bincorrect treatment", ("abstract as published",)),
)
"""What is said in a few places only: a regular expression, and the places."""

_PLACES = {passage.place: passage for passage in PASSAGES}
_ONE = r"\(\d+[a-z]?\)"
_PANEL = r"\d+(?:\([a-z]\)|[a-z]\b|(?!\())"
_MORE = r"(?:,| and|, and| or| to|–)"
CITATION = re.compile(
    rf"\b[Ee]qs?\.\s*(?P<eq>{_ONE}(?:{_MORE}\s*{_ONE})*)"
    rf"|\bFigs?\.\s*(?P<fig>{_PANEL}(?:{_MORE}\s*(?:{_PANEL}|\([a-z]\)))*)"
    r"|\bSecs?\.\s*(?P<sec>\d+(?:\.\d+)?(?:(?:,| and)\s*\d+\b)*)"
    r"|\b(?P<abstract>abstract (?:of the preprint|as published))"
)


def passage_of(place: str) -> Passage:
    """Return what stands at a place.

    Raises
    ------
    KeyError
        If the paper has no such place.
    """
    return _PLACES[place]


def citations(text: str) -> list[str]:
    """Return the places of the paper that a text cites, whether or not there are such.

    Examples
    --------
    >>> citations("Figs. 1, 2 and 3(a) and eqs. (5), (6)")
    ['Fig. 1', 'Fig. 2', 'Fig. 3(a)', 'eq. (5)', 'eq. (6)']
    """
    found = []
    for match in CITATION.finditer(text):
        kind = match.lastgroup
        if kind == "eq":
            found += [f"eq. {one}" for one in re.findall(_ONE, match["eq"])]
        elif kind == "fig":
            number = ""
            for digits, panel, more in re.findall(
                r"(\d+)(\([a-z]\)|[a-z]\b)?|(\([a-z]\))", match["fig"]
            ):
                number = digits or number
                found.append(f"Fig. {number}{panel or more}")
        elif kind == "sec":
            found += [f"Sec. {one}" for one in re.findall(r"\d+(?:\.\d+)?", match["sec"])]
        else:
            found.append(match[0])
    return found
