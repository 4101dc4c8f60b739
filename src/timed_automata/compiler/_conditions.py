"""Compiles guards and invariants, split into data conditions and clock constraints.

Clock constraints stay symbolic, so that the same evaluation serves instants and zones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, NoReturn

from timed_automata.compiler._expressions import Expressions
from timed_automata.compiler._values import COMPARISONS, IndexedTerm, StorageTerm, Value
from timed_automata.document import Span, fault, refused
from timed_automata.language import ast

Values = Sequence[int]
Quantity = int | Callable[..., int]  # a number, or a function of the discrete state
Relation = Literal["<", "<=", "==", ">=", ">"]
CONTRARY: dict[Relation, tuple[Relation, ...]] = {
    "<": (">=",),
    "<=": (">",),
    "==": ("<", ">"),
    ">=": ("<",),
    ">": ("<=",),
}
"""The relations of which one holds, and only one, where a relation does not."""


class Bound(NamedTuple):
    """A clock constraint in one discrete state: ``clock op value``, in the model's unit of time."""

    clock: int
    op: Relation
    value: int

    @property
    def lower(self) -> bool:
        """Whether the constraint is a lower bound only."""
        return self.op in (">", ">=")

    def allows(self, value: int) -> bool:
        """Return whether a value of the clock satisfies the constraint."""
        return COMPARISONS[self.op](value, self.value)

    @property
    def contrary(self) -> tuple[Bound, ...]:
        """The constraints of which one holds, and only one, where this one does not."""
        return tuple([self._replace(op=op) for op in CONTRARY[self.op]])


@dataclass(frozen=True, slots=True, eq=False)
class ClockConstraint:
    """A constraint ``clock op bound``; both sides may depend on the discrete state.

    Attributes:
        clock: number of the clock, or a function of the values.
        bound: a number, or a function of the values.
        clocks: all clocks that ``clock`` can be.
        low, high: interval in which the bound always lies.
    """

    clock: Quantity
    op: Relation
    bound: Quantity
    clocks: range
    low: int
    high: int
    span: Span

    @property
    def fixed(self) -> Bound | None:
        """The constraint if it is the same in all states, else None."""
        if isinstance(self.clock, int) and isinstance(self.bound, int):
            return Bound(self.clock, self.op, self.bound)
        return None

    def at(self, *state: Values) -> Bound:
        """Return the constraint in a discrete state: its values, and for a query its locations."""
        clock, bound = self.clock, self.bound
        return Bound(
            clock if isinstance(clock, int) else clock(*state),
            self.op,
            bound if isinstance(bound, int) else bound(*state),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Condition:
    """A guard or an invariant: a condition on data and a conjunction of clock constraints.

    Attributes:
        data: function that returns whether the part without clocks holds; None if that part always holds.
        never: the part without clocks is constant and false.
        clocks: clock constraints, to be evaluated only where ``data`` holds.
        needed: pairs of the offset of a value and the number that this value must have for ``data`` to hold; only
            comparisons that are evaluated before anything that can fail.
    """

    data: Callable[[Values], Any] | None = None
    never: bool = False
    clocks: tuple[ClockConstraint, ...] = ()
    needed: tuple[tuple[int, int], ...] = ()

    def holds(self, values: Values) -> bool:
        """Return whether the part without clocks holds."""
        return not self.never and (self.data is None or bool(self.data(values)))


_RELATIONS: dict[str, Relation] = {"<": "<", "<=": "<=", "==": "==", ">=": ">=", ">": ">"}
_FLIPPED: dict[str, Relation] = {"<": ">", "<=": ">=", "==": "==", ">=": "<=", ">": "<"}

Part = tuple[Expressions, ast.Expression]


def _parts(expressions: Expressions, node: ast.Expression) -> Iterator[Part]:
    """Yield the parts of a conjunction with their scopes; forall over clocks is unrolled."""
    if isinstance(node, ast.Binary) and node.op == "&&":
        yield from _parts(expressions, node.left)
        yield from _parts(expressions, node.right)
    elif isinstance(node, ast.Quantified) and node.kind == "forall" and expressions.mentions_clock(node):
        low, high = expressions.bounds(node.type)
        for value in range(low, high + 1):
            yield from _parts(expressions.binding(node.variable, value), node.body)
    else:
        yield expressions, node


def _refuse(expressions: Expressions, node: ast.Expression) -> NoReturn:
    """Raise the error that explains why a clock is not allowed here."""
    todo = "Expected a conjunction of 'clock <= number' and conditions without clocks."
    match node:
        case ast.Binary(op="||" | "imply"):
            construct = "a disjunction over clocks"
        case ast.Binary(op="!="):
            construct = "'!=' on a clock"
        case ast.Binary(op="<" | "<=" | "==" | ">=" | ">", left=left, right=right):
            both = expressions.mentions_clock(left) and expressions.mentions_clock(right)
            difference = any(isinstance(side, ast.Binary) and side.op == "-" for side in (left, right))
            construct = "a diagonal constraint" if both or difference else "arithmetic with a clock"
            todo = "Compare each clock with a number." if both or difference else todo
        case ast.Conditional():
            construct = "a clock in '?:'"
        case ast.Unary(op="!"):
            construct = "the negation of a clock constraint"
        case ast.Quantified():
            construct = f"'{node.kind}' over clock constraints"
        case _:
            construct = "a clock in an expression over data"
    raise refused(node.span, f"'{node.span.snippet}', {construct}", todo)


def clock_term(expressions: Expressions, node: ast.Expression) -> IndexedTerm | None:
    """Return the single clock that the expression names, or None if it is something else."""
    base = node
    while isinstance(base, ast.Index):
        base = base.base
    if not expressions.is_clock(base):
        return None
    term = expressions.term(node)
    if not isinstance(term, IndexedTerm) or term.type.dimensions:
        raise fault(node.span, f"'{node.span.snippet}' is an array of clocks.", "Expected an index.")
    return term


def clock_constraint(expressions: Expressions, node: ast.Expression) -> ClockConstraint | None:
    """Return the comparison of a clock with a number, or None if the expression is something else."""
    if not isinstance(node, ast.Binary) or node.op not in _RELATIONS:
        return None
    term, op, bound = clock_term(expressions, node.left), _RELATIONS[node.op], node.right
    if term is None:
        term, op, bound = clock_term(expressions, node.right), _FLIPPED[node.op], node.left
    if term is None or expressions.mentions_clock(bound):
        return None
    expressions.effects.reads.add(term.name)
    value = expressions.integer(bound)
    return ClockConstraint(
        clock=number_of(expressions, term),
        op=op,
        bound=value.known if value.known is not None else expressions.function_of(value.source),
        clocks=term.possible,
        low=value.low,
        high=value.high,
        span=node.span,
    )


def number_of(expressions: Expressions, term: IndexedTerm) -> Quantity:
    """Return the number of a clock or a channel, or a function that computes it."""
    return expressions.function_of(term.source) if term.computed else term.possible.start


def compile_condition(expressions: Expressions, node: ast.Expression, what: str) -> Condition:
    """Compile a guard or an invariant.

    Raises:
        ModelError: the condition has a side effect, or uses clocks in a way that is outside of the subset.
    """
    clocks: list[ClockConstraint] = []
    data: list[str] = []
    needed: list[tuple[int, int]] = []
    never = may_fail = False
    for inner, part in _parts(expressions, node):
        if inner.mentions_clock(part):
            clocks.append(clock_constraint(inner, part) or _refuse(inner, part))
            continue
        value = inner.value(part)
        plain = _plain(inner, part)
        may_fail = may_fail or plain is None
        needed += plain if plain and not may_fail else ()
        if value.known is None:
            data.append(value.source)
        never = never or value.known == 0
    if expressions.effects.writes:
        changed = ", ".join(sorted(expressions.effects.writes))
        raise fault(node.span, f"The {what} '{node.span.snippet}' changes {changed}.")
    function = expressions.function_of(" and ".join(data)) if data else None
    return Condition(function, never, tuple(clocks), tuple(needed))


def _plain(expressions: Expressions, node: ast.Expression) -> list[tuple[int, int]] | None:
    """Return offset and value that a comparison of a variable with a number requires; None for other expressions."""
    if not isinstance(node, ast.Binary) or node.op not in COMPARISONS:
        return None
    offsets, numbers = [], []
    for side in (node.left, node.right):
        term = expressions.term(side)
        if isinstance(term, Value) and term.known is not None:
            numbers.append(term.known)
        elif isinstance(term, StorageTerm) and term.start.isdigit() and term.type.single:
            if term.values is not None or not term.storage.shared:
                return None
            offsets.append(int(term.start))
        else:
            return None
    return [(offsets[0], numbers[0])] if node.op == "==" and len(offsets) == len(numbers) else []
