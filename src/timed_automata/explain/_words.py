"""Puts a condition at an instant into words: the facts that make it hold, or the part that is violated."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from timed_automata.compiler import ClockSymbol, Storage
from timed_automata.explain._judge import Judge
from timed_automata.explain._run import listed
from timed_automata.explain._syntax import instance, number_of, parts_of, returned
from timed_automata.language import ast
from timed_automata.queries import bounds_of

_MOST, _MOST_FACTS = 3, 8  # parts that are told, and facts
_LESS = {"<": "less than", "<=": "at most", ">": "more than", ">=": "at least"}
_CONTRARY = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_FLIPPED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}

_STATE = (Storage, ClockSymbol)
_Part = tuple[ast.Expression, bool]
"""A part of a condition, and whether it must hold."""


class Words:
    """Puts a query's condition into words; see `facts` and `fault`.

    Attributes:
        wrong: the violated parts of all conditions explained so far.
    """

    def __init__(self, judge: Judge) -> None:
        self.judge = judge
        self.wrong: list[ast.Expression] = []

    def facts(self, node: ast.Expression, wanted: bool = True) -> list[str]:
        """Return the facts that make a condition hold (``wanted`` False: fail), as clauses: ``Gripper is in Step``."""
        return self._all_facts([(node, wanted)])

    def _all_facts(self, parts: Sequence[_Part]) -> list[str]:
        """Return the facts of several conditions; elements with the same fact share one clause."""
        told: dict[tuple[str, str], dict[str, None]] = {}
        for part, want in parts:
            for leaf, holds in self._reasons(part, want):
                for subject, what in self._fact(leaf, holds):
                    alike = subject.partition("[")[0]
                    told.setdefault((alike, what), {})[subject] = None
        return [_together(list(found), what) for (_, what), found in told.items()]

    def fault(self, node: ast.Expression, wanted: bool = True) -> str:
        """Explain why a condition is violated (``wanted`` False: why it holds): the required and the actual state."""
        facts, then = self.parted(node, wanted)
        return f"as {listed(facts, _MOST_FACTS)}, {then}" if facts else then

    def parted(self, node: ast.Expression, wanted: bool = True) -> tuple[list[str], str]:
        """Return the explanation of `fault` in two parts: the premises that hold, and the requirement that is
        violated.
        """
        match node:
            case ast.Unary(op="!", operand=operand):
                return self.parted(operand, not wanted)
            case ast.Conditional(test=test, yes=yes, no=no):
                return self.parted(yes if self.judge.holds(test) else no, wanted)
            case ast.Call(name=name) if (inner := self._inner(node)) is not None:
                if not (known := self.facts(inner, not wanted)):  # it asks for nothing that moves
                    self.wrong.append(node)
                    return [], self._leaf_fault(node, wanted)
                self._blame([(inner, wanted)])
                facts = listed(known, _MOST_FACTS)
                return [], f"{name}() must {'' if wanted else 'not '}hold, but {facts}"
        parts, all_of = self._parts(node, wanted)
        if parts is None:
            self.wrong.append(node)
            return [], self._leaf_fault(node, wanted)
        broken = [
            (part, want) for part, want in parts if self._moving(part) and self.judge.holds(part) is not want
        ]
        if not all_of:
            return self._none_of(broken)
        if len(broken) == 1:
            return self.parted(*broken[0])
        told = [self.fault(part, want) for part, want in broken[:_MOST]]
        more = len(broken) - len(told)
        return [], "; ".join(told) + (f"; and {more} more" if more else "")

    def _none_of(self, broken: list[_Part]) -> tuple[list[str], str]:
        """Explain a violated disjunction; parts that only restrict the case in which the others count come first."""
        where = [(part, want) for part, want in broken if _is_premise(part, want)]
        rest = [each for each in broken if each not in where]
        if not rest:
            self._blame(broken)
            facts = self._all_facts([(part, not want) for part, want in broken])
            if not facts:
                return [], "no part of it can hold with these constants"
            return [], f"these must not all hold together: {listed(facts, _MOST_FACTS)}"
        before = self._all_facts([(part, not want) for part, want in where])
        if len(rest) == 1:
            facts, then = self.parted(*rest[0])
            return [*before, *facts], then
        self._blame(rest)
        wishes = listed([self._wish(part, want) for part, want in rest], _MOST_FACTS, "or")
        facts = self._all_facts([(part, not want) for part, want in rest])
        return before, f"one of these must hold: {wishes}; but {listed(facts, _MOST_FACTS)}"

    def _blame(self, broken: Sequence[_Part]) -> None:
        self.wrong += [leaf for part, want in broken for leaf, _ in self._reasons(part, not want)]

    def _inner(self, node: ast.Call) -> ast.Expression | None:
        return None if node.process else returned(self.judge.names.text.functions.get(node.name))

    def _parts(self, node: ast.Expression, wanted: bool) -> tuple[list[_Part] | None, bool]:
        """Return the parts of a condition with their required truth, and whether all must be so; None if it has no
        parts.
        """
        match node:
            case ast.Binary(op="&&"):
                return [(part, wanted) for part in parts_of(node, "&&")], wanted
            case ast.Binary(op="||" | "imply"):
                return list(_alternatives(node, wanted)), not wanted
            case ast.Quantified(kind="forall" | "exists" as kind):
                low, high = bounds_of(self.judge.network, node.type)
                parts = [(instance(node, value), wanted) for value in range(low, high + 1)]
                return parts, (kind == "forall") == wanted
        return None, True

    def _reasons(self, node: ast.Expression, wanted: bool) -> Iterator[_Part]:
        """Yield the leaves that decide the truth of a condition."""
        judge = self.judge
        if isinstance(node, ast.Unary) and node.op == "!":
            yield from self._reasons(node.operand, not wanted)
        elif isinstance(node, ast.Conditional):
            yield from self._reasons(node.yes if judge.holds(node.test) else node.no, wanted)
        elif isinstance(node, ast.Call) and (inner := self._inner(node)) is not None:
            yield from self._reasons(inner, wanted)
        else:
            parts, all_of = self._parts(node, wanted)
            if parts is None:
                yield node, wanted
            elif all_of:
                for part, want in parts:
                    yield from self._reasons(part, want)
            else:
                for part, want in parts:
                    if judge.holds(part) is want:
                        yield from self._reasons(part, want)
                        break

    def _fact(self, node: ast.Expression, holds: bool) -> Iterator[tuple[str, str]]:
        """Yield subject and statement for a leaf as it is now; nothing if it consists of constants."""
        judge = self.judge
        if number_of(node) is not None:
            return
        if (place := judge.location(node)) is not None:
            network, state = judge.network, judge.instant.state
            process = network.processes[place[0]]
            now = process.locations[state.locations[place[0]]].name
            aside = "" if now == place[1] else f" (but in {now})"
            yield judge.names.element(process.name), f"is {'' if holds else 'not '}in {place[1]}{aside}"
        elif isinstance(node, ast.Name) and node.name == "deadlock":
            yield ("no transition", "is possible any more") if holds else ("a transition", "is possible")
        elif (sides := self._sides(node)) is not None:
            left, op, right = sides
            op = op if holds else _CONTRARY[op]
            aside = (
                f" ({_LESS[op]} {self._limit(left, right)})"
                if op in _LESS and not _is_instance(right)
                else ""
            )
            yield judge.text(left), f"is {judge.shown(left)}{aside}"
        elif judge.variable(node) is not None:
            yield judge.text(node), f"is {judge.shown(node)}"
        elif self._moving(node):
            yield judge.text(node), "holds" if holds else "does not hold"

    def _leaf_fault(self, node: ast.Expression, wanted: bool) -> str:
        judge = self.judge
        if isinstance(node, ast.Name) and node.name == "deadlock":
            return (
                "a transition must be possible, but none is"
                if not wanted
                else "a deadlock is required, but a transition is possible"
            )
        if (place := judge.location(node)) is not None:
            process = judge.network.processes[place[0]]
            now = process.locations[judge.instant.state.locations[place[0]]].name
            who = judge.names.element(process.name)
            return f"{who} must {'' if wanted else 'not '}be in {place[1]}, but it is" + (
                f" in {now}" if wanted else ""
            )
        if (sides := self._sides(node)) is not None:
            left, op, right = sides
            return f"{judge.text(left)} must {self._must(left, op, right, wanted)}, but it is" + (
                f" {judge.shown(left)}" if (op if wanted else _CONTRARY[op]) != "!=" else ""
            )
        if judge.variable(node) is not None:
            return (
                f"{judge.text(node)} must be {'true' if wanted else 'false'}, but it is {judge.shown(node)}"
            )
        values = [f"{judge.text(each)} is {judge.shown(each)}" for each in self._variables(node)]
        text = f"{judge.text(node)} must {'' if wanted else 'not '}hold, but it does{'' if not wanted else ' not'}"
        return text + (f" ({listed(values, _MOST_FACTS)})" if values else "")

    def _wish(self, node: ast.Expression, wanted: bool) -> str:
        judge = self.judge
        if (place := judge.location(node)) is not None:
            who = judge.names.element(judge.network.processes[place[0]].name)
            return f"{who} is {'' if wanted else 'not '}in {place[1]}"
        if (sides := self._sides(node)) is not None:
            return f"{judge.text(sides[0])} is {self._must(*sides, wanted).replace('be ', '', 1)}"
        return judge.text(node) if wanted else f"not {judge.text(node)}"

    def _must(self, left: ast.Expression, op: str, right: ast.Expression, wanted: bool) -> str:
        """Return a requirement in words: ``be at most GRIP_BOUND (30 s)``."""
        op, limit = op if wanted else _CONTRARY[op], self._limit(left, right)
        if op in _LESS:
            return f"be {_LESS[op]} {limit}"
        return f"be {limit}" if op == "==" else f"not be {limit}"

    def _limit(self, left: ast.Expression, right: ast.Expression) -> str:
        judge = self.judge
        if judge.clock(left) is not None:
            return judge.bound(right)
        if (number := number_of(right)) is not None and (variable := judge.variable(left)) is not None:
            return judge.names.value(variable, number)
        text = judge.text(right)
        return (
            text
            if not self._moving(right) and isinstance(right, ast.Name)
            else f"{text} ({judge.shown(right)})"
        )

    def _sides(self, node: ast.Expression) -> tuple[ast.Expression, str, ast.Expression] | None:
        """Return a comparison with a variable or clock on its left; None for others, and if the right side is a
        condition.
        """
        if not isinstance(node, ast.Binary) or node.op not in _CONTRARY:
            return None
        for left, op, right in ((node.left, node.op, node.right), (node.right, _FLIPPED[node.op], node.left)):
            simple = (
                not isinstance(right, ast.Binary | ast.Unary)
                or number_of(right) is not None
                or right.op in "+-*/%"
            )
            if simple and (self.judge.clock(left) is not None or self.judge.variable(left) is not None):
                return left, op, right
        return None

    def _variables(self, node: ast.Expression) -> Iterator[ast.Expression]:
        """Yield the variables of a leaf without repetition."""
        seen = set()
        for each in ast.walk(node):
            if isinstance(each, ast.Name | ast.Member | ast.Index):
                name = self.judge.variable(each)
                if name is not None and name not in seen:
                    seen.add(name)
                    yield each

    def _moving(self, node: ast.Expression) -> bool:
        """Return whether an expression depends on the state."""
        find = self.judge.network.scope.find
        return any(
            isinstance(each, ast.Member | ast.Call)
            or (
                isinstance(each, ast.Name)
                and (each.name == "deadlock" or isinstance(find(each.name), _STATE))
            )
            for each in ast.walk(node)
        )


def _alternatives(node: ast.Expression, wanted: bool) -> Iterator[_Part]:
    """Yield the parts of a disjunction; ``imply``, which binds as ``||`` does, counts as one."""
    match node:
        case ast.Binary(left=left, op="||" | "imply" as op, right=right):
            if op == "||":
                yield from _alternatives(left, wanted)
            else:
                yield left, not wanted
            yield from _alternatives(right, wanted)
        case _:
            yield node, wanted


def _together(subjects: Sequence[str], what: str) -> str:
    """Return a clause for several subjects: ``kept[cups] and kept[rod] are false``."""
    if len(subjects) == 1:
        return f"{subjects[0]} {what}"
    what = (
        f"are{what.removeprefix('is')}"
        if what.startswith("is ")
        else {"holds": "hold"}.get(what, "do not hold")
    )
    return f"{listed(subjects, _MOST)} {what}"


def _is_instance(node: ast.Expression) -> bool:
    """Return whether an expression is a number that replaced the variable of a quantifier."""
    return isinstance(node, ast.Unary) and node.op == "+"


def _is_premise(node: ast.Expression, wanted: bool) -> bool:
    """Return whether a part of a disjunction only limits where the other parts count: ``!p || q``, ``j >= i || q``."""
    if isinstance(node, ast.Binary) and node.op in _CONTRARY and wanted:
        return _is_instance(node.left) or _is_instance(node.right)
    return not wanted or (isinstance(node, ast.Unary) and node.op == "!")
