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
('eq. (3)', 'The real contact area is proportional to the pressure, A')
>>> found.measurements[0].what, str(found.outcome)
('decades of A ∼ p', 'holds')
>>> str(verdicts["coupling-area"].outcome), verdicts["coupling-area"].remedy
('not tested', 'a spec with bem and winkler')
"""

from __future__ import annotations

from collections.abc import Sequence

from roughbench.fits import RESAMPLES
from roughbench.results import Results
from roughbench.verdict.claims import CLAIMS
from roughbench.verdict.contenders import judge_contenders
from roughbench.verdict.experiments import FittedExperiment, fit_experiments
from roughbench.verdict.judging import Measurement, Range, Verdict
from roughbench.verdict.rules import Outcome
from roughbench.verdict.trust import ContenderTrust, Trust, trust_of

__all__ = [
    "ContenderTrust",
    "FittedExperiment",
    "Measurement",
    "Outcome",
    "Range",
    "Trust",
    "Verdict",
    "fit_experiments",
    "judge",
    "judge_experiments",
    "trust_of",
]


def judge(
    sources: Sequence[tuple[str, Results]],
    *,
    reference: str | None = None,
    resamples: int = RESAMPLES,
) -> list[Verdict]:
    """Hold results against every claim of the paper, and contenders against the exact solution.

    Parameters
    ----------
    sources : sequence of (str, Results)
        Each with a name, such as that of its file.
    reference : str, optional
        Label of the model that is taken for exact; default: the first ``bem`` of each
        experiment without ``screening``.
    resamples : int
        Of the bootstrap that the errors come from, at least 2.

    Returns
    -------
    list of Verdict
        One a claim, in the paper's order; then one for every other model than the exact one,
        whose ``contender`` is its label.

    Raises
    ------
    StoreError
        If no results have a model of the label ``reference``.
    ValueError
        If there are fewer than two resamples.
    """
    return judge_experiments(fit_experiments(sources, reference, resamples), resamples)


def judge_experiments(
    experiments: Sequence[FittedExperiment], resamples: int = RESAMPLES
) -> list[Verdict]:
    """Return the verdicts on experiments that are fitted already, as :func:`judge` does."""
    claims = [claim.judge(experiments, resamples) for claim in CLAIMS]
    return [*claims, *judge_contenders(experiments)]
