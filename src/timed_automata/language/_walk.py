"""Everything that stands inside a node of the syntax tree."""

from __future__ import annotations

from collections.abc import Iterator

from timed_automata.language import ast


def walk(node: object, *, into_members: bool = True) -> Iterator[ast.Node]:
    """A node and all nodes inside it; without ``into_members`` not what stands before a dot."""
    if isinstance(node, tuple):
        for item in node:
            yield from walk(item, into_members=into_members)
    elif isinstance(node, ast.Node):
        yield node
        if into_members or not isinstance(node, ast.Member):
            for name in node.__dataclass_fields__:
                yield from walk(getattr(node, name), into_members=into_members)
