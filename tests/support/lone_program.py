"""A program alone: a line arbiter and sensors that do what a test says."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from end_effector_hal.control import Status
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.runtime import Program
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import NO_PART, LastWillStep, WrittenPart
from end_effector_hal.vocabulary import EndEffectorState as State
from end_effector_hal.wires import now_us
from tests.support.patience import PATIENCE_S

BOTTOM, CYLINDER, TOP = LINES = ("SODIMM_208", "SODIMM_210", "SODIMM_212")
UNLOCK = "SODIMM_206"
OFF, ON = False, True


class Arbiter:
    """A line arbiter that does what a test says; ``active`` are the lines of the actuators, nobody unlocks the tool."""

    def __init__(self) -> None:
        self.active = dict.fromkeys(LINES, OFF)
        self.error: OSError | None = None
        self.will: tuple[LastWillStep, ...] = ()
        self.parting: tuple[LastWillStep, ...] | None = None
        self.took_for_dead = False

    def recorded_part(self) -> str:
        return ""

    def declared_dead(self) -> bool:
        told, self.took_for_dead = self.took_for_dead, False
        return told

    def levels(self) -> Mapping[str, bool]:
        if self.error:
            raise self.error
        return {**self.active, UNLOCK: OFF}

    def status(self) -> dict[str, Any]:
        return {"faults": {}}

    def latch(self, fault: str, why: str) -> None:
        raise AssertionError(why)

    def clear(self, fault: str) -> None:
        raise AssertionError(fault)

    def ask(
        self,
        levels: Mapping[str, bool],
        will: Sequence[LastWillStep],
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> Callable[[], int]:
        def wait() -> int:
            if self.error:
                raise self.error
            self.active |= {line: level for line, level in levels.items() if line != UNLOCK}
            self.will = tuple(will)
            return 0

        return wait

    def close(self, will: Sequence[LastWillStep]) -> None:
        self.parting = tuple(will)


class Tool:
    """A program, and what its sensors show."""

    def __init__(self, description: Description | None = None) -> None:
        self.arbiter, self.told = Arbiter(), list[Status]()
        self.program = Program(description or load(profile_path()), self.arbiter, self.told.append)
        self.confirmed = dict.fromkeys(LINES, OFF)
        self._seq = 0

    def until(self, what: Callable[[Status], bool], timeout_s: float = PATIENCE_S) -> Status:
        """Frames, until a status is as wanted."""
        end = time.monotonic() + timeout_s
        while not what(self.program.status):
            assert time.monotonic() < end, self.program.status
            self.frame()
            threading.Event().wait(0.01)
        return self.program.status

    def frame(self, age_us: int = 0) -> None:
        self._seq += 1
        bottom, cylinder, top = (self.confirmed[line] for line in LINES)
        values = {
            "bottom": -80_000 if bottom else 0, "top": -80_000 if top else 0,
            "cylinder": 600_000 if cylinder else 0, "supply": 600_000,
            "cylinder_extended": cylinder, "cylinder_retracted": not cylinder,
            "locked": True, "unlocked": False, "tool_present": True, "in_stand": True, "estop_ok": True,
        }  # fmt: skip
        self.program.frame(Frame(now_us() - age_us, self._seq, self._seq * 20, values))

    def states(self) -> list[State]:
        """Each once, in order."""
        seen = [State(status.ee) for status in self.told]
        return [state for i, state in enumerate(seen) if i == 0 or seen[i - 1] != state]

    def grip_to(self, step: int) -> None:
        """In GRIPPING, with the steps before confirmed."""
        self.until(lambda status: status.ee == State.STAND_BY and set(status.evidence) == {1})
        assert self.program.command("grip").accepted
        for line in LINES[:step]:
            self.until(lambda _, line=line: self.arbiter.active[line])
            self.confirmed[line] = ON
        self.until(lambda status: status.outputs[step])
