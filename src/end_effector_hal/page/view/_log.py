"""A log of transitions, time-outs, commands, refusals and alarms, each with its cause."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from end_effector_hal.control import FAILURES, EventReader, Status, event_text
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.vocabulary import (
    Alarm,
    ChangerState,
    Command,
    EndEffectorState,
    alarm_changes,
    display_name,
)
from timed_automata import Document, Step, Template


def in_file(where: str) -> str:
    """Return ``line:column`` of ``file:line:column``: the file's path may differ on the program's machine."""
    return ":".join(where.rsplit(":", 2)[1:])


KEPT = 1_000
"""Number of entries that are kept."""
LONGEST = 600
"""Largest number of characters of a guard."""
_INDEX = re.compile(r"(\w+)\[(\d+)\]")


class EventLog:
    """A log of JSON entries: number, time, kind, text, and the details.

    Args:
        document: its UPPAAL file, for the guards.
    """

    def __init__(self, description: Description, document: Document) -> None:
        self._description = description
        self._labels = {
            in_file(edge.place.where(0)): (template, number)
            for template in document.templates
            for number, edge in enumerate(template.edges)
        }
        self.entries: deque[dict[str, Any]] = deque(maxlen=KEPT)
        self._count = 0
        self._part = 0
        self._asked = ""
        self._alarms: tuple[Alarm, ...] = ()
        self._reader = EventReader()

    def since(self, number: int) -> list[dict[str, Any]]:
        """Return the entries after this number, sorted by time: a status comes after the writes that it caused."""
        new = min(len(self.entries), self._count - number)
        return sorted([self.entries[index] for index in range(-new, 0)], key=lambda entry: entry["at"])

    @property
    def newest(self) -> int:
        """Number of the newest entry; 0 if there is none."""
        return self._count

    def take(self, kind: str, record: Any, readings: Mapping[str, Any]) -> None:
        """Process one record; ``readings`` are the sensor values at that time."""
        if kind == "step":
            self._step(record, readings)
        elif kind == "start":
            self._reader, self._part = EventReader(), 0
        elif kind == "state":
            self._reader = EventReader(record.execution.variables)
            self._part = record.execution.variables.get("part", 0)
        elif kind == "command":
            self._asked = f"{record.name.capitalize()} {record.part}".rstrip()
        elif kind == "answer":
            word, self._asked = self._asked or "Command", ""
            if not record.accepted:
                self.add(record.at, "refusal", f"{word} refused. {record.reason}")
            else:
                self.add(record.at, "command", f"{word} accepted.")
        elif kind == "refused":
            self.add(record.at, "refusal", "The line arbiter refused an activation.")
        elif kind == "lines" and record.error:
            self.add(record.at, "refusal", record.error)
        elif kind == "arbiter":
            there = "is there again." if record.there else f"was lost. {record.why}"
            self.add(record.at, "alarm", f"The line arbiter {there}".rstrip())
        elif kind == "published":
            self._published(record.status)

    def add(
        self,
        at: int,
        kind: str,
        text: str,
        detail: Mapping[str, Any] | None = None,
        alarm: Alarm | None = None,
    ) -> None:
        """Add one entry; an alarm's entry has the alarm's identity."""
        self._count += 1
        entry = {"n": self._count, "at": at, "kind": kind, "text": text, "detail": detail}
        self.entries.append(entry | ({"id": alarm.id, "about": alarm.about} if alarm else {}))

    def told(self, at: int, changes: Sequence[tuple[str, int]]) -> None:
        """Add changes of the automata's variables whose edges are unknown."""
        if words := self._words(changes):
            self.add(at, "transition", "; ".join(words))

    def _published(self, status: Status) -> None:
        for alarm, change in alarm_changes(self._alarms, status.alarms):
            if change != "ended" or not alarm.over:
                self.add(status.at, "alarm" if change == "begun" else "over", alarm.text, alarm=alarm)
        self._alarms = status.alarms

    def _step(self, step: Step, readings: Mapping[str, Any]) -> None:
        edges = [self._edge(edge.process, edge.source, edge.target, edge.where) for edge in step.edges]
        events = self._reader.of(step, step.at)
        self._part = next((change.new for change in step.changes if change.name == "part"), self._part)
        tool = self._description.per_part[self._part]
        texts = [text.rstrip(".") for event in events if (text := event_text(tool, event))]
        changes = [f"{change.name} = {change.new}" for change in step.changes]
        words = [*texts, *self._words([(change.name, change.new) for change in step.changes])]
        detail = {
            "edges": edges,
            "received": step.received,
            "changes": changes,
            "late_ms": step.late_us / 1000,
            "missed": step.missed,
            "readings": dict(readings),
        }
        moved = f"{step.edges[0].process}: {step.edges[0].source} → {step.edges[0].target}"
        failed = any(event.kind in FAILURES for event in events)
        kind = "time-out" if failed else "transition" if words else "automaton"
        self.add(step.at, kind, "; ".join(words) or moved, detail)
        if step.missed:
            self.add(step.at, "alarm", f"Taken {step.late_us / 1000:.1f} ms late: beyond the bound.")

    def _edge(self, process: str, source: str, target: str, where: str) -> dict[str, Any]:
        template, number = self._labels.get(in_file(where), (None, -1))
        labels = _labels(template, number)
        return {"process": process, "source": source, "target": target, "number": number, **labels}

    def _words(self, changes: Sequence[tuple[str, int]]) -> list[str]:
        """Return the changes in the terms of the tool."""
        actuators, said = self._description.ordered, []
        for name, value in changes:
            if name == "ee":
                said.append(f"State {EndEffectorState(value).label}")
            elif name == "changer":
                said.append(f"Tool changer {ChangerState(value).name}")
            elif name == "unlock_valve":
                said.append(f"Unlock output {'on' if value else 'off'}")
            elif name in ("command", "changer_command") and value != Command.NONE:
                said.append(f"Command {Command(value).label}")
            elif (found := _INDEX.fullmatch(name)) and found[1] in ("actuator", "valve"):
                who, actuator = actuators[int(found[2])]
                if found[1] == "valve":
                    said.append(f"{display_name(who)} output {'on' if value else 'off'}")
                else:
                    said.append(f"{display_name(who)} {kind_of(actuator).states(value).label}")
        return said


def _labels(template: Template | None, number: int) -> dict[str, str]:
    if template is None:
        return {}
    labels = template.edges[number].labels
    return {
        kind: " ".join(labels[kind].text.content.split())[:LONGEST]
        for kind in ("guard", "synchronisation", "assignment", "comments")
        if kind in labels
    }
