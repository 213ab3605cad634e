"""The claims on results: the paper's, our tests of its explanation, and beyond."""

from __future__ import annotations

from roughbench.verdict.claims_beyond import BEYOND
from roughbench.verdict.claims_of_explanation import EXPLANATION
from roughbench.verdict.claims_of_paper import PAPER

CLAIMS = (*PAPER, *EXPLANATION, *BEYOND)
"""Of each group in the order of the paper's quantities: area, separation, stiffness."""
