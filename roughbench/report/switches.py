"""The switches above the charts, which are their legend too."""

from __future__ import annotations

from collections.abc import Sequence

from roughbench.report.looks import Look, dash_sample, experiment_dashes, model_sample
from roughbench.report.markup import escape, muted, number
from roughbench.report.observables import drawn_pressures, pressure_key
from roughbench.report.sources import Source

MOST_CURVES = 8
"""Curves that a chart shows at first with all experiments; of more, the first experiment."""


def switches(source: Source, looks: dict[str, Look]) -> str:
    """Return the legend, which is also where models and experiments are chosen."""
    titles = {result.label: source.title(result.label) for _, result in source.models()}
    models = "".join(
        _switch("model", label, model_sample(looks[label]), _model_words(label, title))
        for label, title in titles.items()
    )
    parts = [_fieldset("Models", models, len(titles))]
    dashes = experiment_dashes(list(source.results))
    if len(dashes) > 1:
        many = len(list(source.models())) > MOST_CURVES
        experiments = "".join(
            _switch(
                "experiment",
                name,
                dash_sample(dash),
                source.experiment(name),
                on=place == 0 or not many,
            )
            for place, (name, dash) in enumerate(dashes.items())
        )
        parts.append(_fieldset("Sweep", experiments, len(dashes)))
    else:
        parts += [
            f'<input type="checkbox" name="experiment" value="{escape(name)}" checked hidden>'
            for name in dashes
        ]
    pressures = drawn_pressures(source)
    if pressures:
        parts.append(_pressure_select(pressures))
    return f'<form class="switches" autocomplete="off" hidden>{"".join(parts)}</form>'


def _pressure_select(pressures: Sequence[float]) -> str:
    """Return the choice of the pressure at which observables are shown."""
    middle = len(pressures) // 2
    options = "".join(
        f'<option value="{pressure_key(p)}"{" selected" * (k == middle)}>{number(p)}</option>'
        for k, p in enumerate(pressures)
    )
    return (
        "<fieldset><legend>Pressure</legend><label>of what happens inside the contact: p/E* = "
        f'<select name="pressure">{options}</select></label></fieldset>'
    )


def _model_words(label: str, title: str) -> str:
    return f"{escape(title)} {muted(label)}"


def _fieldset(legend: str, switches: str, count: int) -> str:
    everything = '<button type="button" data-do="all">all</button>' if count > 1 else ""
    return f"<fieldset><legend>{legend}</legend>{switches}{everything}</fieldset>"


def _switch(name: str, value: str, sample: str, words: str, *, on: bool = True) -> str:
    checked = " checked" if on else ""
    return (
        f'<span class="switch"><label><input type="checkbox" name="{name}" '
        f'value="{escape(value)}"{checked}>{sample}<span>{words}</span></label>'
        f'<button type="button" data-do="only" aria-label="only {escape(value)}">only</button>'
        "</span>"
    )
