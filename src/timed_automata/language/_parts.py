"""The parts of a model that are read one by one; the parser loads with the first of them.

A process that reads no model does not need the parser, which costs 4 MB.
"""

from __future__ import annotations

from typing import Any, cast

from timed_automata.document import Text
from timed_automata.language import ast


def _parse(text: Text, start: str) -> Any:
    from ._parser import parse

    return parse(text, start)


def parse_declarations(text: Text) -> tuple[ast.Declaration, ...]:
    """The declarations of the network or of a template."""
    return cast("tuple[ast.Declaration, ...]", _parse(text, "declarations"))


def parse_instantiations(text: Text) -> tuple[ast.Declaration | ast.Instantiation, ...]:
    """The ``instantiation`` element that older files have before ``system``."""
    return cast("tuple[ast.Declaration | ast.Instantiation, ...]", _parse(text, "instantiations"))


def parse_system(text: Text) -> ast.System:
    """The system section."""
    return cast(ast.System, _parse(text, "system"))


def parse_parameters(text: Text) -> tuple[ast.Parameter, ...]:
    """The parameters of a template."""
    return cast("tuple[ast.Parameter, ...]", _parse(text, "parameters"))


def parse_selects(text: Text) -> tuple[ast.Select, ...]:
    """A select label."""
    return cast("tuple[ast.Select, ...]", _parse(text, "selects"))


def parse_expression(text: Text) -> ast.Expression:
    """A guard, an invariant."""
    return cast(ast.Expression, _parse(text, "expression"))


def parse_synchronisation(text: Text) -> ast.Synchronisation:
    """A synchronisation label."""
    return cast(ast.Synchronisation, _parse(text, "synchronisation"))


def parse_updates(text: Text) -> tuple[ast.Expression, ...]:
    """An assignment label: a list separated by commas."""
    return cast("tuple[ast.Expression, ...]", _parse(text, "items"))
