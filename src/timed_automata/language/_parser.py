"""Parses model text to the syntax tree; errors contain the place, the offending text and the expected text."""

from __future__ import annotations

import re
import sys
from functools import cache
from importlib.util import cache_from_source
from pathlib import Path
from typing import Any, cast

from lark import Lark, Token, UnexpectedCharacters, UnexpectedEOF, UnexpectedInput, UnexpectedToken
from lark.lexer import PatternStr

from timed_automata._limits import NESTING, TEXT_CHARACTERS
from timed_automata.document import Span, Text, fault, refused
from timed_automata.errors import ModelError
from timed_automata.language._builder import Builder

_STARTS = [
    "declarations",
    "instantiations",
    "system",
    "parameters",
    "selects",
    "expression",
    "synchronisation",
    "items",
]

_DEPTH = re.compile(
    rf"//[^\n]*|/\*.*?(?:\*/|\Z)|[([{{}}\])]|(?P<signs>(?:[-+!]\s*|\bnot\s+){{{NESTING + 1}}})", re.DOTALL
)
_OPERAND = {"NAME", "NUMBER", "LPAR", "BOOLEAN", "DOUBLE", "SIGN", "BANG", "STEP", "QUANTIFIER"}
_OPERATOR = {"OR", "AND", "BIT_OR", "BIT_XOR", "AMPERSAND", "EQUALITY", "COMPARISON", "EXTREME", "SHIFT"}
_OPERATOR |= {"SIGN", "FACTOR"}
_SUFFIX = {"QUESTION", "COMPOUND", "STEP", "LSQB", "DOT", "APOSTROPHE", "LPAR"}
_FLOATING = (
    "fabs fmod fma fmax fmin fdim exp exp2 expm1 ln log log10 log2 log1p pow sqrt cbrt hypot sin cos tan asin acos atan"
    " atan2 sinh cosh tanh asinh acosh atanh erf erfc tgamma lgamma ceil floor trunc round fint ldexp ilogb logb"
    " nextafter copysign fpclassify isfinite isinf isnan isnormal signbit isunordered random random_arcsine random_beta"
    " random_gamma random_normal random_poisson random_tri random_weibull"
)
_NO_NAMES = frozenset(
    f"""{_FLOATING} abs and bool bounds branchpoint broadcast chan clock commit const control control_t deadlock double
    exists false forall foreach guard imitate imply inf init int loadStrategy maxE maxPr minE minPr not numOf or Pmax Pr
    priority probability process sat saveStrategy scalar simulate simulation state strategy sum sup sync system trans
    true assign under urgent void X""".split()
)
"""Words that UPPAAL refuses as the name of a location or a template: its queries and older text format reserve them."""
_REFUSED_BY_CONSTRUCT = {
    "double string": ("a type that is not integral", "Use an integer of a smaller unit: 1500 ms for 1.5 s."),
    "hybrid": ("a hybrid clock", "Use a clock; it runs at rate one."),
    "priority": ("a priority", "Guard what must wait by what must come first, or use a committed location."),
    "import": ("an external function", "Write the function in the model."),
    "dynamic spawn exit": ("a dynamic template", "Put as many processes on the system line as there can be."),
    "gantt": ("a Gantt chart", "Remove it: it changes no verdict."),
    "progress": ("a progress measure", "Remove it: it changes no verdict."),
    "before_update after_update": ("a global update", "Call a function in the update of each edge."),
    "default assert": ("this statement", "Use 'if', and a query for what must hold."),
    "xor": ("this operator", "Write '!=' between two conditions."),
    "query IO": ("this section", "Remove it."),
    "process state trans commit branchpoint": ("a template written as text", "Write it as a <template>."),
    "select guard sync assign probability init location": (
        "a word that UPPAAL reserves",
        "Use another name.",
    ),
    _FLOATING: ("a function on floating-point numbers", "Compute with integers of a smaller unit."),
    "abs": ("a built-in function", "Write 'a < 0 ? -a : a'."),
}
_REFUSED_WORDS = {word: said for words, said in _REFUSED_BY_CONSTRUCT.items() for word in words.split()}
"""Words that UPPAAL reserves and this subset lacks: the construct that they belong to, and what to do instead."""
_SWITCH = re.compile(r"\bswitch\s*\([^{}]*\)\s*\Z")
_READABLE = {"NAME": "a name", "EQUALS": "'='", "PREFIX": "a type", "BASE": "a type", "INT": "a type"}
_READABLE |= dict.fromkeys(("STRUCT", "SCALAR"), "a type")


class _RefusedWordError(Exception):
    """A reserved word that belongs to a construct outside of the subset."""

    def __init__(self, token: Token) -> None:
        self.token = token


def _check_word(token: Token) -> Token:
    if token in _REFUSED_WORDS:
        raise _RefusedWordError(token)
    return token


@cache
def _lark() -> Lark:
    """Return the parser; its tables, which take a tenth of a second to make, are cached beside the bytecode of this
    package.

    Lark makes them again if they cannot be written or read, or belong to another grammar or version.
    """
    grammar = Path(__file__).with_name("grammar.lark")
    return Lark(
        grammar.read_text(encoding="utf-8"),
        cache=not sys.dont_write_bytecode and f"{cache_from_source(str(grammar))}.lark",
        start=_STARTS,
        parser="lalr",
        lexer="basic",
        propagate_positions=True,
        lexer_callbacks={"NAME": _check_word},
    )


def _readable(terminals: set[str]) -> str:
    """Return the words that may follow here, grouped so that the list stays short."""
    terminals = terminals - {"FIELD"}  # a name after a dot
    if terminals >= _OPERATOR:
        terminals = terminals - _OPERATOR - _SUFFIX | {"operator"}
    elif "COMPARISON" in terminals:  # on the system line, where it is read only to be refused
        terminals = terminals - {"COMPARISON"}
    if terminals >= _OPERAND:
        terminals = terminals - _OPERAND | {"expression"}
    literals = {
        terminal.name: f"'{terminal.pattern.value}'"
        for terminal in _lark().terminals
        if isinstance(terminal.pattern, PatternStr)
    }
    names = {
        "operator": "an operator",
        "expression": "an expression",
        "$END": "the end",
        **literals,
        **_READABLE,
    }
    words = sorted({names.get(terminal, terminal.lower()) for terminal in terminals})
    return " or ".join(", ".join(words).rsplit(", ", 1)) if words else "nothing"


def _syntax_error(text: Text, error: UnexpectedInput) -> ModelError:
    if isinstance(error, UnexpectedCharacters):
        start = error.pos_in_stream or 0
        span = Span(text, start, start + 1)
        return fault(span, f"'{text.content[start]}' is no part of the language.")
    expected = _readable(set(cast("Any", error).accepts or cast("Any", error).expected))
    token = error.token if isinstance(error, UnexpectedToken) else None
    if token is None or token.type == "$END" or isinstance(error, UnexpectedEOF):
        end = len(text.content.rstrip())
        return fault(Span(text, end, end), "The text ends too early.", f"Expected {expected}.")
    start = token.start_pos or 0
    if token == "{" and (found := _SWITCH.search(text.content, 0, start)):
        return refused(
            Span(text, found.start(), found.start() + 6), "'switch', this statement", "Use 'if' and 'else'."
        )
    if text.content.startswith("/*", start):
        return fault(Span(text, start, start + 2), "This comment does not end.", "Expected '*/'.")
    return fault(
        Span(text, start, start + len(token)), f"'{token}' is not expected here.", f"Expected {expected}."
    )


def _check_size(text: Text) -> None:
    """Refuse a text that is too long or too deeply nested before it is parsed."""
    if len(text.content) > TEXT_CHARACTERS:
        what = f"This text has {len(text.content)} characters, more than {TEXT_CHARACTERS}."
        raise fault(text.whole, what, "Break it into parts.")
    depth = 0
    for found in _DEPTH.finditer(text.content):
        token = found.group()
        depth += (token in "([{") - (token in ")]}")
        if depth > NESTING or found.lastgroup == "signs":
            where = Span(text, found.start(), found.start() + 1)
            raise fault(
                where, f"This is nested too deeply, more than {NESTING} deep.", "Break it into parts."
            )


def _name_of_part(text: Text) -> str:
    """Return the name of a template or a location; raise ModelError if UPPAAL does not accept it."""
    name = text.content.strip()
    span = Span(text, at := text.content.find(name), at + len(name))
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_$#]*", name):
        raise fault(span, f"'{span.snippet}' is no name.", "Expected a letter, then letters and digits.")
    if name in _NO_NAMES:
        raise fault(span, f"'{name}' is a keyword of UPPAAL, not a name.", "Choose another name.")
    return name


def parse(text: Text, start: str) -> Any:
    """Parse a text as the grammar rule ``start``; raise ModelError if the text does not match it."""
    _check_size(text)
    if start == "name_of_part":  # of a template or a location: a word, of no language
        return _name_of_part(text)
    try:
        return Builder(text).build(_lark().parse(text.content, start=start))
    except _RefusedWordError as error:
        position = error.token.start_pos or 0
        span = Span(text, position, position + len(error.token))
        construct, todo = _REFUSED_WORDS[error.token]
        raise refused(span, f"'{error.token}', {construct}", todo) from None
    except UnexpectedInput as error:
        raise _syntax_error(text, error) from None
    except RecursionError:
        raise fault(text.whole, "This text is nested too deeply.") from None
