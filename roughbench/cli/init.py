"""``roughbench init``: specs to start from, or a package with a model of one's own."""

from __future__ import annotations

import os
import re
from pathlib import Path

import click

from roughbench.cli.options import debug_option, example

_MODEL = {
    "pyproject.toml.txt": "pyproject.toml",
    "model.py.txt": "{module}.py",
    "test_model.py.txt": "test_{module}.py",
    "spec.yaml.txt": "{module}.yaml",
}
"""Template → file of the package."""
_SPECS = {
    "spec": "spec.yaml.txt",
    "synthetic": "spec.yaml.txt",
    "scan": "scan.yaml.txt",
    "cluster": "cluster.yaml.txt",
}
"""Kind → template of a spec; ``spec`` is what ``synthetic`` was called first."""


@click.command(
    "init",
    epilog=example(
        "roughbench init rough",
        "roughbench init --template scan plate",
        "roughbench init --template model mytheory",
    ),
)
@click.argument("name", required=False)
@click.option(
    "--template",
    type=click.Choice([*_SPECS, "model"]),
    default="spec",
    show_default=True,
    help="A spec NAME.yaml: of surfaces with a given spectrum (synthetic, or spec), of a "
    "measured scan, or for a cluster; or a folder NAME with a model of one file, its test and "
    "a spec.",
)
@debug_option
def command(name: str | None, template: str) -> None:
    """Write files to start from, in the current folder.

    NAME is by default that of the template. No file is ever written over.
    """
    from importlib.resources import files

    from roughbench.errors import RoughbenchError
    from roughbench.models.registry import kinds
    from roughbench.publish import commit

    name = name or {"model": "mytheory"}.get(template, template)
    if template != "model":
        name = re.sub(r"(?<=.)\.ya?ml$", "", name)
    allowed = r"[A-Za-z][A-Za-z0-9_-]*" if template == "model" else r"[A-Za-z0-9][\w.+-]*"
    if not re.fullmatch(allowed, name, re.ASCII):
        raise click.BadParameter(
            f"must have letters, digits and any of _- , a letter first, got {name!r}",
            param_hint="NAME",
        )
    module = name.replace("-", "_").lower()
    if template == "model" and module in kinds():
        raise click.BadParameter(f"there is a model {module!r} already", param_hint="NAME")
    words = {
        "NAME": name,
        "DISTRIBUTION": name.lower(),
        "MODULE": module,
        "CLASS": "".join(part.capitalize() for part in module.split("_")),
    }
    folder = files("roughbench.cli") / "templates"
    if template in _SPECS:
        made = {Path(f"{name}.yaml"): folder / _SPECS[template]}
    else:
        made = {
            Path(name, target.format(module=module)): folder / "model" / source
            for source, target in _MODEL.items()
        }
    for path in (Path(name), *made) if template == "model" else made:
        if os.path.lexists(path):
            raise RoughbenchError(f"{path} is there already; choose another name, or move it")
    for path, source in made.items():
        text = source.read_text(encoding="utf-8")
        for word, value in words.items():
            text = text.replace(f"@{word}@", value)
        path.parent.mkdir(exist_ok=True)
        commit(text.encode(), path, way_out="begin in another folder")
        click.echo(path)
