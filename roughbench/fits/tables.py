"""The fits of one experiment as tables: the same rows for the terminal and for the report."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from roughbench.fits.comparisons import (
    PERCENTS,
    PRESSURE_FACTOR,
    Comparison,
    comparisons,
)
from roughbench.fits.resampling import MISSING, Estimate
from roughbench.notation import plain
from roughbench.quantities import QUANTITIES
from roughbench.units import prefix


@dataclass(frozen=True, slots=True)
class Table:
    """Numbers by model.

    Attributes
    ----------
    title : str
        What they are about; may be empty.
    headings : tuple of str
        Of the columns.
    rows : mapping of str to tuple of Estimate
        By label of the model.
    """

    title: str
    headings: tuple[str, ...]
    rows: Mapping[str, tuple[Estimate, ...]]


_PRESSURES = ("from p/E*", "to p/E*", "from", "to")
"""Headings of columns with pressures p/E*."""


def with_pressures(tables: Sequence[Table], modulus: float | None) -> tuple[list[Table], str]:
    """Return tables with their pressures in Pa, prefixed, and what these are called.

    Parameters
    ----------
    tables : sequence of Table
        Of :func:`law_tables` and :func:`departure_tables`, with p/E*.
    modulus : float or None
        E*, Pa; None, without units, leaves everything as it is.

    Returns
    -------
    (list of Table, str)
        One prefix for all of them; "p [kPa]" or "p/E*".
    """
    if modulus is None:
        return list(tables), "p/E*"
    found = [
        row[k].value * modulus
        for table in tables
        for k, heading in enumerate(table.headings)
        if heading in _PRESSURES
        for row in table.rows.values()
    ]
    factor, unit = prefix(found, "Pa")
    name = f"p [{unit}]"
    return [_scaled(table, factor * modulus, name) for table in tables], name


def _scaled(table: Table, factor: float, name: str) -> Table:
    are_pressures = [heading in _PRESSURES for heading in table.headings]
    headings = tuple(
        heading.replace("p/E*", name) if is_pressure else heading
        for heading, is_pressure in zip(table.headings, are_pressures, strict=True)
    )
    rows = {
        label: tuple(
            one.times(factor) if is_pressure else one
            for one, is_pressure in zip(row, are_pressures, strict=True)
        )
        for label, row in table.rows.items()
    }
    return Table(table.title, headings, rows)


def law_tables(models: Mapping[str, Mapping[str, Estimate]]) -> Iterator[Table]:
    """Yield κ, the region K ~ p, the stiffness of few contacts, and factors from the reference.

    Parameters
    ----------
    models : mapping of str to mapping of str to Estimate
        By label and name, as :func:`roughbench.fits.fit` returns them for an experiment.
    """
    yield _table(
        "",
        {"A = κ p/(E*ξ): κ": "kappa", "from p/E*": "kappa_from", "to p/E*": "kappa_to"},
        models,
    )
    yield _table(
        "",
        {
            "K ~ p: decades": "log_decades",
            "drift over 1 decade": "drift_1",
            "over 2": "drift_2",
            "over 3": "drift_3",
            "from p/E*": "log_from",
            "to p/E*": "log_to",
            "α = u0/h_rms": "alpha",
            "β = p0/E*": "beta",
        },
        models,
    )
    if any(math.isfinite(names["exponent"].value) for names in models.values()):
        found = [n["exponent_expected"] for n in models.values() if "exponent_expected" in n]
        expected = [estimate.value for estimate in found if estimate.is_given]
        law = f" (1/(1+H) = {expected[0]:.3f})" if expected else ""
        yield _table(
            f"few contacts, K ~ p^n{law}",
            {
                "n": "exponent",
                "θ of eq. (10)": "theta",
                "θ, own h_rms": "theta_realized",
            },
            models,
        )
    columns = {
        f"in {_heading(one, in_heights=True)}": one.factor
        for one in comparisons()
        if one.is_expected or any(one.factor in names for names in models.values())
    }
    columns["in p at equal ū/h_rms"] = PRESSURE_FACTOR
    others = {
        label: names
        for label, names in models.items()
        if any(name in names for name in columns.values())
    }
    if others:
        yield _table(
            "factor from the reference, where that has A ~ p or K ~ p; own h_rms",
            columns,
            others,
        )


def departure_tables(
    models: Mapping[str, Mapping[str, Estimate]], others: Sequence[str]
) -> Iterator[Table]:
    """Yield between which pressures the models agree with their reference.

    Parameters
    ----------
    models : mapping of str to mapping of str to Estimate
    others : sequence of str
        Labels of the models that are compared with the reference.

    Yields
    ------
    Table
        One for each quantity and percentage, with a lower and an upper end.
    """
    for percent in PERCENTS:
        for comparison in comparisons():
            start, end = comparison.ends(percent)
            known = {label: models[label] for label in others if start in models[label]}
            if known:
                title = _heading(comparison, in_heights=comparison.at_separation)
                title += f" within {percent} %"
                yield _table(title, {"from": start, "to": end}, known)


def _heading(comparison: Comparison, *, in_heights: bool) -> str:
    quantity = QUANTITIES[comparison.quantity]
    symbol = plain(quantity.in_heights if in_heights else quantity.symbol)
    return f"{symbol} at equal ū/h_rms" if comparison.at_separation else symbol


def _table(
    title: str, columns: Mapping[str, str], models: Mapping[str, Mapping[str, Estimate]]
) -> Table:
    rows = {
        label: tuple(names.get(name, MISSING) for name in columns.values())
        for label, names in models.items()
    }
    return Table(title, tuple(columns), rows)
