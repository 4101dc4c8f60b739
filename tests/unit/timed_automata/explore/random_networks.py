"""Small random networks and queries, each query with a predicate for the naive explorer."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

from tests.unit.timed_automata.explore.models import network
from tests.unit.timed_automata.explore.regions import Predicate, compare
from timed_automata import Network

LARGEST = 3
CLOCKS = ("x", "y")
PLACES = ("a", "b", "c")
OPS = ("<", "<=", "==", ">=", ">")


@st.composite
def comparisons(draw: st.DrawFn) -> str:
    return f"{draw(st.sampled_from(CLOCKS))} {draw(st.sampled_from(OPS))} {draw(st.integers(0, LARGEST))}"


@st.composite
def edges(draw: st.DrawFn, *, executable: bool = False) -> str:
    sync = draw(st.sampled_from(("", "", "", "p!", "p?", "b!", "b?", "u!", "u?")))
    guards = []
    if draw(st.booleans()) and sync not in ("u!", "u?", "b?" if executable else "u?"):
        guards += draw(st.lists(comparisons(), min_size=1, max_size=2))
    if draw(st.integers(0, 3)) == 0:
        guards.append(draw(st.sampled_from(("i == 0", "i > 0", "i != 1"))))
    updates = draw(
        st.lists(st.sampled_from(("x = 0", "y = 0", "x = 1", "i = 0", "i = 1", "i = 2 - i")), max_size=2)
    )
    source, target = draw(st.sampled_from(PLACES)), draw(st.sampled_from(PLACES))
    text = f"{source} -> {target}"
    text += f"; guard: {' && '.join(guards)}" if guards else ""
    text += f"; sync: {sync}" if sync else ""
    return text + (f"; do: {', '.join(updates)}" if updates else "")


@st.composite
def templates(draw: st.DrawFn, name: str, *, executable: bool) -> str:
    """``executable``: without lower bounds in invariants (else often with one where an edge leads), and without clock
    guards where a broadcast is received.
    """
    invariants: dict[str, list[str]] = {place: [] for place in PLACES}
    for place in PLACES:
        if draw(st.integers(0, 2)) == 0:
            op = draw(st.sampled_from(("<=", "<=", "<")))
            invariants[place].append(f"{draw(st.sampled_from(CLOCKS))} {op} {draw(st.integers(1, LARGEST))}")
            if draw(st.integers(0, 5)) == 0:
                invariants[place].append("i < 2")
    drawn = draw(st.lists(edges(executable=executable), min_size=1, max_size=5))
    if not executable and draw(st.booleans()):
        # not in the first one: a run begins where all clocks are zero
        place, clock = draw(st.sampled_from(PLACES[1:])), draw(st.sampled_from(CLOCKS))
        bound = draw(st.sampled_from(("> 0", ">= 1", "> 1", ">= 2", ">= 3", ">= i")))
        invariants[place].append(f"{clock} {bound}")
        update = draw(st.sampled_from(("", "", "x = 0", "y = 0", "x = 1", "i = 2 - i")))
        drawn.append(f"a -> {place}" + (f"; do: {update}" if update else ""))
    marks = draw(st.lists(st.sampled_from(("", "", "b", "c")), min_size=2, max_size=2))
    held = [f"{place}: {' && '.join(parts)}" for place, parts in invariants.items() if parts]
    marked = [f"urgent: {marks[0]}", f"committed: {marks[1]}", "initial: a", f"locations: {' '.join(PLACES)}"]
    return f"{name}: " + " | ".join([*held, *marked, *drawn])


@st.composite
def networks(draw: st.DrawFn, processes: int = 2, *, executable: bool = False) -> Network:
    parts = [draw(templates(f"P{number}", executable=executable)) for number in range(processes)]
    return network("clock x, y; int[0,2] i; chan p; broadcast chan b; urgent chan u;", *parts)


@dataclass(frozen=True)
class Condition:
    text: str
    holds: Predicate

    def __repr__(self) -> str:
        return self.text


@st.composite
def conditions(draw: st.DrawFn, depth: int = 2) -> Condition:
    kind = draw(
        st.sampled_from(("place", "value", "clock") if not depth else ("place", "clock", "and", "or", "not"))
    )
    if kind == "place":
        process, place = draw(st.integers(0, 1)), draw(st.sampled_from(PLACES))
        return Condition(f"P{process}.{place}", lambda r: r.locations[process] == PLACES.index(place))
    if kind == "value":
        value = draw(st.integers(0, 2))
        return Condition(f"i == {value}", lambda r: r.values[0] == value)
    if kind == "clock":
        clock, op, value = draw(st.integers(0, 1)), draw(st.sampled_from(OPS)), draw(st.integers(0, LARGEST))
        return Condition(f"{CLOCKS[clock]} {op} {value}", lambda r: compare(r.clocks[clock], op, value))
    left = draw(conditions(depth - 1))
    if kind == "not":
        return Condition(f"!({left.text})", lambda r: not left.holds(r))
    right = draw(conditions(depth - 1))
    if kind == "and":
        return Condition(f"({left.text}) && ({right.text})", lambda r: left.holds(r) and right.holds(r))
    return Condition(f"({left.text}) || ({right.text})", lambda r: left.holds(r) or right.holds(r))
