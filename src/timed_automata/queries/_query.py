"""Parses queries into kind and expressions. ``_compile`` gives them a meaning in a network."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from timed_automata.document import Span, Text, fault, refused
from timed_automata.errors import ModelError
from timed_automata.language import ast, parse_expression

QueryKind = Literal["A[]", "E<>", "A<>", "E[]", "-->", "sup", "inf"]

_PATH = re.compile(r"\s*(A\s*\[\s*\]|E\s*<\s*>|A\s*<\s*>|E\s*\[\s*\])")
_EXTREME = re.compile(r"\s*(sup|inf)\b\s*([{:])?")
_ASK = "Ask whether it is possible (E<>), certain (A[], A<>), or how long it takes (sup, inf)."
_REFUSED = {
    r"(Pr|E)\s*\[|simulate\b|\bE\s*\[.*;": ("a query of statistical model checking", _ASK),
    r"(strategy|minE|maxE|saveStrategy|loadStrategy|acontrol)\b|.*\bunder\b": (
        "a query about strategies",
        _ASK,
    ),
    r"(E\s*<\s*>\s*)?control(_t\*?)?\b|\{.*\}\s*control\b": ("a query about strategies (control)", _ASK),
    r"[AE]\s*\[.*\b[UW]\b": (
        "until and weak until",
        "Ask 'p --> q', or A[] with a variable that remembers p.",
    ),
    r"bounds\b": ("'bounds'", "Ask 'inf' and 'sup'."),
    r"refinement\b|specification\b|consistency\b": (
        "a query of ECDAR",
        "Compare two networks by trace inclusion.",
    ),
}


@dataclass(frozen=True, slots=True, eq=False)
class Query:
    """A parsed query.

    Attributes:
        kind: the kind of question.
        text: its text, with its place.
        condition: p in ``A[] p`` and similar, the left side of ``-->``, the braces of ``sup{}`` (None: true).
        then: the right side of ``-->``.
        targets: the clocks or expressions of ``sup`` and ``inf``.
    """

    kind: QueryKind
    text: Text
    condition: ast.Expression | None
    then: ast.Expression | None = None
    targets: tuple[ast.Expression, ...] = ()

    def __str__(self) -> str:
        return " ".join(self.text.content.split())


def parse_query(text: Text | str) -> Query:
    """Parse a query of UPPAAL's query language.

    Raises:
        ModelError: the query is not well-formed, or outside of the supported subset; with the position.
    """
    if isinstance(text, str):
        text = Text.plain(text, "query")
    text = text.without_comments()
    content = text.content
    if (extreme := _EXTREME.match(content)) and (extreme[2] or _top_level(content, "-->") < 0):
        return _extreme(text, extreme)
    try:
        return _plain(text)
    except ModelError:
        _refuse(
            text
        )  # the words that this looks for may be names, too: only where it cannot be read otherwise
        raise


def _plain(text: Text) -> Query:
    content = text.content
    path, arrow = _PATH.match(content), _top_level(content, "-->")
    rest = path.end() if path else 0
    if path:
        if arrow >= 0:
            raise refused(
                Span(text, arrow, arrow + 3), "'-->' inside another query", "Write 'p --> q' alone."
            )
        kind: QueryKind = re.sub(r"\s", "", path[1])  # type: ignore[assignment]
        return Query(kind, text, parse_expression(text.cut(rest, len(content))))
    if arrow < 0:
        what = f"'{text.whole.snippet}' is no query."
        raise fault(text.whole, what, "Expected A[] p, E<> p, A<> p, E[] p, p --> q, sup{p}: x or inf{p}: x.")
    left, right = text.cut(0, arrow), text.cut(arrow + 3, len(content))
    return Query("-->", text, parse_expression(left), parse_expression(right))


def _refuse(text: Text) -> None:
    for pattern, (name, todo) in _REFUSED.items():
        if re.match(r"\s*(" + pattern + ")", text.content, re.DOTALL):
            raise refused(text.whole, f"'{text.whole.snippet}', {name}", todo)


def _top_level(content: str, token: str, start: int = 0) -> int:
    """Return the position of a token outside of all brackets, or -1."""
    depth = 0
    for at in range(start, len(content)):
        if not depth and content.startswith(token, at):
            return at
        depth += (content[at] in "([{") - (content[at] in ")]}")
    return -1


def _extreme(text: Text, found: re.Match[str]) -> Query:
    content, condition = text.content, None
    start = found.start(2) if found[2] == ":" else found.end()
    if found[2] == "{":
        end = _top_level(content, "}", start)
        if end < 0:
            raise fault(Span(text, start - 1, start), "This brace is not closed.", "Expected '}'.")
        if content[start:end].strip():
            condition = parse_expression(text.cut(start, end))
        start = end + 1
    if not (colon := re.match(r"\s*:", content[start:])):
        raise fault(
            Span(text, start, start + 1),
            "The clock or expression is missing.",
            f"Expected ':' and a clock after '{found[1]}'.",
        )
    start += colon.end()
    targets = []
    while True:
        comma = _top_level(content, ",", start)
        targets.append(parse_expression(text.cut(start, comma if comma >= 0 else len(content))))
        if comma < 0:
            return Query("sup" if found[1] == "sup" else "inf", text, condition, targets=tuple(targets))
        start = comma + 1
