"""Evaluates a condition, and its parts, at an instant of a run."""

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
    """Evaluates expressions of a query at an instant and names their values.

    Args:
        network: the network of the run.
        names: names of values and elements.
        instant: an instant of the run.
        deadlock: the truth of the word ``deadlock`` at that instant.
    """

    def __init__(self, network: Network, names: Names, instant: Instant, *, deadlock: bool) -> None:
        self.network, self.names, self.instant, self.deadlock = network, names, instant, deadlock

    def holds(self, node: ast.Expression) -> bool:
        """Return whether a condition holds; False if it cannot be evaluated."""
        with suppress(RangeError):
            for case in compile_formula(self.network, node).cases(self.instant.state):
                if case.deadlock in (None, self.deadlock) and all(map(self._keeps, case.bounds)):
                    return True
        return False

    def _keeps(self, bound: Bound) -> bool:
        return bool(_HOLDS[bound.op](self.instant.clock(bound.clock), bound.value))

    def number(self, node: ast.Expression) -> int:
        """Return the value of an integer expression; raise RangeError for an index outside of its array."""
        state = self.instant.state
        return int(compile_integer(self.network, node)(state.values, state.locations))

    def clock(self, node: ast.Expression) -> int | None:
        """Return the number of the clock that an expression names, or None."""
        try:
            return compile_clock(self.network, node)
        except ModelError:
            return None

    def location(self, node: ast.Expression) -> tuple[int, str] | None:
        """Return the process index and the location name of ``Process.Location``, or None."""
        if isinstance(node, ast.Member) and (process := self._process(node)) is not None:
            for each in self.network.processes:
                if each.name == process and any(place.name == node.name for place in each.locations):
                    return each.index, node.name
        return None

    def variable(self, node: ast.Expression) -> str | None:
        """Return the variable that an expression refers to at this instant: ``ee``, ``Gripper.i``, ``evidence[1]``; or
        None.
        """
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
        """Return the variable or array that an index is applied to, with the indices so far; or None."""
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
        """Return what is before the dot: a process, or a structure."""
        match node.base:
            case ast.Member() | ast.Index():
                return self.variable_array(node.base)
            case ast.Name(name=name):
                return name
            case ast.Call(name=name, arguments=arguments):
                with suppress(RangeError, ModelError):
                    return f"{name}({','.join(str(self.number(each)) for each in arguments)})"
        return None

    def text(self, node: ast.Expression) -> str:
        """Return an expression as text with the names of elements: ``evidence[cups] == GONE``."""
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
        """Return the present value as text: a variable by its value's name, a clock as a time, a truth as true or
        false.
        """
        if (clock := self.clock(node)) is not None:
            return told_time(self.instant.clock(clock))
        if (variable := self.variable(node)) is not None:
            offset = self.network.offsets[variable]
            return self.names.value(variable, self.instant.state.values[offset])
        if self.location(node) is not None or isinstance(node, ast.Call):
            return "true" if self.holds(node) else "false"
        return str(self.number(node))

    def bound(self, node: ast.Expression) -> str:
        """Return the limit that a clock is compared with as text: its name, if it has one, and the time."""
        time = told_time(Fraction(self.number(node)))
        return time if number_of(node) is not None else f"{self.text(node)} ({time})"
