"""Names in queries: besides those of the network, what stands in a process: ``Gripper.Step``, ``Actuator(0).x``."""

from __future__ import annotations

from timed_automata import (
    Effects,
    Expressions,
    Network,
    Process,
    Scope,
    Term,
    Unit,
    Value,
    did_you_mean,
    fault,
    quantified,
    unrolled,
)
from timed_automata import _ast as ast

ARGUMENTS = "v, l, r=None"  # of compiled conditions: values, locations


class QueryScope(Scope):
    """The outermost scope of a query."""

    def __init__(self, network: Network) -> None:
        super().__init__(network.scope)
        self.network = network


class QueryExpressions(Expressions):
    """Compiles expressions of queries to code over values ``v`` and locations ``l``."""

    def __init__(self, unit: Unit, scope: Scope, effects: Effects | None = None) -> None:
        super().__init__(unit, scope, effects)
        outermost: Scope | None = scope
        while not isinstance(outermost, QueryScope):
            assert outermost is not None
            outermost = outermost.outer
        self.network = outermost.network

    def _member(self, node: ast.Member) -> Term:
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

    def process(self, node: ast.Expression) -> Process:
        """The process that stands before a dot."""
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
        if _mentions_process(node.body):  # which process must be known: written out
            return unrolled(self, node)
        return quantified(self, node)


def _mentions_process(node: object) -> bool:
    if isinstance(node, ast.Member):
        return True
    if isinstance(node, tuple):
        return any(map(_mentions_process, node))
    if isinstance(node, ast.Node):
        return any(_mentions_process(getattr(node, name)) for name in node.__dataclass_fields__)
    return False
