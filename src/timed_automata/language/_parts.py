"""Parses the parts of a model."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache, partial
from typing import Any

from timed_automata.document import Text
from timed_automata.language import ast
from timed_automata.language._parser import parse

Item = ast.Declaration | ast.Instantiation
"""An item of the ``instantiation`` element, which older files have before ``system``."""


def _parse(text: Text, start: str) -> Any:
    """Parse a text as the grammar rule ``start``; raise ModelError if the text does not match it."""
    return (_kept or parse)(text, start)


ParseCache = Callable[[Text, str], Any]
_kept: ParseCache | None = None


def parse_cache(most: int = 4000) -> ParseCache:
    """Return a cache for `parsing_with` that holds the results of the ``most`` texts used last."""
    return lru_cache(most)(parse)


@contextmanager
def parsing_with(cache: ParseCache) -> Iterator[None]:
    """Use the cache for all texts parsed inside: for many networks of almost the same document."""
    global _kept
    before, _kept = _kept, cache
    try:
        yield
    finally:
        _kept = before


parse_declarations: Callable[[Text], tuple[ast.Declaration, ...]] = partial(_parse, start="declarations")
parse_instantiations: Callable[[Text], tuple[Item, ...]] = partial(_parse, start="instantiations")
parse_system: Callable[[Text], ast.System] = partial(_parse, start="system")
parse_parameters: Callable[[Text], tuple[ast.Parameter, ...]] = partial(_parse, start="parameters")
parse_name: Callable[[Text], str] = partial(_parse, start="name_of_part")
parse_selects: Callable[[Text], tuple[ast.Select, ...]] = partial(_parse, start="selects")
parse_expression: Callable[[Text], ast.Expression] = partial(_parse, start="expression")
parse_synchronisation: Callable[[Text], ast.Synchronisation] = partial(_parse, start="synchronisation")
parse_updates: Callable[[Text], tuple[ast.Expression, ...]] = partial(_parse, start="items")


def names_in(text: str) -> set[str]:
    """Return the words of a text that may be names; it need not be well-formed."""
    return set(re.findall(r"[A-Za-z_]\w*", text))
