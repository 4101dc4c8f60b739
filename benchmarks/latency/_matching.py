"""Pure functions from notes to latencies: they match edges with the frames that caused them, and with messages."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

Note = Mapping[str, Any]
Latencies = dict[str, list[int]]
"""Latencies in µs by name: ``reaction``, ``reaction_seen``, ``command``, ``state``."""


class MatchError(Exception):
    """The notes are inconsistent."""


def product_latencies(events: Iterable[Note], notes: Iterable[Note], lines: Sequence[str]) -> Latencies:
    """Return the latencies of the product.

    A state has the time at which its frame was read (``at``), so the confirming frame is the last one sent before: an
    edge that comes a frame too late is not counted as a fast one.

    Args:
        events: frames and edges noted by the testbench.
        notes: goals and states noted by the client.
        lines: lines of the actuators, in sequence order.
    """
    events, notes = list(events), list(notes)
    frames = [event["at"] for event in events if "frame" in event and event["sent"]]
    goals = sorted(note["at"] for note in notes if "goal" in note)
    states = [note for note in notes if "received" in note]
    # before the first goal the lines are adopted
    edges = [event for event in events if event.get("line") in lines and event["at"] >= goals[0]]
    found: Latencies = {"reaction": [], "reaction_seen": [], "command": [], "state": []}
    commanded = [bisect_right(goals, edge["at"]) for edge in edges]
    for index, line in enumerate(lines):
        changes = _changes(states, index)
        own = [(edge, number) for number, edge in enumerate(edges) if edge["line"] == line]
        if [bool(edge["level"]) for edge, _ in own] != [state["outputs"][index] for state in changes]:
            raise MatchError(f"{line}: {len(own)} edges, {len(changes)} changes of the state.")
        for (edge, number), state in zip(own, changes, strict=True):
            found["state"].append(state["received"] - edge["at"])
            if number == 0 or commanded[number] != commanded[number - 1]:
                found["command"].append(edge["at"] - goals[commanded[number] - 1])
            else:
                sent = frames[bisect_right(frames, state["at"]) - 1]
                found["reaction"].append(edge["at"] - sent)
                found["reaction_seen"].append(edge["seen"] - sent)
    return found


def floor_latencies(notes: Iterable[Note]) -> Latencies:
    """Return the latencies of the floor, whose notes are matched by words."""
    notes = list(notes)
    edges = {note["edge"]: note for note in notes if "edge" in note}
    states = {note["state"]: note["received"] for note in notes if "state" in note}
    found: Latencies = {"reaction": [], "reaction_seen": [], "command": [], "state": []}
    for note in notes:
        word = note.get("ping") or note.get("goal")
        if word is None:
            continue
        if word not in edges or word not in states:
            raise MatchError(f"The floor lost {word}.")
        edge = edges[word]
        if "goal" in note:
            found["command"].append(edge["at"] - note["at"])
        else:
            found["reaction"].append(edge["at"] - note["at"])
            found["reaction_seen"].append(edge["seen"] - note["at"])
        found["state"].append(states[word] - edge["at"])
    return found


def _changes(states: Sequence[Note], index: int) -> list[Note]:
    """Return the first state of each level of an output, which is inactive before."""
    level, changes = False, []
    for state in states:
        if state["outputs"][index] != level:
            level = state["outputs"][index]
            changes.append(state)
    return changes
