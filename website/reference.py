"""Pages of the site that are made from the code: commands, and the names of Python."""

from __future__ import annotations

import importlib
import inspect
import re

import click

import roughbench as rb
from roughbench import public
from roughbench.cli import COMMANDS, main

PARTS = {
    "runner": "Specs and runs",
    "spec": "Specs and runs",
    "store": "Results",
    "results": "Results",
    "figures": "Results",
    "field_files": "Results",
    "models": "Contact and models",
    "spectrum": "Spectra and heights",
    "surface": "Spectra and heights",
    "scans": "Measured surfaces",
    "errors": "Errors",
}
"""Room in which a public name is defined → the part of the page that describes it."""

MODULES = {
    "figures": "available departures render join overlaid",
    "fits": "fit",
    "neighbours": "surface_of fields_of topography contactmechanics_system tamaas_model "
    "aspher_arguments PeriodicSurface PressedFields",
    "observables": "of_state average exponent pressure_pdf gap_pdf stress_spectrum "
    "contact_spectrum clusters find_patches Observable Profile",
    "quantities": "Quantity Variable",
    "runner": "preview status verify clean reproduce accounts partial_results Cluster",
    "verdict": "fit_experiments judge_experiments trust_of",
    "report": "make_report",
    "errors": "IncompleteError LockedError UnknownNameError",
    "surface_record": "SurfaceRecord",
    "scans.roughness": "Roughness",
    "scans.self_affine_fit": "SelfAffineFit",
    "scans.preparation": "Preparation",
    "scans.measured_spectrum": "MeasuredSpectrum",
    "models.distributions": "persson_separations persson_gap_shares spring_shares shares_of",
    "models.halfspace.perimeter": "edge_excess",
    "models.hertz_top": "finite_size_prefactor",
    "models.line": "single_contact_stiffness",
    "models.persson": "persson_asymptotes",
}
"""Modules beside the public names → what of them pages name or users may need."""


def commands_page() -> str:
    """Return the page of the commands, from what click knows of them."""
    lines = [
        "# Commands, from their help",
        "",
        "What each command says with `--help`. What they do, and why, says",
        "[Commands](../docs/cli.md).",
        "",
    ]
    parent = click.Context(main, info_name="roughbench")
    for name in COMMANDS:
        command = main.get_command(parent, name)
        if command is None:
            raise SystemExit(f"there is no command {name!r}")
        context = click.Context(command, info_name=name, parent=parent)
        usage = " ".join([context.command_path, *command.collect_usage_pieces(context)])
        lines += [f"## {context.command_path}", "", f"    {usage}", ""]
        lines += [in_markdown(inspect.cleandoc(command.help or "")), ""]
        options = [one for one in command.params if isinstance(one, click.Option)]
        rows = [found for one in options if (found := one.get_help_record(context))]
        if rows:
            lines += ["| option | meaning |", "|---|---|"]
            for option, words in rows:
                name_and_values = option.replace("|", r"\|")
                lines.append(f"| `{name_and_values}` | {in_cell(words)} |")
        epilog = (command.epilog or "").replace("\b\n", "").splitlines()
        lines += ["", *epilog[:1], "", "```sh", *map(str.strip, epilog[1:]), "```", ""]
    return "\n".join(lines)


def in_markdown(text: str) -> str:
    """Return text with what Markdown would take for markup escaped."""
    return re.sub(r"([\\`*_<\[|])", r"\\\1", text.replace("\b\n", ""))


def in_cell(text: str) -> str:
    """Return text for one cell of a table."""
    return in_markdown(" ".join(text.split()))


def python_page() -> str:
    """Return the page of the public names of Python, by parts."""
    lines = [
        "# Python reference",
        "",
        "All public names: after `import roughbench as rb`, `run` is `rb.run`. How they go",
        "together says [From Python](../docs/python.md).",
        "",
    ]
    for part, names in parts().items():
        lines += [f"## {part}", "", "```{eval-rst}", ".. currentmodule:: roughbench", ""]
        lines += [f".. auto{_kind(getattr(rb, name))}:: {name}\n" for name in names]
        lines += ["```", ""]
    return "\n".join(lines)


def modules_page() -> str:
    """Return the page of what modules hold beside the public names."""
    lines = [
        "# Modules for Python",
        "",
        "What stands beside the [public names](python.md). After `import roughbench as rb`,",
        f"{', '.join(f'`rb.{name}`' for name in public.MODULES)}",
        "are there; others are imported by their whole names.",
        "",
    ]
    for module, names in MODULES.items():
        path = f"roughbench.{module}"
        content = importlib.import_module(path)
        words = inspect.cleandoc(content.__doc__ or "").partition("\n")[0]
        lines += [
            f"## `{path}`",
            "",
            words,
            "",
            "```{eval-rst}",
            f".. currentmodule:: {path}",
            "",
        ]
        lines += [
            f".. auto{_kind(getattr(content, name))}:: {name}\n" for name in names.split()
        ]
        lines += ["```", ""]
    return "\n".join(lines)


def parts() -> dict[str, list[str]]:
    """Return the public names by part: functions before classes, each in order."""
    found: dict[str, list[str]] = {part: [] for part in dict.fromkeys(PARTS.values())}
    for name in sorted(rb.__all__, key=lambda one: (one[0].isupper(), one)):
        if not name.startswith("__"):
            room = public.LAZY.get(name, "roughbench.errors").split(".")[1]
            found.setdefault(PARTS.get(room, room.capitalize()), []).append(name)
    return {part: names for part, names in found.items() if names}


def _kind(thing: object) -> str:
    if inspect.isclass(thing):
        return "exception" if issubclass(thing, BaseException) else "class"
    return "function" if callable(thing) else "data"
