"""The syntax tree of UPPAAL's language: expressions, declarations, statements; data only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from timed_automata.document import Span


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """Base class of everything that is read from a text."""

    span: Span


# Expressions -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Number(Node):
    """A literal; ``boolean`` is true for true and false."""

    value: int
    boolean: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Name(Node):
    """The use of a name."""

    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Index(Node):
    """``base[index]``."""

    base: Expression
    index: Expression


@dataclass(frozen=True, slots=True, eq=False)
class Member(Node):
    """``structure.field``, or in queries ``process.name``."""

    base: Expression
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Call(Node):
    """``name(arguments)``, or in queries ``process.name(arguments)``."""

    name: str
    arguments: tuple[Expression, ...]
    process: Expression | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Unary(Node):
    """One of the operators ``-``, ``+`` and ``!`` with its operand."""

    op: str
    operand: Expression


@dataclass(frozen=True, slots=True, eq=False)
class Binary(Node):
    """An operator with two operands; ``and`` and ``or`` are read as ``&&`` and ``||``."""

    left: Expression
    op: str
    right: Expression


@dataclass(frozen=True, slots=True, eq=False)
class Conditional(Node):
    """``test ? yes : no``."""

    test: Expression
    yes: Expression
    no: Expression


@dataclass(frozen=True, slots=True, eq=False)
class Quantified(Node):
    """``forall``, ``exists`` or ``sum`` over a bounded type."""

    kind: str
    variable: str
    type: TypeName
    body: Expression


@dataclass(frozen=True, slots=True, eq=False)
class Assignment(Node):
    """``target op value``; op is ``=``, ``+=``, …"""

    target: Expression
    op: str
    value: Expression


@dataclass(frozen=True, slots=True, eq=False)
class Increment(Node):
    """``++`` or ``--``; if ``before``, the value of the expression is the new value."""

    op: str
    target: Expression
    before: bool


@dataclass(frozen=True, slots=True, eq=False)
class Braces(Node):
    """``{a, b, …}``: the initialiser of an array or a structure; ``names`` are those of fields before ``:``."""

    items: tuple[Expression, ...]
    names: tuple[str | None, ...] = ()


Expression = (
    Number
    | Name
    | Index
    | Member
    | Call
    | Unary
    | Binary
    | Conditional
    | Quantified
    | Assignment
    | Increment
    | Braces
)

# Declarations ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class TypeName(Node):
    """A type as written: prefixes, base name, the bounds of a bounded int (``high`` alone is the size of a scalar
    set), and the fields of a structure.
    """

    base: str
    prefixes: frozenset[str] = frozenset()
    low: Expression | None = None
    high: Expression | None = None
    fields: tuple[Variables, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Declarator(Node):
    """A declared name with its array dimensions (expressions or bounded types) and its initialiser."""

    name: str
    dimensions: tuple[Expression | TypeName, ...] = ()
    initialiser: Expression | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Variables(Node):
    """``type a, b[3] = {…};``"""

    type: TypeName
    declarators: tuple[Declarator, ...]


@dataclass(frozen=True, slots=True, eq=False)
class TypeDefinition(Node):
    """``typedef type a;``"""

    type: TypeName
    declarators: tuple[Declarator, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Parameter(Node):
    """A parameter of a template, a partial instantiation or a function."""

    type: TypeName
    reference: bool
    declarator: Declarator


@dataclass(frozen=True, slots=True, eq=False)
class FunctionDefinition(Node):
    """The definition of a function."""

    result: TypeName
    name: str
    parameters: tuple[Parameter, ...]
    body: Block


Declaration = Variables | TypeDefinition | FunctionDefinition


@dataclass(frozen=True, slots=True, eq=False)
class Instantiation(Node):
    """``name(parameters) = template(arguments);``"""

    name: str
    parameters: tuple[Parameter, ...]
    template: Name
    arguments: tuple[Expression, ...]


@dataclass(frozen=True, slots=True, eq=False)
class System(Node):
    """The system section: declarations, instantiations, and the names of the ``system`` line."""

    items: tuple[Declaration | Instantiation, ...]
    processes: tuple[Name, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Select(Node):
    """``name : type`` of a select label."""

    name: str
    type: TypeName


@dataclass(frozen=True, slots=True, eq=False)
class Synchronisation(Node):
    """``channel!`` or ``channel?``."""

    channel: Expression
    direction: str


# Statements ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Block(Node):
    """``{ declarations statements }``."""

    declarations: tuple[Declaration, ...]
    statements: tuple[Statement, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Evaluate(Node):
    """An expression as a statement; None for a lone semicolon."""

    expression: Expression | None


@dataclass(frozen=True, slots=True, eq=False)
class If(Node):
    """``if (test) yes else no``."""

    test: Expression
    yes: Statement
    no: Statement | None


@dataclass(frozen=True, slots=True, eq=False)
class For(Node):
    """``for (first; test; then) body``; a ``while`` loop has no first and no then."""

    first: tuple[Expression, ...]
    test: Expression | None
    then: tuple[Expression, ...]
    body: Statement


@dataclass(frozen=True, slots=True, eq=False)
class DoWhile(Node):
    """``do body while (test);``"""

    body: Statement
    test: Expression


@dataclass(frozen=True, slots=True, eq=False)
class Iterate(Node):
    """``for (variable : type) body``."""

    variable: str
    type: TypeName
    body: Statement


@dataclass(frozen=True, slots=True, eq=False)
class Return(Node):
    """``return value;``"""

    value: Expression | None


Statement = Block | Evaluate | If | For | DoWhile | Iterate | Return


def walk(node: object) -> Iterator[Node]:
    """Yield a node and all nodes inside it, except the process before the dot of a call."""
    waiting = [node]
    while waiting:
        each = waiting.pop()
        if isinstance(each, tuple):
            waiting += reversed(each)
        elif isinstance(each, Node):
            yield each
            kind = type(each)
            names = _INSIDE.get(kind)
            if names is None:
                fields = reversed(kind.__dataclass_fields__)
                names = _INSIDE[kind] = tuple(name for name in fields if name not in ("span", "process"))
            waiting += [getattr(each, name) for name in names]


_INSIDE: dict[type[Node], tuple[str, ...]] = {}
"""By kind of node, the attributes that `walk` looks into, the last first."""


def path(node: object) -> str | None:
    """Return a variable with its fields, without indices: ``s.a`` for ``s[i].a``; None for other expressions."""
    match node:
        case Name(name=name):
            return name
        case Index(base=base):
            return path(base)
        case Member(base=base, name=name):
            return None if (before := path(base)) is None else f"{before}.{name}"
    return None


def changed(node: object) -> set[str]:
    """Return the paths that assignments in an expression change, without what called functions change."""
    targets = (path(each.target) for each in walk(node) if isinstance(each, Assignment | Increment))
    return {target for target in targets if target is not None}


def paths(node: object) -> Iterator[str]:
    """Yield the paths of all variables in an expression."""
    if (whole := path(node)) is not None:
        yield whole
        while isinstance(node, Index | Member):
            if isinstance(node, Index):
                yield from paths(node.index)
            node = node.base
    elif isinstance(node, tuple):
        for item in node:
            yield from paths(item)
    elif isinstance(node, Node):
        for name in node.__dataclass_fields__:
            yield from paths(getattr(node, name))
