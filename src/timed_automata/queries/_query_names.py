"""Names in queries: those of the network, and what is declared in a process: ``Gripper.Step``, ``Actuator(0).x``."""

from __future__ import annotations

from collections.abc import Iterator

from timed_automata.compiler import Effects, Expressions, GeneratedCode, Scope, Term, Value
from timed_automata.document import did_you_mean, fault
from timed_automata.language import ast, walk
from timed_automata.network import Network, Process

ARGUMENTS = "v, l, r=None"  # of compiled conditions: values, locations


class QueryScope(Scope):
    """The outermost scope of a query."""

    def __init__(self, network: Network) -> None:
        super().__init__(network.scope)
        self.network = network


class QueryExpressions(Expressions):
    """Compiles expressions of queries to code over values ``v`` and locations ``l``."""

    def __init__(self, code: GeneratedCode, scope: Scope, effects: Effects | None = None) -> None:
        super().__init__(code, scope, effects)
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
        """The process before a dot."""
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
        if any(
            isinstance(each, ast.Member) for each in walk(node.body)
        ):  # which process must be known: written out
            return self._unrolled(node)
        return super()._quantified(node)


def location_of(network: Network, condition: ast.Expression | None) -> tuple[int, int] | None:
    """A location without which a condition does not hold; None if it names none."""
    expressions = QueryExpressions(network.code, QueryScope(network))
    for part in _conjuncts(condition):
        if isinstance(part, ast.Member):
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
