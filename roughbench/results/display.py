"""Results as a short text, and as a table in a notebook."""

from __future__ import annotations

import html
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from roughbench.errors import UnknownNameError
from roughbench.quantities import compared
from roughbench.spec.tree import did_you_mean
from roughbench.units import in_words

if TYPE_CHECKING:
    from roughbench.results.model_result import ModelResult
    from roughbench.results.results import Results

MOST_LINES = 6
"""Experiments of a short text, and pressures or models of a small table."""


def unknown_name(
    kind: str, name: object, known: Sequence[str], shown: Sequence[str] | None = None
) -> UnknownNameError:
    """Return the error for a name that is not there, with the one that was probably meant."""
    hint = did_you_mean(str(name), known)
    if not hint.startswith(" (did"):
        hint = did_you_mean("", shown or known)
    return UnknownNameError(f"no {kind} is named {name!r}{hint}")


def model_text(result: ModelResult) -> str:
    """Return the results of a model in a few lines."""
    names = f"variables: {', '.join(result.primary())}"
    shown = textwrap.wrap(names, 88, max_lines=3, placeholder=" …")
    return "\n".join([_model_head(result), *(f"  {line}" for line in shown)])


def model_table(result: ModelResult) -> str:
    """Return the means of a model at some of its pressures, as HTML."""
    shown = [name for name in compared() if f"{name}_mean" in result]
    pressure = np.asarray(result["pressure"], float)
    chosen = np.linspace(0, pressure.size - 1, min(MOST_LINES, pressure.size))
    per_pascal, unit = result.prefixed("pressure")
    scales = {name: result.prefixed(name, f"{name}_mean") for name in shown}
    rows = [
        [
            f"{pressure[k] * per_pascal:.3g}",
            *(_mean(result, name, int(k), scales[name][0]) for name in shown),
        ]
        for k in chosen.round().astype(int)
    ]
    words = [f"{result.long_name(name)}, {scales[name][1]}" for name in shown]
    first = f"p, {unit}" if result.has_units else "p/E*"
    headings = [first, *(text.removesuffix(", 1") for text in words)]
    left_out = pressure.size - len(rows)
    note = f"{left_out} more pressures" if left_out else ""
    return _html(_model_head(result), headings, rows, note)


def results_text(results: Results) -> str:
    """Return the experiments and models of a run in a few lines."""
    lines = [_results_head(results)]
    for name, models in list(results.experiments.items())[:MOST_LINES]:
        labels = (f"{label} ({one.n_realizations})" for label, one in models.items())
        words = f"{name}: {', '.join(labels)}"
        lines.append(textwrap.shorten(words, 96, placeholder=" …"))
    if len(results) > MOST_LINES:
        lines.append(f"… {len(results) - MOST_LINES} more")
    return "\n  ".join(lines)


def results_table(results: Results) -> str:
    """Return the models of a run, and how many of their states converged, as HTML."""
    rows = [
        [
            experiment,
            one.label,
            one.title,
            str(one.n_realizations),
            _extent(one),
            f"{one.n_states - one.n_unconverged} of {one.n_states}",
        ]
        for experiment, one in results.models()
    ]
    most = 2 * MOST_LINES
    headings = ["experiment", "label", "model", "realizations", "pressures", "converged"]
    note = f"{len(rows) - most} more models" if len(rows) > most else ""
    return _html(_results_head(results), headings, rows[:most], note)


def _model_head(result: ModelResult) -> str:
    many = f"{result.n_realizations} realization{'s' * (result.n_realizations != 1)}"
    return f"ModelResult {result.label!r}: {result.title}, {many}, {_extent(result)}"


def _results_head(results: Results) -> str:
    many = f"{len(results)} experiment{'s' * (len(results) != 1)}"
    return f"Results {results.name!r}: {many}, label (realizations)"


def _extent(result: ModelResult) -> str:
    """Return how many pressures there are, and between which."""
    pressure = np.asarray(result.variables["pressure"], float)
    if pressure.size == 0:
        return "no pressures"
    low, high = (
        in_words(p, "Pa") if result.has_units else f"{p:.3g}"
        for p in (pressure.min(), pressure.max())
    )
    symbol = "p" if result.has_units else "p/E*"
    if pressure.size == 1:
        return f"1 pressure, {symbol} = {low}"
    return f"{pressure.size} pressures, {symbol} = {low} … {high}"


def _mean(result: ModelResult, name: str, k: int, factor: float) -> str:
    mean, error = (float(result[f"{name}_{kind}"][k]) * factor for kind in ("mean", "sem"))
    return f"{mean:.4g} ± {error:.2g}" if np.isfinite(error) else f"{mean:.4g}"


def _html(
    caption: str, headings: Sequence[str], rows: Sequence[Sequence[str]], note: str
) -> str:
    """Return a small table as HTML, for notebooks."""

    def cells(texts: Sequence[str], tag: str) -> str:
        inner = "".join(f"<{tag}>{html.escape(text)}</{tag}>" for text in texts)
        return f"<tr>{inner}</tr>"

    body = "".join(cells(row, "td") for row in rows)
    return (
        f"<table><caption>{html.escape(caption)}</caption>"
        f"<thead>{cells(headings, 'th')}</thead><tbody>{body}</tbody></table>"
        + (f"<p>{html.escape(note)}</p>" if note else "")
    )
