"""``eehal schema``: the possible content of a description, for editors and for people."""

from __future__ import annotations

import click

from end_effector_hal.description import markdown, schema_text


@click.command(name="schema")
@click.option(
    "--markdown", "as_markdown", is_flag=True, help="Tables of all keys, as in docs/reference/description.md."
)
def command(as_markdown: bool) -> None:
    """Print the JSON Schema (draft 2020-12) of a description.

    An editor uses it when the first line of the YAML file names it: `# yaml-language-server: $schema=FILE`.
    """
    click.echo(markdown() if as_markdown else schema_text(), nl=False)
