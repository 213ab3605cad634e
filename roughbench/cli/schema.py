"""``roughbench schema``: the JSON schema of specs."""

from __future__ import annotations

import click

from roughbench.cli.options import debug_option, example


@click.command("schema", epilog=example("roughbench schema > roughbench.schema.json"))
@debug_option
def command() -> None:
    """Print the JSON schema of specs.

    For editors that complete and check YAML.
    """
    import json

    from roughbench.spec import json_schema

    click.echo(json.dumps(json_schema(), indent=2, ensure_ascii=False))
