"""A recording without traces, such as a converted ROS bag: states, alarms and pressures, from its tables."""

from __future__ import annotations

import heapq
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from operator import itemgetter
from pathlib import Path
from typing import Any

from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import Status, ToolEvent
from end_effector_hal.description import Description, content_hash
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.page.view import Cards
from end_effector_hal.recording import (
    ENDED,
    AlarmRow,
    EventRow,
    PressuresLog,
    RunFile,
    RunInfo,
    StatesLog,
    StatesRow,
    SwitchesLog,
    read_alarms,
    read_pressures,
    read_run,
    read_states,
    read_switches,
)
from end_effector_hal.runtime.boundary import FrameTaken, Header, Published
from end_effector_hal.runtime.stream import PUBLISHED
from end_effector_hal.verification.replay import Entry
from end_effector_hal.vocabulary import ACTIVE, PENDING, Alarm, Evidence

from ._files import TOLD

_UNKNOWN = ("held", "lift_allowed", "secure", "changer", "unlock_output", "armed", "worst_late_ms", "missed")


class RecordedTables:
    """The tables of a folder, used instead of traces (`RecordingFiles`).

    Args:
        folder: the folder, with ``states.csv``.
        description: the tool; tables do not contain it.
        name: name of the recording on the page; default: the name of the folder.
        notes: sentences that the page shows with the recording.

    Raises:
        UsageError: the states cannot be read, or belong to another tool.
    """

    def __init__(
        self, folder: Path, description: Description, name: str = "", notes: tuple[str, ...] = ()
    ) -> None:
        self.path, self.name, self.description = folder, name or folder.resolve().name, description
        self._cards = Cards(description, dict(carrier_of(description).channels))
        self._states: StatesLog = read_states(folder / RunFile.STATES)
        actuators = tuple(each for each, _ in description.ordered)
        if self._states.actuators != actuators:
            raise UsageError(
                f"The states are those of {', '.join(self._states.actuators)}; this tool has {', '.join(actuators)}.",
                where=str(folder / RunFile.STATES),
                todo="Name the description of the tool that was recorded.",
            )
        info: RunInfo = read_run(folder)
        own = content_hash(description)
        self.notes = [
            "There is no trace: evidence, outputs, interlocks, automata and refusals were not recorded.",
            *notes,
            *([info.note] if info.note else []),
            *info.gaps,
            *([self._states.note] if self._states.note else []),
        ]
        if info.hash and info.hash != own:
            self.notes.append(
                f"It is shown with another description ({own}) than run.json names ({info.hash})."
            )
        self._alarms: list[AlarmRow] = self._optional(
            RunFile.ALARMS, lambda path: list(read_alarms(path)), []
        )
        self._pressures: PressuresLog = self._optional(
            RunFile.PRESSURES, read_pressures, PressuresLog((), ())
        )
        self._switches: SwitchesLog | None = self._optional(RunFile.SWITCHES, read_switches, None)
        if self._pressures.note:
            self.notes.append(self._pressures.note)
        self.header = Header(
            0,
            description.name,
            own,
            "not recorded",
            info.version,
            info.started,
            str(description.source),
            {},
            "",
        )
        times = [row.time_s for row in self._states.rows] + [
            time_s for time_s, _ in self._pressures.samples[-1:]
        ]
        self.begin, self.end = 0, round(max(times, default=0.0) * 1e6)
        self.whole, self.grown = not info.gaps, False
        self.has_events = self._states.events is not None
        self._now: Mapping[str, int | None] = {}

    def again(self) -> RecordedTables:
        """Return this object, because tables without traces do not change."""
        return self

    def entries(self) -> Iterator[Entry]:
        """Yield the rows of the tables as records, in order of time."""
        for entry in heapq.merge(self._told(), self._frames(), self._levels(), key=lambda entry: entry.at):
            yield entry
            if entry.kind == "frame":  # the caller asks for the next one
                self._now = {**self._now, **entry.record.values}

    def known(self, view: dict[str, Any]) -> dict[str, Any]:
        """Return the view without values that were not recorded."""
        state = view["state"] and {**view["state"], **dict.fromkeys(_UNKNOWN)}
        cards = []
        for card, (name, _) in zip(view["cards"] or (), self.description.ordered, strict=False):
            values = self._cards.values(name, self._now)
            cards.append({**card, "output": None, "evidence": None, "values": values})
        return {**view, "state": state, "cards": cards or None, "interlocks": []}

    def _told(self) -> Iterator[Entry]:
        rows = self._states.events or ()
        every: list[StatesRow | AlarmRow | EventRow] = [*rows, *self._states.rows, *self._alarms]
        shown: dict[tuple[str, str], Alarm] = {}
        events: list[ToolEvent] = []
        state: StatesRow | None = None
        for row in sorted(every, key=lambda row: row.time_s):
            at = round(row.time_s * 1e6)
            if isinstance(row, EventRow):
                place = self.description.sequence.index(row.actuator) if row.actuator else -1
                states = row.old, row.new
                events.append(ToolEvent(at, row.kind, place, row.attempt, *states, row.cause, row.command))
            elif isinstance(row, AlarmRow):
                if row.event == ENDED:
                    shown.pop(row.key, None)
                else:
                    shown[row.key] = row.as_alarm()
            else:
                old = state.states if state else (None,) * len(row.states)
                state = row
                names = ("ee", "command", *(f"actuator[{index}]" for index in range(len(row.actuators))))
                changes = [
                    (name, new) for name, was, new in zip(names, old, row.states, strict=True) if was != new
                ]
                yield Entry(at, TOLD, changes)
            if state is not None:
                active = tuple(value in (PENDING, ACTIVE) for value in state.actuators)
                unknown = (Evidence.UNKNOWN,) * len(active)
                status = Status(
                    at,
                    state.end_effector,
                    state.command,
                    state.actuators,
                    active,
                    unknown,
                    part=self._part_at(row.time_s),
                    alarms=tuple(shown.values()),
                    events=tuple(events),
                )
                events.clear()
                yield Entry(at, PUBLISHED, Published(at, status, {}))

    def _part_at(self, time_s: float) -> str:
        """Return the part that is gripped, held or released; one that the tool does not name is left out."""
        rows = self._states.part_rows
        found = bisect_right(rows, time_s, key=itemgetter(0))
        name = rows[found - 1][1] if found else ""
        return name if name in self.description.parts else ""

    def _frames(self) -> Iterator[Entry]:
        for time_s, values in self._pressures.samples:
            at = round(time_s * 1e6)
            named = zip(self._pressures.channels, values, strict=True)
            pascals = {name: None if kpa is None else round(kpa * 1000) for name, kpa in named}
            yield Entry(at, "frame", FrameTaken(at, at, None, None, pascals))

    def _levels(self) -> Iterator[Entry]:
        log = self._switches
        for time_s, levels in log.rows if log else ():
            at = round(time_s * 1e6)
            values = dict(zip(log.channels, levels, strict=True)) if log else {}
            yield Entry(at, "frame", FrameTaken(at, at, None, None, values))

    def _optional(self, name: str, read: Any, nothing: Any) -> Any:
        path = self.path / name
        if not path.exists():
            return nothing
        try:
            return read(path)
        except ReportedError as error:
            self.notes.append(f"{name} is left out: {error}")
            return nothing
