"""Splits model text into tokens, and names the words that UPPAAL reserves and this subset lacks."""

from __future__ import annotations

import re
from typing import NamedTuple

_FLOATING = (
    "fabs fmod fma fmax fmin fdim exp exp2 expm1 ln log log10 log2 log1p pow sqrt cbrt hypot sin cos tan asin acos atan"
    " atan2 sinh cosh tanh asinh acosh atanh erf erfc tgamma lgamma ceil floor trunc round fint ldexp ilogb logb"
    " nextafter copysign fpclassify isfinite isinf isnan isnormal signbit isunordered random random_arcsine random_beta"
    " random_gamma random_normal random_poisson random_tri random_weibull"
)
NO_NAMES = frozenset(
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
REFUSED_WORDS = {word: said for words, said in _REFUSED_BY_CONSTRUCT.items() for word in words.split()}
"""Words that UPPAAL reserves and this subset lacks: the construct that they belong to, and what to do instead."""

NAME, NUMBER, DOUBLE, END = "a name", "a number", "a floating-point number", "the end"
REFUSED, FOREIGN = "a refused word", "a foreign character"
"""Kinds of tokens with a name; that of a keyword or a symbol is itself, or the symbol that means the same."""
_KINDS = {"field": NAME, "number": NUMBER, "double": DOUBLE, "foreign": FOREIGN}
_KEYWORDS = frozenset(
    re.findall(
        r"\w+",
        "typedef const urgent broadcast meta int bool clock chan void scalar struct system if else for while do return"
        " true false forall exists sum imply",
    )
)
_SAME = {"and": "&&", "or": "||", "not": "!", ":=": "="}
_TOKEN = re.compile(
    r"""(?:\s|\\[ \t]*\r?\n|//[^\n]*|/\*[\s\S]*?\*/)*
    (?: (?P<field> (?<=\.)[A-Za-z_][A-Za-z0-9_]*)
      | (?P<word> [A-Za-z_][A-Za-z0-9_]*)
      | (?P<double> [0-9]+ (?: \.[0-9]*(?:[eE][-+]?[0-9]+)? | [eE][-+]?[0-9]+ ))
      | (?P<number> [0-9]+)
      | (?P<symbol> (?:<<|>>|[-+*/%&|^])= | [<>:=!]= | [<>]\? | << | >> | \|\| | && | \+\+ | --
          | [-+*/%<>=!?&|^'()\[\]{},;:.])
      | (?P<foreign> .)
      | \Z )""",
    re.VERBOSE,
)


class Token(NamedTuple):
    """A piece of a text, from character ``start`` to ``end``."""

    kind: str
    word: str
    start: int
    end: int


def tokens(content: str) -> list[Token]:
    """Return the tokens of a text without comments and blanks; the last is its end."""
    found = []
    for match in _TOKEN.finditer(content):
        group = match.lastgroup
        if group is None:
            break
        word = match[group]
        kind = _KINDS.get(group) or _SAME.get(word, word)
        if group == "word" and kind == word and word not in _KEYWORDS:
            kind = REFUSED if word in REFUSED_WORDS else NAME
        found.append(Token(kind, word, *match.span(group)))
    end = len(content.rstrip())
    return [*found, Token(END, "", end, end)]
