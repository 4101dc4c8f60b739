"""Each command of ``eehal`` with its arguments and options, from the parser."""

from __future__ import annotations

import re
from collections.abc import Iterator
from inspect import cleandoc

import click

from end_effector_hal.cli._main import eehal

from ._markdown import plain, table

WIDTH = 80
"""Of a usage line, however wide the terminal is."""


def commands() -> str:
    """All commands of this product, in the order of ``eehal --help``."""
    context = click.Context(eehal, info_name="eehal", terminal_width=WIDTH)
    names = [name for name in eehal.list_commands(context) if _is_ours(eehal.get_command(context, name))]
    return "\n\n".join(part for name in names for part in _command(name, context, 2))


def _is_ours(command: click.Command | None) -> bool:
    """Whether it is no command that another distribution adds."""
    modules = [each.__module__ for each in (command, getattr(command, "callback", None)) if each is not None]
    return any(module.startswith("end_effector_") for module in modules)


def _command(name: str, parent: click.Context, level: int) -> Iterator[str]:
    group = parent.command
    assert isinstance(group, click.Group)
    command = group.get_command(parent, name)
    assert command is not None
    context = click.Context(command, info_name=name, parent=parent)
    yield f"{'#' * level} `{context.command_path}`"
    yield f"```text\n{command.get_usage(context)}\n```"
    yield _prose(command.help or "")
    rows = list(_options(command, context))
    if rows:
        yield table(("option", "meaning", "default"), rows)
    if isinstance(command, click.Group):
        for each in command.list_commands(context):
            yield from _command(each, context, level + 1)


def _prose(text: str) -> str:
    paragraphs = re.split(r"\n\s*\n", cleandoc(text.partition("\f")[0]))
    return "\n\n".join(_paragraph(paragraph) for paragraph in paragraphs)


def _paragraph(text: str) -> str:
    head, _, rest = text.partition("\n")
    return f"```text\n{rest}\n```" if head.strip() == "\b" else plain(text)


def _options(command: click.Command, context: click.Context) -> Iterator[tuple[str, str, str]]:
    for each in command.get_params(context):
        record = each.get_help_record(context)
        if not isinstance(each, click.Option) or record is None or "--help" in each.opts:
            continue
        default = each.to_info_dict()["default"]
        shown = str(default) if each.show_default and isinstance(default, str | int | float) else ""
        yield f"`{record[0]}`", plain(each.help or ""), f"`{shown}`" if shown and not each.is_flag else ""
