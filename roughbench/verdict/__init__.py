"""What results say of each claim of the paper: a number, its error, and a verdict.

>>> import roughbench as rb
>>> from roughbench.verdict import judge
>>> results = rb.run(
...     {
...         "surface": {"H": 0.7, "q0": 1.0, "qr": 8.0, "q1": 64.0, "slope": 0.1},
...         "pressures": {"min": 1e-5, "max": 0.1, "points": 17},
...         "realizations": 10,
...         "models": [
...             {"kind": "persson"},
...             {"kind": "persson", "label": "full", "gamma": 1.0},
...         ],
...     }
... )
>>> verdicts = {v.key: v for v in judge([("example", results)], reference="persson")}
>>> found = verdicts["area-linear"]
>>> found.place, found.claim[:56]
('eq. (9)', 'The real contact area is proportional to the pressure, A')
>>> found.measurements[0].what, str(found.outcome)
('decades of A ∼ p', 'holds')
>>> str(verdicts["coupling-area"].outcome), verdicts["coupling-area"].remedy
('not tested', 'a spec with bem and winkler')
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from roughbench.fits import RESAMPLES
from roughbench.verdict.cases import Case, Source, cases_of
from roughbench.verdict.claims import ANOTHER, CLAIMS, FOLLOWS, Measurement
from roughbench.verdict.rules import Outcome

__all__ = [
    "ANOTHER",
    "FOLLOWS",
    "Case",
    "Measurement",
    "Outcome",
    "Verdict",
    "cases_of",
    "judge",
    "judge_cases",
]


@dataclass(frozen=True, slots=True)
class Verdict:
    """A claim, what was measured of it, and what follows.

    Attributes
    ----------
    key : str
        Short name.
    place : str
        Where the paper says it.
    claim : str
        What it says.
    rule : str
        How it is decided.
    measurements : tuple of Measurement
    outcome : Outcome
        Over all measurements: fails if one fails, holds if all that were taken hold.
    remedy : str
        What spec would test it, or what of it is missing; empty where it is decided.
    """

    key: str
    place: str
    claim: str
    rule: str
    measurements: tuple[Measurement, ...]
    outcome: Outcome
    remedy: str


def judge(
    sources: Sequence[Source],
    *,
    reference: str | None = None,
    resamples: int = RESAMPLES,
) -> list[Verdict]:
    """Hold results against every claim of the paper.

    Parameters
    ----------
    sources : sequence of (str, Results)
        Each with a name, such as that of its file.
    reference : str, optional
        Label of the model that is taken for exact; default: the first ``bem`` of each
        experiment.
    resamples : int
        Of the bootstrap that the errors come from, at least 2.

    Returns
    -------
    list of Verdict
        One a claim, in the paper's order.

    Raises
    ------
    StoreError
        If no results have a model of the label ``reference``.
    ValueError
        If there are fewer than two resamples.
    """
    return judge_cases(cases_of(sources, reference, resamples), resamples)


def judge_cases(cases: Sequence[Case], resamples: int = RESAMPLES) -> list[Verdict]:
    """Hold fitted results against every claim of the paper.

    Parameters
    ----------
    cases : sequence of Case
        As :func:`cases_of` returns them.
    resamples : int
        As it was given to it.

    Returns
    -------
    list of Verdict
        One a claim, in the paper's order.
    """
    verdicts = []
    for claim in CLAIMS:
        found = tuple(claim.measure(cases, resamples))
        outcome = claim.outcome(found)
        remedy = "" if outcome == Outcome.FAILS or not claim.lacks(found) else claim.remedy
        verdicts.append(
            Verdict(claim.key, claim.place, claim.claim, claim.rule, found, outcome, remedy)
        )
    return verdicts
