"""Fits as text: tables for people, JSON for programs."""

from __future__ import annotations

import json
import math
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence

from roughbench.fits import Estimate, reference_of
from roughbench.fits.tables import Table, departure_tables, law_tables, with_pressures
from roughbench.numbers import with_interval
from roughbench.results import ModelResult, Results
from roughbench.verdict.trust import ContenderTrust, Trust

Fitted = Mapping[str, Mapping[str, Mapping[str, Estimate]]]
Names = Mapping[str, Estimate]

_WIDTH = 20
_HELD = re.compile(r" (?=[±=%≤]|E\*)|(?<=[±=≤]) |(?<=p =) ")


def as_text(
    results: Results,
    fitted: Fitted,
    source: str,
    reference: str | None,
    trusts: Sequence[ContenderTrust] = (),
) -> str:
    """Return tables of all fits, and where each model can be trusted.

    Parameters
    ----------
    results : Results
    fitted : mapping
        What :func:`roughbench.fits.fit` returned for them.
    source : str
        Name of the file, for the title.
    reference : str or None
        As it was given to it.
    trusts : sequence of ContenderTrust
        Of these experiments.
    """
    heading = (
        f"{source}: {results.name}\n"
        "value ± error: half of the 68 % interval of a bootstrap over the realizations\n"
        "≤ ≥: the range goes on beyond the pressures of the results\n"
        "- : met nowhere; criteria: docs/fits.md"
    )
    blocks = [heading]
    for experiment, models in fitted.items():
        kept = dict(results[experiment])
        blocks.append("\n".join([f"== {experiment} ==", *_laws(models, _modulus(kept))]))
        label = reference_of(kept, reference)
        others = [name for name in models if name != label]
        if label is not None and others:
            blocks.append("\n".join(_departures(kept, models, others, label)))
        own = [one for one in trusts if one.experiment == experiment]
        if own:
            blocks.append("\n".join(_trusted(own)))
    return "\n\n".join(blocks)


def _modulus(results: Mapping[str, ModelResult]) -> float | None:
    """Return E*, Pa, of the models of an experiment; None without units."""
    return next(result.modulus for result in results.values())


def _laws(models: Mapping[str, Names], modulus: float | None) -> Iterator[str]:
    width = max(len(label) for label in models)
    tables, _ = with_pressures([*law_tables(models)], modulus)
    for number, table in enumerate(tables):
        if number:
            yield ""
        if table.title:
            yield table.title
        yield from _lines(width, table.headings, table)


def _departures(
    results: Mapping[str, ModelResult],
    models: Mapping[str, Names],
    others: Sequence[str],
    reference: str,
) -> Iterator[str]:
    tables, pressures = with_pressures([*departure_tables(models, others)], _modulus(results))
    title = results[reference].title
    yield f"{pressures} between which a model agrees with {reference} ({title})"
    width = max(len(label) for label in models)
    for table in tables:
        start, end = table.headings
        yield from _lines(width, (f"{table.title}: {start}", end), table)


def _trusted(trusts: Sequence[ContenderTrust]) -> Iterator[str]:
    yield "where each model can be trusted on these surfaces"
    for one in trusts:
        yield from _wrapped(f"{one.label} ({one.title}): {one.basis}", 0)
        for trust in one.quantities:
            yield from _wrapped(f"{trust.name}: {trust.sentence}", 2)


def _wrapped(text: str, indent: int) -> list[str]:
    """Return lines that keep numbers with their signs, errors and units."""
    start, held = " " * indent, _HELD.sub("\xa0", text)
    lines = textwrap.wrap(held, 96, initial_indent=start, subsequent_indent=f"{start}    ")
    return [line.replace("\xa0", " ") for line in lines]


def _lines(width: int, headings: Sequence[str], table: Table) -> Iterator[str]:
    shown = {label: [_text(number) for number in row] for label, row in table.rows.items()}
    columns = zip(*shown.values(), strict=True)
    widths = [
        max(_WIDTH, len(heading), *map(len, column))
        for heading, column in zip(headings, columns, strict=True)
    ]
    titles = (f"  {heading:<{w}}" for heading, w in zip(headings, widths, strict=True))
    yield f"{'':{width}}{''.join(titles)}".rstrip()
    for label, row in shown.items():
        texts = (f"  {text:<{w}}" for text, w in zip(row, widths, strict=True))
        yield f"{label:{width}}{''.join(texts)}".rstrip()


def _text(number: Estimate) -> str:
    if not number.is_given:
        return "not given"
    if math.isnan(number.value):
        return "-"
    if math.isinf(number.value):
        return "∞"
    value = f"{number.value:.4g}"
    if number.bound:
        return f"{number.bound} {value}"
    if math.isnan(number.low):
        return value
    return with_interval(number.value, number.low, number.high, 4)


def to_json(
    results: Results,
    fitted: Fitted,
    reference: str | None,
    resamples: int,
    trusts: Sequence[ContenderTrust] = (),
) -> str:
    """Return all fits, and where each model can be trusted, as strict JSON.

    What is not defined is null. Pressures are p/E*; of results with units E*, in Pa, stands
    beside them, and lengths are in m.
    """
    moduli = {name: _modulus(models) for name, models in results.items() if results.has_units}
    content = {
        "name": results.name,
        "spec_sha256": results.spec_sha256,
        **({"contact_modulus": moduli} if moduli else {}),
        "resamples": resamples,
        "references": {
            name: reference_of(dict(models), reference) for name, models in results.items()
        },
        "experiments": {
            experiment: {
                label: {
                    name: _as_json(value) for name, value in names.items() if value.is_given
                }
                for label, names in models.items()
            }
            for experiment, models in fitted.items()
        },
        "trust": {
            experiment: {
                one.label: {
                    "basis": one.basis,
                    "quantities": {t.quantity.name: _trust_as_json(t) for t in one.quantities},
                }
                for one in trusts
                if one.experiment == experiment
            }
            for experiment in fitted
        },
    }
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)


def _as_json(estimate: Estimate) -> dict[str, object]:
    numbers = {
        name: value if math.isfinite(value := getattr(estimate, name)) else None
        for name in ("value", "error", "low", "high", "share")
    }
    return numbers | {"is_bound": estimate.is_bound}


def _trust_as_json(trust: Trust) -> dict[str, object]:
    """Return range, deviations and the sentence; what is not compared has the last alone."""
    if trust.found is None:
        return {"sentence": trust.sentence}
    return {
        "sentence": trust.sentence,
        "percent": trust.found.percent,
        "from": _as_json(trust.found.start),
        "to": _as_json(trust.found.end),
        "deviations": [
            {"pressure": one.pressure, **_as_json(one.estimate)} for one in trust.deviations
        ],
    }
