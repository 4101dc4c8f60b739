"""One cell: reach the state, hit the process, compare what follows with what is declared, use the tool again."""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress
from dataclasses import dataclass
from itertools import dropwhile
from typing import Any

from end_effector_hal.vocabulary import ChangerState
from end_effector_hal.vocabulary import EndEffectorState as State
from tests.acceptance.kill_matrix.cells import GRIPPED, STOPPED_S, Cell
from tests.acceptance.kill_matrix.expected import Expected, Switch, expected, one_of, told
from tests.acceptance.kill_matrix.hands import SUCCEEDED
from tests.acceptance.kill_matrix.prepare import GONE, Prepared, prepare
from tests.acceptance.kill_matrix.system import System, lives
from tests.acceptance.kill_matrix.waiting import Late, pause, until

SETTLED_S = 30.0
NOTICED_S = 2.5
"""A program whose lease is over learns so from the line arbiter; on a busy machine a little later. An arbiter that is
stopped does nothing before it goes on."""


@dataclass(frozen=True)
class Row:
    """What became of a cell."""

    cell: Cell
    expected: str
    observed: str
    ok: bool
    seconds: float
    before: str = ""
    """What was observed when it was played first and did not hold."""

    def as_json(self) -> dict[str, object]:
        """As it is kept."""
        process, name, state = self.cell.process, self.cell.signal, self.cell.state
        return {
            "process": process, "signal": name, "state": state,
            "expected": self.expected, "observed": self.observed, "ok": self.ok, "seconds": round(self.seconds, 1),
            **({"first": self.before} if self.before else {}),
        }  # fmt: skip


class Play:
    """A cell on a running system."""

    def __init__(self, system: System, cell: Cell) -> None:
        self.system, self.cell = system, cell
        description = system.description
        self.expected: Expected = expected(description, cell)
        self.names = {actuator.line: name for name, actuator in description.ordered}
        self.gripping = tuple(self.names)
        self.changer = description.tool_changer.line if description.tool_changer else ""
        self.names[self.changer] = "unlock"
        self.faults: list[str] = []

    def run(self) -> Row:
        """Play it; raises Late only when the state of the cell cannot be reached."""
        begun = time.monotonic()
        prepared = prepare(self.system, self.cell)
        self.mark, self.seen = self.system.observer.mark(), len(self.system.hands.changes)
        wanted = self.expected.text(self.names)
        try:
            self._hit(prepared)
            self._settle()
            self._compare(prepared)
        except Late as late:
            self.faults.append(f"{late}; {self.system.why_not_up()}")
        observed = self._observed()
        if not self.faults:
            with suppress(Late):
                self._use(prepared)
        if prepared.supervisor is not None:
            prepared.supervisor.end(patience_s=1.0)
        ok = not self.faults
        text = observed if ok else f"{observed}. {'; '.join(self.faults)}"
        return Row(self.cell, wanted, text, ok, time.monotonic() - begun)

    # Hit it, and have it back

    def _hit(self, prepared: Prepared) -> None:
        cell, system = self.cell, self.system
        pids = self._pids(prepared)
        if not pids:
            raise Late(f"there is no process {cell.process}")
        self.hit_at = time.monotonic()
        for pid in pids:
            with suppress(ProcessLookupError):
                os.kill(pid, cell.number)
        if cell.ends and system.ends_the_client(cell.process):
            self.system.begin_anew(pids)
            self.seen = 0
            return
        if cell.process != "testbench":
            system.plant.choose("nominal")
        if cell.signal == "SIGSTOP":
            pause(STOPPED_S)
            for pid in pids:
                os.kill(pid, signal.SIGCONT)
        until(f"the end of {cell.process}", lambda: not cell.ends or not any(map(lives, pids)), 10.0)
        if cell.process == "testbench":
            if cell.ends:
                system.plant.power_up()
                system.plant.wait_ready()
            else:
                system.plant.choose("nominal")
        elif cell.process != "Supervisor":
            until(f"{cell.process} again", lambda: self._pids(prepared), 20.0)

    def _pids(self, prepared: Prepared) -> list[int]:
        if self.cell.process == "Supervisor":
            return self.system.pids("supervisor") or [prepared.supervisor.pid] if prepared.supervisor else []
        return self.system.pids(self.cell.process)

    # What follows

    def _settle(self) -> None:
        since = time.monotonic()

        def settled() -> bool:
            state, heard = self.system.hands.look(), self.system.hands.heard
            fresh = heard and min(heard.values()) > since
            still = state["command"] == -1 and state["state"] not in (
                State.OFF,
                State.GRIPPING,
                State.RELEASING,
            )
            moving = state["tool_changer"] in (
                ChangerState.LOCKING,
                ChangerState.UNLOCKING,
                ChangerState.UNLOCKED,
            )
            return bool(fresh and still and not moving and self.system.is_up())

        until("the end of all movement", settled, SETTLED_S)
        # wills take their time, and are executed even when everybody is content; what is read is proven a little later
        with suppress(Late):
            until("the declared end", self._is_over, 8.0)

    def _wanted(self, state: dict[str, Any]) -> Expected:
        active = self.system.observer.active()
        kept = self.expected.may_keep and State(state["state"]) is State.GRIP_ERROR and active
        return self.expected.kept(len(active)) if kept else self.expected

    def _is_over(self) -> bool:
        state = self.system.hands.look()
        want = self._wanted(state)
        proven = State(state["state"]) in want.states
        return proven and self._changer_is_as_declared(state) and self.system.observer.active() == want.active

    def _compare(self, prepared: Prepared) -> None:
        state = self.system.hands.look()
        want = self._wanted(state)
        if self.system.observer.active() != want.active:
            self.faults.append("other lines are active")
        if State(state["state"]) not in want.states:
            self.faults.append(f"not {one_of(want.states)}")
        if not self._changer_is_as_declared(state):
            self.faults.append(f"the tool changer is {ChangerState(state['tool_changer']).name}")
        gripping, unlock = self._moved((*self.gripping,)), self._moved((self.changer,))
        if _without_retries(gripping, want) != want.gripping or unlock != want.unlock:
            self.faults.append("the lines moved otherwise")
        first = self.system.observer.first(self.mark)
        if want.first_s and first and first / 1e6 - self.hit_at > want.first_s:
            self.faults.append(f"nothing moved for {first / 1e6 - self.hit_at:.1f} s")
        if state["held"] != bool(want.active):
            self.faults.append(f"held is {state['held']}")
        if self.system.observer.both_coils:
            self.faults.append(f"both coils of {', '.join(self.system.observer.both_coils)} were active")
        self._lies(prepared)

    def _changer_is_as_declared(self, state: dict[str, Any]) -> bool:
        return not self.changer or ChangerState(state["tool_changer"]) in self.expected.changers

    def _lies(self, prepared: Prepared) -> None:
        """Nobody may claim a grip that is not there."""
        if State.GRIPPED in self.expected.states:
            return
        if any(map(self._claims, self._said())):
            self.faults.append("GRIPPED was claimed")
        ended = self.system.hands.result(prepared.goal) if prepared.goal else None
        if ended and ended["name"] == "grip" and ended["outcome"] == SUCCEEDED and ended["succeeded"]:
            self.faults.append("the goal succeeded")

    def _claims(self, said: dict[str, Any]) -> bool:
        """A grip; one that was there before is claimed only by who allows a lift (a program that hung asks first)."""
        was_there = self.cell.state == GRIPPED
        return said["state"] == State.GRIPPED and (said["lift_allowed"] or not was_there)

    def _said(self) -> list[dict[str, Any]]:
        """What was told since; not what is told of a grip that was there, until its end is noticed."""
        told = self.system.hands.changes[self.seen :]
        if self.cell.state != GRIPPED:
            return told
        limit = (self.hit_at + NOTICED_S + (0.0 if self.cell.ends else STOPPED_S)) * 1e6
        return list(dropwhile(lambda each: each["state"] == State.GRIPPED and each["at_us"] < limit, told))

    def _moved(self, lines: tuple[str, ...]) -> tuple[Switch, ...]:
        return tuple(self.system.observer.since(self.mark, lines))

    def _observed(self) -> str:
        state = self.system.hands.look()
        name = State(state["state"]).name if state else "silent"
        self._after = self.system.observer.mark()
        return f"{name}; {told((*self._moved((self.changer,)), *self._moved(self.gripping)), self.names)}"

    # Use it again

    def _use(self, prepared: Prepared) -> None:
        """A drop, a grip, a drop, without any repair; a lock first if the tool is not locked."""
        try:
            if prepared.supervisor is not None:
                return self._use_supervisor()
            state = self.system.hands.look()
            if self.changer and state["tool_changer"] == ChangerState.UNKNOWN:
                with suppress(Late):  # a program that began anew adopts first
                    until("what the tool changer is", self._changer_is_known, 6.0)
            if self.changer and self.system.hands.look()["tool_changer"] != ChangerState.LOCKED:
                self._do("lock")
            if state["state"] == State.RELEASE_ERROR:
                self._wait_for_absence()  # a drop proves it, and latches again while air still comes in
            if state["state"] != State.STAND_BY:
                self._drop()
            self._wait_for_absence()
            self._do("grip")
            if self.system.observer.active() != set(self.gripping):
                self.faults.append("gripped, but not every line is active")
            self._drop()
            if self.system.observer.active():
                self.faults.append("dropped, but a line is active")
        except Late as late:
            self.faults.append(f"not usable: {late}")
        return None

    def _changer_is_known(self) -> bool:
        return bool(self.system.hands.look()["tool_changer"] != ChangerState.UNKNOWN)

    def _use_supervisor(self) -> None:
        """Another one gives the commands; it ends with 1 when any did not succeed."""
        held = self.system.hands.look()["held"]
        script = f"{'drop; ' if held else ''}wait 1; grip; drop; quit"
        again = self.system.supervisor(script)
        if again.wait_for_end(timeout_s=40.0):
            self.faults.append(f"another Supervisor: {again.text().strip().splitlines()[-1:]}")

    def _drop(self) -> None:
        """Once more when a reading was stale at its end (a machine at its limits): it is latched until then."""
        if self.system.hands.run("drop")["outcome"] != SUCCEEDED:
            self._wait_for_absence()
            self._do("drop")

    def _wait_for_absence(self) -> None:
        until("absence of all", lambda: set(self.system.hands.look()["evidence"]) == {GONE}, 10.0)

    def _do(self, name: str) -> None:
        ended = self.system.hands.run(name)
        if ended["outcome"] != SUCCEEDED:
            raise Late(f"{name}: {ended['reason']}")


def _without_retries(moved: tuple[Switch, ...], want: Expected) -> tuple[Switch, ...]:
    """A step that is attempted again goes off and on: allowed while a grip goes on."""
    if want.why != "grip goes on" and not any(level for _, level in want.gripping):
        return moved
    kept: list[Switch] = []
    for line, level in moved:
        if level and kept and kept[-1] == (line, False):
            kept.pop()
        else:
            kept.append((line, level))
    return tuple(kept)
