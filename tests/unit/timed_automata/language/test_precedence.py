"""An expression without brackets is the one with brackets where UPPAAL's precedence puts them."""

from __future__ import annotations

from typing import Any

import pytest

from timed_automata.document import Span, Text
from timed_automata.language import parse_expression
from timed_automata.language.ast import Node

BRACKETS = [
    "a || (b && c)", "(a && b) || c", "a && (b | c)", "(a | b) && c", "a | (b ^ c)", "(a ^ b) | c", "a ^ (b & c)",
    "(a & b) ^ c", "a & (b == c)", "(a != b) & c", "a == (b < c)", "(a >= b) != c", "a < (b <? c)", "(a >? b) <= c",
    "a <? (b << c)", "(a >> b) >? c", "a << (b + c)", "(a - b) >> c", "a + (b * c)", "(a % b) - c", "(-a) * b",
    "(!a) == b", "(not a) and b", "(a imply b) || c", "(a - b) - c", "(a / b) * c", "(a && b) ? c : d",
    "a ? b : (c ? d : e)", "a = (b ? c : d)", "a = (b = c)", "-(a[b])", "!(a.b)", "a + (forall (i : t) (i && b))",
]  # fmt: skip


def shape(text: str) -> Any:
    def of(node: Any) -> Any:
        if isinstance(node, Node):
            return type(node), *(of(getattr(node, name)) for name in node.__dataclass_fields__)
        return None if isinstance(node, Span) else node

    return of(parse_expression(Text.plain(text, "m.xml")))


@pytest.mark.parametrize("text", BRACKETS)
def test_an_expression_is_read_as_if_it_had_these_brackets(text: str) -> None:
    kept = text.replace("forall (", "forall <").replace("t)", "t>")  # of the quantifier
    bare = kept.replace("(", "").replace(")", "").replace("forall <", "forall (").replace("t>", "t)")
    assert shape(bare) == shape(text)
