"""Prints the output of ``--json``: one object, or one object per line. Every object names the version of its schema."""

from __future__ import annotations

import json
from collections.abc import Mapping

import click

SCHEMA_VERSION = 1
"""Increased when a field is removed or changes its meaning; new fields do not change it."""


def json_text(document: Mapping[str, object], *, indent: int | None = None) -> str:
    """Return an object as JSON text with its ``schema_version`` first."""
    return json.dumps({"schema_version": SCHEMA_VERSION, **document}, indent=indent, ensure_ascii=False)


def print_document(document: Mapping[str, object]) -> None:
    """Print the object that is the answer of a command, on several lines."""
    click.echo(json_text(document, indent=2))


def print_line(**content: object) -> None:
    """Print one object of a sequence on a line of its own."""
    click.echo(json_text(content))
