"""What a condition, and each part of it, is at an instant of a run."""

from __future__ import annotations

from contextlib import suppress
from fractions import Fraction
from operator import eq, ge, gt, le, lt

from timed_automata.compiler import Bound
from timed_automata.errors import ModelError, RangeError
from timed_automata.explain._names import Names
from timed_automata.explain._run import Instant, told_time
from timed_automata.explain._syntax import number_of, written
from timed_automata.language import ast
from timed_automata.network import Network
from timed_automata.queries import compile_clock, compile_formula, compile_integer

_HOLDS = {"<": lt, "<=": le, "==": eq, ">=": ge, ">": gt}


class Judge:
    """Evaluates expressions of a query at an instant, and gives the names in them.

    Args:
        network: of the run.
        names: of values and elements.
        instant: of the run.
        deadlock: what the word ``deadlock`` is there.
    """

    def __init__(self, network: Network, names: Names, instant: Instant, *, deadlock: bool) -> None:
        self.network, self.names, self.instant, self.deadlock = network, names, instant, deadlock

    def holds(self, node: ast.Expression) -> bool:
        """Whether a condition holds; False where it cannot be evaluated."""
        with suppress(RangeError):
            for case in compile_formula(self.network, node).cases(self.instant.state):
                if case.deadlock in (None, self.deadlock) and all(map(self._keeps, case.bounds)):
                    return True
        return False

    def _keeps(self, bound: Bound) -> bool:
        return bool(_HOLDS[bound.op](self.instant.clock(bound.clock), bound.value))

    def number(self, node: ast.Expression) -> int:
        """An integer expression; raises RangeError where it leaves an array."""
        state = self.instant.state
        return int(compile_integer(self.network, node)(state.values, state.locations))

    def clock(self, node: ast.Expression) -> int | None:
        """The number of the clock that an expression names."""
        try:
            return compile_clock(self.network, node)
        except ModelError:
            return None

    def location(self, node: ast.Expression) -> tuple[int, str] | None:
        """The process and the location of ``Process.Location``."""
        if isinstance(node, ast.Member) and (process := self._process(node)) is not None:
            for each in self.network.processes:
                if each.name == process and any(place.name == node.name for place in each.locations):
                    return each.index, node.name
        return None

    def variable(self, node: ast.Expression) -> str | None:
        """The variable that an expression is now: ``ee``, ``Gripper.i``, ``evidence[1]``."""
        match node:
            case ast.Name(name=name):
                found: str | None = name
            case ast.Member(name=name):
                process = self._process(node)
                found = None if process is None else f"{process}.{name}"
            case ast.Index(base=base, index=index):
                inner = self.variable_array(base)
                found = None
                with suppress(RangeError, ModelError):
                    found = None if inner is None else f"{inner}[{self.number(index)}]"
            case _:
                found = None
        return found if found in self.network.offsets else None

    def variable_array(self, node: ast.Expression) -> str | None:
        """The same of what an index follows, as far as it goes."""
        match node:
            case ast.Name(name=name):
                return name
            case ast.Member(name=name):
                process = self._process(node)
                return None if process is None else f"{process}.{name}"
            case ast.Index(base=base, index=index):
                inner = self.variable_array(base)
                with suppress(RangeError, ModelError):
                    return None if inner is None else f"{inner}[{self.number(index)}]"
        return None

    def _process(self, node: ast.Member) -> str | None:
        match node.base:
            case ast.Name(name=name):
                return name
            case ast.Call(name=name, arguments=arguments):
                with suppress(RangeError, ModelError):
                    return f"{name}({','.join(str(self.number(each)) for each in arguments)})"
        return None

    def text(self, node: ast.Expression) -> str:
        """An expression with the names of elements: ``evidence[cups] == GONE``."""
        return written(node, self._atom)

    def _atom(self, node: ast.Expression) -> str | None:
        if (value := number_of(node)) is not None:
            return str(value)
        if (place := self.location(node)) is not None:
            return f"{self.names.element(self.network.processes[place[0]].name)}.{place[1]}"
        if isinstance(node, ast.Index | ast.Member | ast.Name):
            name = self.variable(node) or self.variable_array(node)
            return None if name is None else self.names.element(name)
        return None

    def shown(self, node: ast.Expression) -> str:
        """What an expression is now: the value of a variable by its name, a clock as a time, a truth as a word."""
        if (clock := self.clock(node)) is not None:
            return told_time(self.instant.clock(clock))
        if (variable := self.variable(node)) is not None:
            offset = self.network.offsets[variable]
            return self.names.value(variable, self.instant.state.values[offset])
        if self.location(node) is not None or isinstance(node, ast.Call):
            return "true" if self.holds(node) else "false"
        return str(self.number(node))

    def bound(self, node: ast.Expression) -> str:
        """What a clock is compared with: its name, if it has one, and the time."""
        time = told_time(Fraction(self.number(node)))
        return time if number_of(node) is not None else f"{self.text(node)} ({time})"
