"""How every part of a spec is validated."""

from __future__ import annotations

from pydantic import ConfigDict

STRICT = ConfigDict(frozen=True, strict=True, extra="forbid", allow_inf_nan=False)
