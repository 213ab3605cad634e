"""Where two results come from, and in what that differs: why they may be apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from roughbench.results import ModelResult, Results
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.identity import changes

_NOT_ORIGINS = {"host", "cores"}
"""What numbers do not depend on."""


def origins(results: Path) -> dict[str, dict[str, str]]:
    """Return what is known of how each model of a results file was computed.

    Returns
    -------
    dict of str to dict of str to str
        Model, such as ``main/bem`` → versions, processor, threads and code; empty where the
        run directory that it came from does not stand beside the file.
    """
    folder = RunFolder(results)
    found = folder.provenance().get("models", {}) if folder.has_its_results() else {}
    return {str(name): dict(_origin(model)) for name, model in found.items()}


def _origin(model: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    machines = model.get("machines", [])
    names = dict.fromkeys(name for machine in machines for name in machine)
    for name in names:
        if name not in _NOT_ORIGINS:
            values = dict.fromkeys(str(machine.get(name, "unknown")) for machine in machines)
            yield name, " and ".join(values)
    yield "threads", str(model.get("threads", "unknown"))
    yield "code", str(model.get("identity", {}).get("code", "unknown"))


def differences(
    old: Mapping[str, Mapping[str, str]], new: Mapping[str, Mapping[str, str]]
) -> list[str]:
    """Return what differs between the origins of the same models, a line each.

    Examples
    --------
    >>> old = {"main/bem": {"numpy": "1.26.4"}, "main/persson": {"numpy": "1.26.4"}}
    >>> new = {"main/bem": {"numpy": "2.3.0"}, "main/persson": {"numpy": "2.3.0"}}
    >>> differences(old, new)
    ['numpy: 1.26.4 → 2.3.0']
    """
    found: dict[str, list[str]] = {}
    shared = [name for name in new if name in old]
    for model in shared:
        for line in changes(old[model], new[model]):
            is_code = line.startswith("code: ")  # digests say nothing to people
            found.setdefault("code: another" if is_code else line, []).append(model)
    return [
        line if len(models) == len(shared) else f"{line} ({', '.join(models)})"
        for line, models in found.items()
    ]


def changed_options(old: Results, new: Results) -> list[str]:
    """Return in what the attributes of the same models differ: options, and the surface.

    An option that the old results do not know is one that its version did not have.
    """
    lines: dict[str, list[str]] = {}
    shared = [
        (f"{experiment}/{label}", old[experiment][label], after)
        for experiment, after_models in new.items()
        for label, after in after_models.items()
        if label in old.experiments.get(experiment, {})
    ]
    for name, before, after in shared:
        for line in _changed(before, after):
            lines.setdefault(line, []).append(name)
    return [
        line if len(names) == len(shared) else f"{', '.join(names)}: {line}"
        for line, names in lines.items()
    ]


def _changed(before: ModelResult, after: ModelResult) -> list[str]:
    return changes(dict(before.attributes), dict(after.attributes))
