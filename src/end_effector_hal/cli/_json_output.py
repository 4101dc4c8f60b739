"""What ``--json`` prints: one object, or one in each line; each names the version of its schema."""

from __future__ import annotations

import json
from collections.abc import Mapping

import click

SCHEMA_VERSION = 1
"""Raised when a field goes, or means something else. New fields come without."""


def json_text(document: Mapping[str, object], *, indent: int | None = None) -> str:
    """An object as text, with its ``schema_version`` first."""
    return json.dumps({"schema_version": SCHEMA_VERSION, **document}, indent=indent, ensure_ascii=False)


def print_document(document: Mapping[str, object]) -> None:
    """Print the object that a command answers, over several lines."""
    click.echo(json_text(document, indent=2))


def print_line(**content: object) -> None:
    """Print one object of many, in a line of its own."""
    click.echo(json_text(content))
