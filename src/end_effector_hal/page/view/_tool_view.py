"""The whole page as JSON, made from the records of the HAL."""

from __future__ import annotations

from collections import deque
from typing import Any

from end_effector_hal.codecs import carrier_of, sources_of
from end_effector_hal.control import Status, network_of
from end_effector_hal.control.goals import GOAL_COMMANDS, Outcome, judge
from end_effector_hal.description import Description, content_hash
from end_effector_hal.runtime.stream import HEALTH, MAINTENANCE_WORDS
from end_effector_hal.signals import GAUGE_PRESSURE
from end_effector_hal.verification.proof import Verdict, kept_verdict
from end_effector_hal.vocabulary import STOPPED, Command, EndEffectorState, display_name
from end_effector_hal.wires.sensors import SensorHealth

from ._automata import AutomataView
from ._cards import Cards
from ._counts import GripCounts
from ._interlocks import InterlockTable
from ._log import EventLog
from ._replica import Replica
from ._timeline import TimeLine

_ASKED = {Command.GRIP: "Grip", Command.RELEASE: "Drop", Command.LOCK: "Lock", Command.UNLOCK: "Unlock"}
STALE_US = 1_200_000
"""Silence after which nothing that is shown counts as present."""
_RATE_US = 2_000_000
_VERDICT_US = 2_000_000
_BUTTONS = ("grip", "drop", "resume", "cancel", "stop", "lock", "arm", "unlock", "reset")
_CHANGER_WORDS = ("lock", "arm", "unlock")
_GOING = {
    Command.GRIP: "Grip", Command.RELEASE: "Release", Command.LOCK: "Lock", Command.UNLOCK: "Unlock",
    Command.CANCEL: "Cancel",
}  # fmt: skip


class ToolView:
    """Converts records and times to views without I/O; times in µs on the monotonic clock.

    Args:
        description: the tool; its HAL must run the same one.
        at: the present time.
        content: the hash that the headers give for the description; default: its present hash.

    Raises:
        ModelError, UsageError: its automata, or the sources of its channels, cannot be loaded.
    """

    def __init__(self, description: Description, at: int, content: str = "") -> None:
        self.description, self.begun_at = description, at
        network, carrier = network_of(description), carrier_of(description)
        self._hash = content or content_hash(description)
        self._sources = sources_of(carrier)
        self._source_of = {name: i for i, each in enumerate(self._sources) for name in each.channels}
        self._replica = Replica(description, network, self._hash)
        self.cards = Cards(description, dict(carrier.channels))
        self._interlocks = InterlockTable(description)
        self.log = EventLog(description, network.document)
        self.counts = GripCounts(description)
        self.health: SensorHealth | None = None
        """The latest state of the links and inputs; None: not known."""
        self.timeline = TimeLine(description, self.cards.curves, self.cards.switches)
        self._automata = AutomataView(network, description)
        self._frames = [deque[int](maxlen=400) for _ in self._sources]
        self._command: tuple[Command, int] = (Command.NONE, at)
        self._state: tuple[EndEffectorState, int] = (EndEffectorState.OFF, at)
        self._asked: tuple[Command, int] = (Command.NONE, at)
        """The command that was requested; the running one may change, such as from a failed grip to a release."""
        self._gripped = ""
        """The part of the last grip."""
        self._last: dict[str, Any] | None = None
        self._kept: Verdict | None = None
        self._verdict_due = at

    # What comes.

    def take(self, kind: str, at: int, record: Any, now: int) -> None:
        """Process one record of the HAL.

        Args:
            kind: the kind of the record.
            at: time of the event.
            record: the dataclass of its kind; None for ``alive``.
            now: the present time.

        Raises:
            ReportedError: the record does not fit the ones before it; connect again.
        """
        self._replica.heard_at = now
        if kind == "alive":
            return
        before = self._replica.connected
        self._replica.take(kind, record)
        if self._replica.connected and not before:
            self.log.add(at, "page", "The HAL is connected.")
        if kind == "header":
            self.counts.restart()
        if kind == HEALTH:
            self.health = record
        if kind == "frame":
            self._frames[self._source_of.get(next(iter(record.values), ""), 0)].append(at)
            self.timeline.frame(at, record.values)
        if kind == "step":
            self._automata.step(record)
        self.log.take(kind, record, self._readings() if kind == "step" else {})
        if kind == "published" and (status := self.status()) is not None:
            self._follow(status)

    def lose(self, why: str, now: int) -> None:
        """Mark the stream of the HAL as lost."""
        if self._replica.connected:
            self.log.add(now, "page", why)
            self.timeline.gap(now)
            self._state, self._command, self._last = (EndEffectorState.OFF, now), (Command.NONE, now), None
        self._replica.lose(why)
        self.health = None

    # What is shown.

    def status(self) -> Status | None:
        """Return the status of the tool; None before the first."""
        return self._replica.status

    def is_fresh(self, at: int) -> bool:
        """Return whether the HAL is connected and was not silent for too long."""
        return self._replica.connected and at - self._replica.heard_at <= STALE_US

    def refusal(self, word: str, part: str = "") -> str:
        """Return why the HAL would refuse a button now; empty if it would accept it; ``part``: what to grip."""
        if word == "stop":
            return ""  # the line arbiter is asked, whatever the HAL says
        status = self.status()
        if word == "reset" and self._replica.connected and status is not None and not status.changer_fault:
            return ""  # the automata are asked only if the tool changer is in FAULT
        return self._replica.refusal(word, part)

    @property
    def buttons(self) -> tuple[str, ...]:
        """The buttons of this tool."""
        fitted = self.description.tool_changer is not None
        return tuple(word for word in _BUTTONS if fitted or word not in _CHANGER_WORDS)

    def drawn(self) -> dict[str, Any]:
        """Return the content that never changes."""
        tool = self.description
        return {
            "name": tool.name,
            "summary": tool.summary,
            "source": str(tool.source),
            "hash": self._hash,
            "epoch": self.begun_at,
            "cards": self.cards.drawn(),
            "lanes": self.timeline.lanes,
            "curves": [curve.drawn() for curve in self.cards.curves],
            "buttons": list(self.buttons),
            "parts": [{"name": name, "summary": each.summary} for name, each in tool.parts.items()],
            "sensors": tool.sensors,
            "lease_s": tool.maintenance.lease_s,
            "sources": [
                {"name": self._source_name(source.channels, source.link), "hz": 1e6 / source.period_us}
                for source in self._sources
            ],
            "stale_s": STALE_US / 1e6,
            "automata": self._automata.drawn(),
        }

    def now(self, at: int) -> dict[str, Any]:
        """Return the live view at ``at``."""
        return {
            "at": at,
            "news": self._news(at),
            "rates_hz": self._rates_hz(at),
            "buttons": {word: self.refusal(word) for word in self.buttons},
            "parts": {name: self.refusal("grip", name) for name in self.description.parts},
            "cancel": self._cancel_words(self.status()),
            "stop": self._stop_words(self.status()),
            "maintenance": self._maintenance_now(self.status(), at),
            "verdict": self._verdict(at),
            **self.moment(),
        }

    def moment(self) -> dict[str, Any]:
        """Return the view of the records, live or recorded; constant between records, as it has instants, not ages."""
        status, controller = self.status(), self._replica.controller
        return {
            "state": None if status is None else self._state_now(status),
            "cards": None if status is None else self.cards.now(status, controller, self._gripped),
            "interlocks": self._interlocks.now(status, controller),
            "automata": self._automata.now(controller),
        }

    def _rates_hz(self, at: int) -> list[float]:
        """Return the frame rate of each source, in the order in which they are drawn."""
        window_us = max(_RATE_US // 4, min(_RATE_US, at - self.begun_at))
        counts = [sum(each > at - window_us for each in frames) for frames in self._frames]
        return [count / (window_us / 1e6) for count in counts]

    def _source_name(self, channels: frozenset[str], link: str | None) -> str:
        """Return the label of a source; empty if there is only one."""
        if len(self._sources) == 1:
            return ""
        declared = self.description.channels
        on_board = all(name in declared and declared[name].on_board for name in channels)
        return link or ("inputs" if on_board else "link")

    def _news(self, at: int) -> dict[str, Any]:
        replica, fresh = self._replica, self.is_fresh(at)
        age_s = (at - replica.heard_at) / 1e6 if replica.heard_at else None
        return {"fresh": fresh, "age_s": age_s, "why": "" if fresh else replica.why or "The HAL is silent."}

    def _state_now(self, status: Status) -> dict[str, Any]:
        command, since = self._command
        return {
            "word": f"{status.ee.label}: {status.part}" if status.part else status.ee.label,
            "name": status.ee.name,
            "since": self._state[1],
            "held": status.held,
            "part": status.part,
            "judged": self.cards.judged(status),
            "arbiter_lost": status.arbiter_lost,
            "lift_allowed": status.lift_allowed,
            "secure": status.secure,
            "maintenance": status.maintenance,
            "reason": status.reason,
            "alarms": [each.as_json() | {"text": str(each)} for each in status.alarms],
            "changer": status.changer.name if self.description.tool_changer else None,
            "unlock_output": status.unlock_output,
            "armed": status.armed,
            "link_up": status.link_up,
            "stale": list(status.stale),
            "worst_late_ms": status.worst_late_us / 1000,
            "missed": status.missed,
            "bound_ms": self.description.bounds.reaction_ms,
            "goal": None if command is Command.NONE else self._goal(command, since, status.part),
            "last": self._last,
            "e_stop": self._interlocks.e_stop(status, self._replica.controller),
        }

    def _goal(self, command: Command, since: int, part: str) -> dict[str, Any]:
        durations, changer = self.description.durations, self.description.tool_changer
        at_most_s = {
            Command.GRIP: durations.grip_ms / 1000,
            Command.RELEASE: durations.release_ms / 1000,
            Command.CANCEL: durations.cancel_ms / 1000,
        }.get(command, changer.prove_s if changer else None)
        named = f" {part}" if part and command is Command.GRIP else ""
        name = f"{_GOING.get(command, command.label)}{named}"
        return {"name": name, "since": since, "at_most_s": at_most_s}

    def _maintenance_now(self, status: Status | None, at: int) -> dict[str, Any]:
        on = status is not None and status.maintenance
        ends_at = status.deadline if status is not None and on else None
        return {
            "left_s": None if ends_at is None else max(0, ends_at - at) / 1e6,
            "refused": {word: self.refusal(word) for word in MAINTENANCE_WORDS},
        }

    def _cancel_words(self, status: Status | None) -> str:
        """Return what a cancel would do now, in words."""
        if refused := self.refusal("cancel"):
            return refused
        if status is not None and status.ee is EndEffectorState.GRIPPING:
            tool = self.description
            kept = [name for name in tool.sequence if tool.endings_of(name).gripping.cancel != "release"]
            if not kept:
                return "Now: the grip ends, and what was engaged is released in reverse order."
            names = ", ".join(map(display_name, kept))
            return f"Now: the grip ends; {names} stay{'s' if len(kept) == 1 else ''} active, as declared."
        return "Now: what runs is cancelled."

    def _stop_words(self, status: Status | None) -> str:
        """Return what a stop would do now or has done, in words."""
        if status is not None and status.alarm(STOPPED):
            return "Stopped: nothing is activated until the faults are reset. What is held stays held."
        return "Latched until a reset: nothing is activated, a running grip is cancelled, what is held stays held."

    def _verdict(self, at: int) -> dict[str, Any]:
        if at >= self._verdict_due:  # it is a file, which `eehal verify` may write at any time
            self._verdict_due, self._kept = at + _VERDICT_US, kept_verdict(self.description)
        found = self._kept
        if found is None:
            return {
                "holds": None,
                "text": "Not verified: `eehal verify` has not proven this description here.",
            }
        return {"holds": found.holds, "text": str(found), "at": found.at, "requirements": found.requirements}

    # What was.

    def _follow(self, status: Status) -> None:
        self.timeline.status(status)
        self.counts.status(status)
        self._gripped = status.part or self._gripped
        if status.ee is not self._state[0]:
            self._state = status.ee, status.at
            if self._last is not None and self._last["outcome"] == Outcome.SUCCEEDED.name:
                self._last = None  # what it has reached is over
        if status.command is not self._command[0]:
            if self._command[0] is Command.NONE:
                self._asked, self._last = (status.command, status.at), None
            self._command = status.command, status.at
            if status.command is Command.NONE and self._asked[0] in GOAL_COMMANDS:
                self._last = self._outcome(*self._asked, status)

    def _outcome(self, command: Command, since: int, status: Status) -> dict[str, Any]:
        outcome, reason = judge(command, status)
        seconds = (status.at - since) / 1e6
        word = f"{_ASKED[command]} {outcome.name.lower()}"
        return {"outcome": outcome.name, "word": word, "reason": reason, "at": status.at, "seconds": seconds}

    def _readings(self) -> dict[str, Any]:
        if (controller := self._replica.controller) is None:
            return {}
        at, now = controller.at, controller.senses.now
        measures = now.readings.measures
        values = {name: now.readings.get(name, at) for name in now.readings.carried}
        return {
            name: value
            if value is None or isinstance(value, bool)
            else value / 1000
            if measures.get(name, GAUGE_PRESSURE) == GAUGE_PRESSURE
            else measures[name].text(value)
            for name, value in values.items()
        }
