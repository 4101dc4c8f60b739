"""The constants that a template mentions, in words."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from timed_automata import Template

_SHORT = 4  # as many equal elements are written out


def mentioned(template: Template, constants: Mapping[str, object]) -> list[str]:
    """``N = 3``, ``T_CONFIRM = {5000, 5000, 5000}``: in the order of the file."""
    words = {word for text in _texts(template) for word in re.findall(r"\w+", text)}
    return [f"{name} = {_written(value)}" for name, value in constants.items() if name in words]


def _texts(template: Template) -> Iterator[str]:
    for text in (template.parameters, template.declarations):
        if text:
            yield text.content
    labels = [each.labels for each in template.locations] + [each.labels for each in template.edges]
    for kind, label in (item for each in labels for item in each.items()):
        if kind != "comments":
            yield label.text.content


def _written(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if not isinstance(value, Sequence):
        return str(value)
    items = [_written(item) for item in value]
    if len(items) > _SHORT and len(set(items)) == 1:
        return f"{{{items[0]}, … {len(items)} times}}"
    return "{" + ", ".join(items) + "}"
