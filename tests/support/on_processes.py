"""Plays a case on real processes in real time: the testbench, the line arbiter, and `eehal run` as the whole HAL.

A dead process is restarted as a service manager does, until it keeps running. A restart takes a second, but no virtual
time; so a case whose events are closer together may end differently.
"""

from __future__ import annotations

import json
import os
import signal
import time
from contextlib import suppress
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires.lines import ChipLog
from end_effector_hal.wires.lines import Edge as LineEdge
from end_effector_lab.demo import World
from end_effector_lab.processes import EEHAL, Child
from end_effector_lab.trials import Case
from end_effector_lab.trials._case import (
    ARBITER,
    COMMANDS,
    DISK,
    END,
    HAL,
    KILL,
    POWER,
    SCENARIO,
    START,
    CaseEnd,
)
from end_effector_lab.trials._play import AT_REST, processes
from end_effector_lab.virtual import Edge, switchings

START_S, POLL_S, AGAIN_S, STILL_S = 60.0, 0.05, 0.3, 1.0


def play_on_processes(description: Description, case: Case, folder: Path, *, lasts_s: float = 0.0) -> CaseEnd:
    """Play a case on real processes.

    Args:
        case: the events.
        folder: receives the logs.
        lasts_s: shortest time for which the tool is followed after the first event, s: some faults act slowly.

    Raises:
        UsageError: an event has no counterpart: a full disk, a loss of power.
        ReportedError: a process does not start, or the tool does not come to rest.
    """
    for each in case.happenings:
        if each.verb in (DISK, POWER):
            raise UsageError(
                f"{each.what!r} is played in virtual time only: it would be a machine of its own.",
                todo="Leave it out.",
            )
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.log"):
        old.unlink()
    with World(description, "nominal", folder) as world:
        return _ProcessRun(world).played(case, lasts_s)


class _ProcessRun:
    def __init__(self, world: World) -> None:
        self._world = world
        self._children: dict[str, Child | None] = {ARBITER: world.arbiter, HAL: None}
        self._wanted = {ARBITER, HAL}
        self._begin_at = dict.fromkeys(self._children, 0.0)
        self._lives = 0

    def played(self, case: Case, lasts_s: float) -> CaseEnd:
        """Play the case once."""
        self._wait_until_at_rest(START_S, {EndEffectorState.STAND_BY})
        self._keep(0.5)
        marks = len(self._edges())
        begun = time.monotonic()
        for each in case.happenings:
            self._keep(begun + each.at / 1e6 - time.monotonic())
            self._act(each.what)
        self._keep(begun + lasts_s - time.monotonic())
        longest = self._world.description.durations
        if HAL not in self._wanted:
            self._keep(longest.release_ms / 1000 + 3.0)
            return self._end("", marks)
        state = self._wait_until_at_rest(
            (longest.grip_ms + longest.release_ms) / 1000 + START_S, set(AT_REST)
        )
        return self._end(state.name, marks)

    def _end(self, state: str, marks: int) -> CaseEnd:
        edges = [Edge(edge.at, edge.line, edge.active) for edge in self._edges()]
        every = list(switchings(self._world.description, edges))
        moved = every[len(list(switchings(self._world.description, edges[:marks]))) :]
        return CaseEnd.of(self._world.description, state, every, moved)

    def _edges(self) -> list[LineEdge]:
        return list(ChipLog().feed(self._world.chip.read_bytes()))

    def _act(self, what: str) -> None:
        verb, _, rest = what.partition(" ")
        if what in COMMANDS:
            hal = self._children[HAL]
            if hal is not None and hal.code is None:
                with suppress(ReportedError):  # it has just died
                    hal.tell(what if what in ("cancel", "resume", "arm") else f"{what} &")
        elif verb == SCENARIO:
            self._world.choose(rest)
        elif verb == START:
            self._wanted |= set(processes(rest))
            self._keep(0.0)
        else:
            self._wanted -= set(processes(rest))
            dying = [child for name in processes(rest) if (child := self._take(name)) is not None]
            if verb == KILL:  # the arbiter first: it has no moment for a last will
                for child in reversed(dying):
                    os.kill(child.pid, signal.SIGKILL)
            for child in dying:
                if verb == END:
                    os.kill(child.pid, signal.SIGTERM)
                child.wait_for_end(timeout_s=START_S)

    def _take(self, name: str) -> Child | None:
        """Remove and return the process if it lives; afterwards another one replaces it."""
        child, self._children[name] = self._children[name], None
        return child if child is not None and child.code is None else None

    # Who is to live, lives

    def _keep(self, seconds: float) -> None:
        """Wait, and restart processes that have ended but should run."""
        until = time.monotonic() + seconds
        while True:
            for name in (ARBITER, HAL):
                child = self._children[name]
                gone = child is None or child.code is not None
                if name in self._wanted and gone and time.monotonic() >= self._begin_at[name]:
                    self._begin_at[name] = time.monotonic() + AGAIN_S
                    self._start(name)
            left = until - time.monotonic()
            if left <= 0:
                return
            time.sleep(min(left, POLL_S))

    def _start(self, name: str) -> None:
        path, self._lives = str(self._world.description_path), self._lives + 1
        words = ["arbiter", path] if name == ARBITER else ["run", path, "--json"]
        self._children[name] = self._world.children.start(
            f"{name} {self._lives}",
            [*EEHAL, *words],
            log=self._world.folder / f"{name}-{self._lives}.log",
            commands=name == HAL,
            outlives_us=name == ARBITER,
        )

    def _wait_until_at_rest(self, seconds: float, states: set[EndEffectorState]) -> EndEffectorState:
        """Wait until the HAL has been in one of these states for a while without activity."""
        limit, since, last = time.monotonic() + seconds, time.monotonic(), ("", -1)
        while time.monotonic() < limit:
            self._keep(POLL_S * 4)
            found = self._status()
            now = (str(found.get("state_name", "")), len(self._edges()))
            if now != last or found.get("command") != -1:
                since, last = time.monotonic(), now
            at_rest = now[0] in {state.name for state in states}
            if at_rest and time.monotonic() - since > STILL_S:
                return EndEffectorState[now[0]]
        raise ReportedError(
            f"The tool does not come to rest in {seconds:g} s.",
            where=str(self._world.folder),
            todo="Read its logs.",
        )

    def _status(self) -> dict[str, object]:
        """Request a status from the HAL and return the newest one."""
        hal = self._children[HAL]
        if hal is None or hal.code is not None:
            return {}
        with suppress(ReportedError):
            hal.tell("status")
        for line in reversed(hal.text().splitlines()):
            with suppress(ValueError):
                found = json.loads(line)
                if found.get("event") == "status":
                    return dict(found)
        return {}
