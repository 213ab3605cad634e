"""The contenders, one file each; a model from outside is one file elsewhere.

Which there are says :mod:`roughbench.models.registry`.
"""

from __future__ import annotations

from roughbench.models.registry import BUILT_IN, MODELS

__all__ = ["BUILT_IN", "MODELS"]
