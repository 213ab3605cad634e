"""Where two results come from, and in what that differs: why they may be apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from roughbench.results import ModelResult, Results
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.identity import changes
from roughbench.store import opened

_NOT_ORIGINS = {"host", "cores"}
"""What numbers do not depend on."""


def origins(results: Path) -> dict[str, dict[str, str]]:
    """Return what is known of how each model of a results file was computed.

    Returns
    -------
    dict of str to dict of str to str
        Model, such as ``main/bem`` → versions, processor, threads and code; where the
        run directory that it came from does not stand beside the file, what the file says
        itself, which may be nothing.
    """
    folder = RunFolder(results)
    found = folder.provenance().get("models", {}) if folder.has_its_results() else {}
    if found:
        return {str(name): dict(_origin(model)) for name, model in found.items()}
    with opened(results) as alone:
        said = {
            f"{experiment}/{result.label}": result.made_with
            for experiment, result in alone.models()
        }
    return {
        name: {key: str(value) for key, value in made_with.items()}
        for name, made_with in said.items()
        if made_with
    }


def _origin(model: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    machines = model.get("machines", [])
    names = dict.fromkeys(name for machine in machines for name in machine)
    for name in names:
        if name not in _NOT_ORIGINS:
            values = dict.fromkeys(str(machine.get(name, "unknown")) for machine in machines)
            yield name, " and ".join(values)
    yield "threads", str(model.get("threads", "unknown"))
    identity = model.get("identity", {})
    yield "code", str(identity.get("code", "unknown"))
    if "fft" in identity:
        yield "fft", str(identity["fft"])


def differences(
    old: Mapping[str, Mapping[str, str]], new: Mapping[str, Mapping[str, str]]
) -> list[str]:
    """Return what differs of what both origins of the same models say, a line each.

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
        known = old[model].keys() & new[model].keys()
        before, after = (
            {name: value for name, value in one.items() if name in known}
            for one in (old[model], new[model])
        )
        for line in changes(before, after):
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
