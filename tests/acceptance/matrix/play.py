"""A cell of `eehal matrix`, played on real processes: it must end as it does in virtual time, or as is allowed."""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress
from dataclasses import dataclass, field

from end_effector_hal.vocabulary import Command
from end_effector_hal.vocabulary import EndEffectorState as State
from end_effector_lab.matrix import (
    GRIP,
    HELD,
    RELEASE,
    REST,
    Cell,
    Moment,
    Outcome,
    expected,
    outcome_of,
    play,
)
from tests.acceptance.kill_matrix.cells import BOTH
from tests.acceptance.kill_matrix.system import lives
from tests.acceptance.kill_matrix.system_plain import PlainSystem
from tests.acceptance.kill_matrix.system_restarted import LINE_ARBITER
from tests.acceptance.kill_matrix.waiting import pause, until

KILLED = {"kill hal": "HAL", "kill arbiter": LINE_ARBITER, "kill both": BOTH}
HOLD_S, DEAD_S, STILL_S, GRIP_AFTER_S = 1.0, 1.0, 1.5, 0.7
FOLLOWED_S, LONGEST_S = 15.0, 90.0
AT_REST = (State.STAND_BY, State.GRIPPED, State.GRIP_ERROR, State.RELEASE_ERROR)


@dataclass(frozen=True)
class Row:
    """What became of a cell.

    Attributes:
        virtual, real: how it ended in virtual time, and on real processes.
        faults: what is not allowed, sentences; empty: nothing.
    """

    cell: Cell
    virtual: str
    real: str
    seconds: float
    faults: tuple[str, ...] = field(default=())

    @property
    def same(self) -> bool:
        """Whether it ended in the same way."""
        return bool(self.real) and self.virtual == self.real


class RealCell:
    """A cell on a running system."""

    def __init__(self, system: PlainSystem, cell: Cell, event: Moment | None) -> None:
        self._system, self._cell, self._event = system, cell, event
        self._names = {part.line: name for name, part in system.description.ordered}
        self._phase = REST
        self._answered: list[tuple[str, bool]] = []

    def run(self) -> Row:
        """Play it on a system at rest; raises Late only when its moment cannot be reached."""
        begun, description = time.monotonic(), self._system.description
        virtual = play(description, self._cell)
        self._mark = self._system.observer.mark()
        if self._cell.moment.phase != REST:
            self._reach()
        mark = self._system.observer.mark()
        if self._cell.name != "nominal":
            self._system.plant.choose(self._cell.fault)
        self._act()
        outcome = self._settled()
        faults = []
        want = expected(description, self._cell)
        if outcome not in want.outcomes:
            faults.append(f"allowed: {', '.join(sorted(want.outcomes))}")
        if self._held(outcome) and (off := self._switched_off(mark)):
            faults.append(f"{', '.join(off)} went inactive, and what is held stays held")
        if outcome == virtual.outcome and self._active() != self._ends_active(virtual.lines):
            faults.append(f"active: {', '.join(sorted(self._active())) or 'nothing'}")
        return Row(self._cell, virtual.outcome, outcome.value, time.monotonic() - begun, tuple(faults))

    # The moment

    def _reach(self) -> None:
        """Some time after its event."""
        assert self._event is not None
        self._give("grip")
        self._phase = GRIP
        _, _, what = self._event.name.partition(" ")
        if self._event.phase in (HELD, RELEASE) or what == State.GRIPPED.name:
            until("GRIPPED", lambda: self._system.hands.look()["state"] == State.GRIPPED, 60.0)
            self._phase = HELD
        if self._event.phase == RELEASE or self._cell.moment.phase == RELEASE:
            pause(HOLD_S)
            self._give("drop")
            self._phase = RELEASE
        if what not in State.__members__:
            name, _, level = what.rpartition(" ")
            until(what, lambda: (name, level == "on") in self._switched(self._mark), 60.0)
        pause((self._cell.moment.at - self._event.at) / 1e6)

    def _act(self) -> None:
        command, system = self._cell.command, self._system
        if command in KILLED:
            pids = system.pids(KILLED[command])
            for pid in pids:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            until("their end", lambda: not any(map(lives, pids)))
            if command != "kill arbiter":
                pause(DEAD_S)
                system.hands.close()
                system.connect()
            until("the HAL again", lambda: system.pids(LINE_ARBITER) and system.hands.look(), 30.0)
        elif command != "none":
            self._answered.append((command, self._give(command)))
        elif self._cell.moment.phase == REST:
            pause(GRIP_AFTER_S)
            self._answered.append(("grip", self._give("grip")))
            self._phase = GRIP

    def _give(self, name: str) -> bool:
        hands = self._system.hands
        return hands.decision(hands.send(name))

    # What follows

    def _settled(self) -> Outcome:
        """Until nothing moves; what is held is followed for a while."""
        end, follow_until = time.monotonic() + LONGEST_S, time.monotonic() + FOLLOWED_S
        since, before = time.monotonic(), None
        while time.monotonic() < end:
            pause(0.05)
            state = self._system.hands.look()
            now = (state.get("state"), self._system.observer.active())
            if now != before or not self._is_still():
                since, before = time.monotonic(), now
            holds = state.get("state") == State.GRIPPED and self._cell.name != "nominal"
            if time.monotonic() - since > STILL_S and (not holds or time.monotonic() > follow_until):
                return outcome_of(self._cell, State(state["state"]), self._phase, self._answered)
        return Outcome.UNFINISHED

    def _is_still(self) -> bool:
        state, changer = self._system.hands.look(), self._system.description.tool_changer
        unlocked = changer is not None and changer.line in self._system.observer.active()
        fresh = time.monotonic() - max(self._system.hands.heard.values(), default=0) < 1.0
        return bool(
            state
            and fresh
            and state["state"] in AT_REST
            and state["command"] == Command.NONE
            and not unlocked
        )

    def _held(self, outcome: Outcome) -> bool:
        """Whether a part was held at the moment, and is still."""
        return self._cell.moment.phase == HELD and outcome in (Outcome.SUCCESS, Outcome.HELD)

    def _switched(self, mark: int) -> list[tuple[str, bool]]:
        return [(self._names[line], on) for line, on in self._system.observer.since(mark, self._names)]

    def _switched_off(self, mark: int) -> list[str]:
        return [name for name, active in self._switched(mark) if not active]

    def _active(self) -> set[str]:
        return {self._names[line] for line in self._system.observer.active() if line in self._names}

    def _ends_active(self, lines: tuple[tuple[float, str, bool], ...]) -> set[str]:
        """Of the actuators, by what was switched in virtual time since the fault."""
        active = set(self._cell.moment.engaged)
        for _, line, level in lines:
            if line in self._names:
                (active.add if level else active.discard)(self._names[line])
        return active
