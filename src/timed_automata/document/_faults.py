"""How a fault of a model is worded: the place, the offending text, what is expected, the likely meaning."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from timed_automata.document._text import Span
from timed_automata.errors import ModelError


def fault(span: Span, what: str, todo: str = "") -> ModelError:
    """A ModelError at the span."""
    return ModelError(what, where=span.where, todo=todo)


def refused(span: Span, construct: str, todo: str = "") -> ModelError:
    """What UPPAAL knows and this subset does not, by name."""
    return fault(span, f"{construct}: outside of the supported subset.", todo)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """``Did you mean …?`` or nothing."""
    close = get_close_matches(name, sorted(set(known)), n=1, cutoff=0.6)
    return f"Did you mean '{close[0]}'?" if close else ""
