"""Conditions of queries: over data they are code, over clocks they stay symbolic.

In a discrete state a condition is a disjunction of cases, each a conjunction of clock constraints: a union of zones.
Negations are pushed down to where a constraint can be turned round.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from timed_automata.compiler import Bound, ClockConstraint, ClockSymbol, IndexedTerm, Relation
from timed_automata.document import fault, refused
from timed_automata.errors import ModelError
from timed_automata.language import ast, walk
from timed_automata.network import Network, State
from timed_automata.queries._query_names import ARGUMENTS, QueryExpressions, QueryScope

_OPPOSITE: dict[str, Relation] = {"<": ">=", "<=": ">", ">=": "<", ">": "<="}
_MIRRORED: dict[str, Relation] = {"<": ">", "<=": ">=", ">=": "<=", ">": "<", "==": "=="}


class Case(NamedTuple):
    """A conjunction: clock constraints, and whether the state must (not) be deadlocked (None: no matter)."""

    bounds: tuple[Bound, ...] = ()
    deadlock: bool | None = None


TRUE = Case()


@dataclass(frozen=True, slots=True)
class Data:
    """A condition without clocks."""

    holds: Callable[[tuple[int, ...], tuple[int, ...]], Any]
    source: str
    wanted: bool = True

    def cases(self, state: State) -> list[Case]:
        """True or nothing."""
        return [TRUE] if bool(self.holds(state.values, state.locations)) is self.wanted else []


@dataclass(frozen=True, slots=True)
class Comparison:
    """A clock against a number."""

    constraint: ClockConstraint

    def cases(self, state: State) -> list[Case]:
        """One constraint."""
        clock, bound = self.constraint.clock, self.constraint.bound
        number = clock if isinstance(clock, int) else clock(state.values, state.locations)  # type: ignore[call-arg]
        value = bound if isinstance(bound, int) else bound(state.values, state.locations)  # type: ignore[call-arg]
        return [Case((Bound(number, self.constraint.op, value),))]


@dataclass(frozen=True, slots=True)
class Deadlock:
    """The word ``deadlock``."""

    wanted: bool

    def cases(self, state: State) -> list[Case]:
        """One case, left to the search."""
        return [Case((), self.wanted)]


@dataclass(frozen=True, slots=True)
class All:
    """A conjunction; what follows a part that is false is not evaluated."""

    parts: tuple[Formula, ...]

    def cases(self, state: State) -> list[Case]:
        """The product of the cases of the parts."""
        cases = [TRUE]
        for part in self.parts:
            more = part.cases(state)
            cases = [
                joined for left in cases for right in more if (joined := _joined(left, right)) is not None
            ]
            if not cases:
                break
        return cases


@dataclass(frozen=True, slots=True)
class Some:
    """A disjunction; what follows a part that is true is not evaluated."""

    parts: tuple[Formula, ...]

    def cases(self, state: State) -> list[Case]:
        """The cases of all parts."""
        found: list[Case] = []
        for part in self.parts:
            cases = part.cases(state)
            if TRUE in cases:
                return [TRUE]
            found += cases
        return found


Formula = Data | Comparison | Deadlock | All | Some


def _joined(left: Case, right: Case) -> Case | None:
    if left.deadlock is not None and right.deadlock is not None and left.deadlock != right.deadlock:
        return None
    deadlock = left.deadlock if right.deadlock is None else right.deadlock
    return Case(left.bounds + right.bounds, deadlock)


def mentions_deadlock(formula: Formula) -> bool:
    """Whether a formula asks for deadlocks."""
    if isinstance(formula, All | Some):
        return any(map(mentions_deadlock, formula.parts))
    return isinstance(formula, Deadlock)


def compile_formula(network: Network, node: ast.Expression, *, negated: bool = False) -> Formula:
    """A condition of a query, or its negation.

    Raises:
        ModelError: not well-formed, or with clocks in a way that is outside of the subset.
    """
    return _Compiler(QueryExpressions(network.code, QueryScope(network))).formula(node, not negated)


def compile_without_deadlock(network: Network, node: ast.Expression, *, negated: bool = False) -> Formula:
    """A condition of a query in which the word ``deadlock`` is refused.

    Raises:
        ModelError: as :func:`compile_formula`, or it mentions deadlocks.
    """
    formula = compile_formula(network, node, negated=negated)
    if mentions_deadlock(formula):
        raise refused(node.span, f"'{node.span.snippet}', 'deadlock' outside of A[] and E<>")
    return formula


def compile_clock(network: Network, node: ast.Expression) -> int | None:
    """The number of the clock that an expression is; None if it is something else."""
    expressions = QueryExpressions(network.code, QueryScope(network))
    if not mentions_clock(expressions, node):
        return None
    term = _Compiler(expressions).clock(node)
    if term is None or term.computed:
        raise refused(
            node.span, f"'{node.span.snippet}', an expression with a clock", "Expected a clock alone."
        )
    return term.possible.start


def compile_integer(
    network: Network, node: ast.Expression
) -> Callable[[tuple[int, ...], tuple[int, ...]], int]:
    """An integer expression over values and locations."""
    expressions = QueryExpressions(network.code, QueryScope(network))
    function: Callable[..., int] = network.code.expression(ARGUMENTS, expressions.integer(node).source)
    return function


def mentions_clock(expressions: QueryExpressions, node: ast.Expression) -> bool:
    """Whether a clock occurs anywhere in an expression."""
    return any(_is_clock(expressions, each) for each in walk(node, into_members=False))


def _is_clock(expressions: QueryExpressions, node: ast.Node) -> bool:
    if isinstance(node, ast.Name):
        return isinstance(expressions.scope.find(node.name), ClockSymbol)
    if not isinstance(node, ast.Member):
        return False
    if isinstance(node.base, ast.Call):
        processes = [p for p in expressions.network.processes if p.name.startswith(f"{node.base.name}(")]
    else:
        processes = [expressions.process(node.base)]
    return any(isinstance(p.scope.symbols.get(node.name), ClockSymbol) for p in processes)


def _names_deadlock(node: ast.Expression) -> bool:
    return any(isinstance(each, ast.Name) and each.name == "deadlock" for each in walk(node))


class _Compiler:
    def __init__(self, expressions: QueryExpressions) -> None:
        self.expressions = expressions

    def formula(self, node: ast.Expression, wanted: bool) -> Formula:
        if not mentions_clock(self.expressions, node) and not _names_deadlock(node):
            return self._data(node, wanted)
        match node:
            case ast.Name(name="deadlock"):
                return Deadlock(wanted)
            case ast.Unary(op="!", operand=operand):
                return self.formula(operand, not wanted)
            case ast.Binary(op="&&" | "||" | "imply" as op, left=left, right=right):
                parts = (self.formula(left, wanted != (op == "imply")), self.formula(right, wanted))
                return (All if (op == "&&") == wanted else Some)(parts)
            case ast.Conditional(test=test, yes=yes, no=no):
                then = All((self.formula(test, True), self.formula(yes, wanted)))
                return Some((then, All((self.formula(test, False), self.formula(no, wanted)))))
            case ast.Quantified(kind="forall" | "exists" as kind):
                return self._quantified(node, kind, wanted)
            case ast.Binary(op="<" | "<=" | "==" | ">=" | ">" | "!="):
                return self._comparison(node, wanted)
        raise self._refusal(node)

    def _data(self, node: ast.Expression, wanted: bool) -> Formula:
        value = self.expressions.value(node)
        if self.expressions.effects.writes:
            changed = ", ".join(sorted(self.expressions.effects.writes))
            raise fault(node.span, f"The query '{node.span.snippet}' changes {changed}.")
        return Data(self.expressions.code.expression(ARGUMENTS, value.source), value.source, wanted)

    def _quantified(self, node: ast.Quantified, kind: str, wanted: bool) -> Formula:
        low, high = self.expressions.bounds(node.type)
        parts = []
        for number in range(low, high + 1):
            inner = self.expressions.binding(node.variable, number)
            parts.append(_Compiler(inner).formula(node.body, wanted))
        return (All if (kind == "forall") == wanted else Some)(tuple(parts))

    def _comparison(self, node: ast.Binary, wanted: bool) -> Formula:
        clock, op, other = self.clock(node.left), node.op, node.right
        if clock is None:
            clock, op, other = self.clock(node.right), _MIRRORED.get(node.op, node.op), node.left
        if clock is None or mentions_clock(self.expressions, other) or _names_deadlock(other):
            raise self._refusal(node)
        relation: list[Relation] = []
        if op in ("==", "!="):
            relation = ["=="] if (op == "==") == wanted else ["<", ">"]
        else:
            relation = [op if wanted else _OPPOSITE[op]]  # type: ignore[list-item]
        parts = tuple(Comparison(replace(self._constraint(node, clock, other), op=op)) for op in relation)
        return parts[0] if len(parts) == 1 else Some(parts)

    def _constraint(self, node: ast.Binary, clock: IndexedTerm, other: ast.Expression) -> ClockConstraint:
        value, code = self.expressions.integer(other), self.expressions.code
        return ClockConstraint(
            clock=code.expression(ARGUMENTS, clock.source) if clock.computed else clock.possible.start,
            op="==",
            bound=value.known if value.known is not None else code.expression(ARGUMENTS, value.source),
            clocks=clock.possible,
            low=value.low,
            high=value.high,
            span=node.span,
        )

    def clock(self, node: ast.Expression) -> IndexedTerm | None:
        """A clock, None if the expression is anything else."""
        base = node
        while isinstance(base, ast.Index):
            base = base.base
        if not isinstance(base, ast.Name | ast.Member) or not mentions_clock(self.expressions, base):
            return None
        term = self.expressions.term(node)
        if not isinstance(term, IndexedTerm) or term.type.dimensions:
            raise fault(node.span, f"'{node.span.snippet}' is an array of clocks.", "Expected an index.")
        return term

    def _refusal(self, node: ast.Expression) -> ModelError:
        both = [mentions_clock(self.expressions, side) for side in _boundary(node)]
        difference = any(isinstance(side, ast.Binary) and side.op == "-" for side in _boundary(node))
        snippet = f"'{node.span.snippet}'"
        if len(both) == 2 and (all(both) or difference):
            return refused(
                node.span, f"{snippet}, a diagonal constraint", "Compare each clock with a number."
            )
        if _names_deadlock(node):
            return refused(node.span, f"{snippet}, 'deadlock' in an expression", "Expected a condition.")
        return refused(node.span, f"{snippet}, a clock in an expression", "Compare clocks with numbers.")


def _boundary(node: ast.Expression) -> Iterator[ast.Expression]:
    if isinstance(node, ast.Binary):
        yield from (node.left, node.right)
