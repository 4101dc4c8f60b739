"""Compiles the conditions of queries; negations are pushed down to comparisons, which can be inverted.

Names in queries are those of the network, and those declared in a process: ``Gripper.Step``, ``Actuator(0).x``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from timed_automata.compiler import (
    CONTRARY,
    ClockSymbol,
    Expressions,
    Function,
    Scope,
    Term,
    Value,
    clock_constraint,
    clock_term,
)
from timed_automata.document import did_you_mean, fault, refused
from timed_automata.errors import ModelError
from timed_automata.language import ast
from timed_automata.network import Network, Process
from timed_automata.queries._formula import (
    ARGUMENTS,
    All,
    Comparison,
    Data,
    Deadlock,
    Formula,
    Some,
    mentions_deadlock,
)


def compile_formula(network: Network, node: ast.Expression, *, negated: bool = False) -> Formula:
    """Compile a condition of a query, or its negation.

    Raises:
        ModelError: the condition is not well-formed, or uses clocks in a way that is outside of the subset.
    """
    known, key = network.code.formulas, (node, negated)
    if key not in known:
        known[key] = _QueryExpressions(network).formula(node, not negated)
    formula: Formula = known[key]
    return formula


def compile_without_deadlock(network: Network, node: ast.Expression, *, negated: bool = False) -> Formula:
    """Compile a condition of a query in which the word ``deadlock`` is refused.

    Raises:
        ModelError: as :func:`compile_formula`, or it mentions deadlocks.
    """
    formula = compile_formula(network, node, negated=negated)
    if mentions_deadlock(formula):
        raise refused(
            node.span, f"'{node.span.snippet}', 'deadlock' outside of A[] and E<>", "Ask 'A[] not deadlock'."
        )
    return formula


def compile_clock(network: Network, node: ast.Expression) -> int | None:
    """Return the number of the clock that an expression names, or None if it is something else."""
    expressions = _QueryExpressions(network)
    if not expressions.mentions_clock(node):
        return None
    term = clock_term(expressions, node)
    if term is None or term.computed:
        raise refused(
            node.span, f"'{node.span.snippet}', an expression with a clock", "Expected a clock alone."
        )
    return term.possible.start


def compile_integer(network: Network, node: ast.Expression) -> Callable[..., Any]:
    """Compile an integer expression to a function of values and locations."""
    expressions = _QueryExpressions(network)
    return expressions.function_of(expressions.integer(node).source)


def bounds_of(network: Network, type_: ast.TypeName) -> tuple[int, int]:
    """Return both ends, included, of the range of a quantifier in a query."""
    return _QueryExpressions(network).bounds(type_)


def called(network: Network, node: ast.Call) -> Function:
    """Return the function that a query calls, of the network or of a process."""
    return _QueryExpressions(network).function(node)


def location_of(network: Network, condition: ast.Expression | None) -> tuple[int, int] | None:
    """Return process and location that a condition requires, or None if it names none."""
    expressions = _QueryExpressions(network)
    for part in _conjuncts(condition):
        if isinstance(part, ast.Member) and expressions.of_process(part):
            process = expressions.process(part.base)
            for location in process.locations:
                if location.name == part.name:
                    return process.index, location.index
    return None


def _conjuncts(node: ast.Expression | None) -> Iterator[ast.Expression]:
    if isinstance(node, ast.Binary) and node.op == "&&":
        yield from _conjuncts(node.left)
        yield from _conjuncts(node.right)
    elif node is not None:
        yield node


class _QueryExpressions(Expressions):
    """Compiles expressions of queries to code over values ``v`` and locations ``l``."""

    arguments = ARGUMENTS

    def __init__(self, network: Network) -> None:
        super().__init__(network.code, Scope(network.scope))
        self.network = network

    def of_process(self, node: ast.Member) -> bool:
        """Return whether the name after the dot belongs to a process; else it is a field of a structure."""
        match node.base:
            case ast.Name(name=name):
                return self.scope.find(name) is None or any(
                    each.name == name for each in self.network.processes
                )
            case ast.Call(name=name, process=None):
                return not isinstance(self.scope.find(name), Function)
        return False

    def _member(self, node: ast.Member) -> Term:
        if not self.of_process(node):
            return super()._member(node)
        process = self.process(node.base)
        for location in process.locations:
            if location.name == node.name:
                return Value(f"(l[{process.index}] == {location.index})", 0, 1, truth=True)
        symbol = process.scope.symbols.get(node.name)
        if symbol is None:
            known = [*(location.name for location in process.locations), *process.scope.symbols]
            advice = did_you_mean(node.name, known)
            raise fault(node.span, f"'{process.name}' has no location and no variable '{node.name}'.", advice)
        return self.symbol(symbol, node.span)

    def function(self, node: ast.Call) -> Function:
        """Return the function that is called; it may belong to a process."""
        if node.process is None:
            return super().function(node)
        process = self.process(node.process)
        symbol = process.scope.symbols.get(node.name)
        if not isinstance(symbol, Function):
            advice = did_you_mean(node.name, process.scope.symbols.keys() - {node.name})
            raise fault(node.span, f"'{process.name}' has no function '{node.name}'.", advice)
        return symbol

    def process(self, node: ast.Expression) -> Process:
        """Return the process before a dot."""
        name = node.span.snippet
        if isinstance(node, ast.Name):
            name = node.name
        elif isinstance(node, ast.Call):
            values = [str(self.constant(argument, "An argument of a process")) for argument in node.arguments]
            name = f"{node.name}({','.join(values)})"
        for process in self.network.processes:
            if process.name == name:
                return process
        names = [process.name for process in self.network.processes]
        advice = (
            did_you_mean(name, names) or f"There are {', '.join(names[:8])}{' …' if len(names) > 8 else ''}."
        )
        raise fault(node.span, f"There is no process '{name}'.", advice)

    def _quantified(self, node: ast.Quantified) -> Value:
        inside = ast.walk(node.body)
        if any(isinstance(each, ast.Member) or getattr(each, "process", None) for each in inside):
            return self._unrolled(node)  # which process must be known
        return super()._quantified(node)

    def is_clock(self, node: ast.Node) -> bool:
        """Return whether the node names a clock or an array of clocks; it may belong to a process."""
        if not isinstance(node, ast.Member) or not self.of_process(node):
            return super().is_clock(node)
        if isinstance(node.base, ast.Call):
            processes = [p for p in self.network.processes if p.name.startswith(f"{node.base.name}(")]
        else:
            processes = [self.process(node.base)]
        return any(isinstance(p.scope.symbols.get(node.name), ClockSymbol) for p in processes)

    def formula(self, node: ast.Expression, wanted: bool) -> Formula:
        """Compile a condition, or its negation if ``wanted`` is false."""
        if not self.mentions_clock(node) and not _names_deadlock(node):
            return self._data(node, wanted)
        match node:
            case ast.Name(name="deadlock"):
                return Deadlock(wanted)
            case ast.Unary(op="!", operand=operand):
                return self.formula(operand, not wanted)
            case ast.Binary(op="&&" | "||" | "imply" as op, left=left, right=right):
                parts = (self.formula(left, wanted != (op == "imply")), self.formula(right, wanted))
                return _joined(All if (op == "&&") == wanted else Some, parts)
            case ast.Conditional(test=test, yes=yes, no=no):
                then = _joined(All, (self.formula(test, True), self.formula(yes, wanted)))
                other = _joined(All, (self.formula(test, False), self.formula(no, wanted)))
                return _joined(Some, (then, other))
            case ast.Quantified(kind="forall" | "exists" as kind):
                return self._each(node, kind, wanted)
            case ast.Binary(op="<" | "<=" | "==" | ">=" | ">" | "!="):
                return self._compared(node, wanted)
        raise self._refusal(node)

    def _data(self, node: ast.Expression, wanted: bool) -> Formula:
        value = self.value(node)
        if self.effects.writes:
            changed = ", ".join(sorted(self.effects.writes))
            raise fault(node.span, f"The query '{node.span.snippet}' changes {changed}.")
        known = None if value.known is None else bool(value.known) is wanted
        return Data(self.function_of(value.source), value.source, wanted, known)

    def _each(self, node: ast.Quantified, kind: str, wanted: bool) -> Formula:
        low, high = self.bounds(node.type)
        numbers = range(low, high + 1)
        parts = tuple(self.binding(node.variable, number).formula(node.body, wanted) for number in numbers)
        return (All if (kind == "forall") == wanted else Some)(parts)

    def _compared(self, node: ast.Binary, wanted: bool) -> Formula:
        if node.op == "!=":
            return self._compared(replace(node, op="=="), not wanted)
        constraint = None if _names_deadlock(node) else clock_constraint(self, node)
        if constraint is None:
            raise self._refusal(node)
        relations = (constraint.op,) if wanted else CONTRARY[constraint.op]
        parts = tuple(Comparison(replace(constraint, op=op)) for op in relations)
        return parts[0] if len(parts) == 1 else Some(parts)

    def _refusal(self, node: ast.Expression) -> ModelError:
        sides = (node.left, node.right) if isinstance(node, ast.Binary) else ()
        both = bool(sides) and all(map(self.mentions_clock, sides))
        difference = any(isinstance(side, ast.Binary) and side.op == "-" for side in sides)
        snippet = f"'{node.span.snippet}'"
        if both or difference:
            return refused(
                node.span, f"{snippet}, a diagonal constraint", "Compare each clock with a number."
            )
        if _names_deadlock(node):
            return refused(node.span, f"{snippet}, 'deadlock' in an expression", "Expected a condition.")
        return refused(node.span, f"{snippet}, a clock in an expression", "Compare clocks with numbers.")


def _joined(join: type[All | Some], parts: tuple[Formula, ...]) -> Formula:
    """Join formulas without those that constants decide, so that the clocks in these need not be tracked."""
    decides = join is Some
    open_ = tuple(part for part in parts if not isinstance(part, Data) or part.known in (None, decides))
    decided = next((part for part in open_ if isinstance(part, Data) and part.known is not None), None)
    return decided or (join(open_) if len(open_) > 1 else (*open_, *parts)[0])


def _names_deadlock(node: ast.Expression) -> bool:
    return any(isinstance(each, ast.Name) and each.name == "deadlock" for each in ast.walk(node))
