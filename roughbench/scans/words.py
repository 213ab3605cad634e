"""Numbers as the messages of this folder write them."""

from __future__ import annotations


def per_cent(share: float) -> str:
    """Return a share in percent.

    Examples
    --------
    >>> per_cent(0.0512), per_cent(0.00001)
    ('5.12 %', '0.001 %')
    """
    return f"{100.0 * share:.3g} %"
