"""All that belongs to results in one archive, for the supplement of an article.

The results file, its spec, the heights and models that the spec names, figures and report, by
which versions it was computed, a requirements file that pins them, and how to compute it again.
"""

from __future__ import annotations

from roughbench.bundle.archive import BUNDLE
from roughbench.bundle.content import make_bundle
from roughbench.bundle.environment import pinned, requirements

__all__ = ["BUNDLE", "make_bundle", "pinned", "requirements"]
