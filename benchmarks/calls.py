"""Counts the Python function calls on the first visit of a state, from an event to a line.

``python benchmarks/calls.py [--profile]`` prints three numbers: from a frame to a line, from a goal to a line, and
from the death of the program, once the line arbiter has detected it (`LineArbiter.declare_dead`), to its last will. The
program and the line arbiter run in this process, with a chip in memory behind the arbiter's real socket. Calls are
counted in the thread that delivers the event, up to the write to the arbiter, and in the arbiter, up to the write to
the chip; nothing is logged. Each path is run in three fresh tools, and the least count is used, since a renewal of a
lease may come between. ``--profile`` also lists the functions.
"""

from __future__ import annotations

import argparse
import logging
import os
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from types import FrameType

from end_effector_hal.arbiter import ArbiterClient, ArbiterServer, PredicatePublisher, arbiter_policy
from end_effector_hal.control import Answer
from end_effector_hal.description import Description, load, profile_path, socket_path
from end_effector_hal.runtime import open_program
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import EndEffectorState, Evidence, LastWillStep
from end_effector_hal.wires import now_us

PERIOD_S, MOST_FRAMES, RUNS = 0.02, 500, 3
SETTLED_S = 0.2  # a line that was just switched is not switched again at once (IL-10)
AT_REST = {
    "bottom": 0, "cylinder": 0, "top": 0, "supply": 600_000, "cylinder_extended": False, "cylinder_retracted": True,
    "locked": True, "unlocked": False, "tool_present": True, "in_stand": True, "estop_ok": True,
}  # fmt: skip


class Count:
    """A profiler that counts calls of Python functions up to ``reached``; functions of this file are not counted.

    ``first``: the name of the function at which the path begins; empty: at once.
    """

    def __init__(self, first: str = "") -> None:
        self.calls: Counter[str] = Counter()
        self.reached: Counter[str] | None = None
        self._first = first

    def __call__(self, frame: FrameType, event: str, what: object) -> None:
        code = frame.f_code
        if event == "call" and self.reached is None and code.co_filename != __file__:
            if not self._first or code.co_name == self._first:
                self._first = ""
                path = Path(code.co_filename)
                self.calls[f"{path.parent.name}/{path.name}:{code.co_qualname}"] += 1
        elif event == "c_call" and getattr(what, "__name__", "") == "sendall":
            self.stop()

    def stop(self) -> None:
        """Mark the end of the path, at the first call only."""
        if self.reached is None:
            self.reached = self.calls
            self.calls = Counter()  # after the end: it is a call, too

    def of(self, path: Callable[[], object]) -> Counter[str] | None:
        """Count the calls of a path in this thread, up to its end; None: the end was not reached."""
        sys.setprofile(self)
        try:
            path()
        finally:
            sys.setprofile(None)
        return self.reached


class _DeathError(Exception):
    """Ends a client without closing it properly."""


class Chip:
    """A chip whose lines are in memory."""

    def __init__(self) -> None:
        self.active: dict[str, bool] = {}
        self.count: Count | None = None

    def request(self, names: list[str]) -> dict[str, bool]:
        self.active = dict.fromkeys(names, False)
        return self.levels()

    def levels(self) -> dict[str, bool]:
        return dict(self.active)

    def set(self, levels: Mapping[str, bool]) -> None:
        if self.count is not None:
            self.count.stop()
        self.active |= levels

    def close(self) -> None:
        """Do nothing, since nothing is open."""


class Tool:
    """The shipped tool: its program and the arbiter, which runs in its own thread except while it is counted."""

    def __init__(self, folder: Path) -> None:
        os.environ["EEHAL_RUN_DIR"] = str(folder)
        self.description: Description = load(profile_path())
        self.chip, self._number = Chip(), 0
        self.arbiter = ArbiterServer(
            self.chip, socket_path(self.description), arbiter_policy(self.description)
        )
        self._serves, self._ended = threading.Lock(), threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()
        self.predicates = PredicatePublisher(self.description)
        self.program = open_program(self.description, publisher=self.predicates)
        self.program.start()

    def _serve(self) -> None:
        while not self._ended.wait(0.0005):
            with self._serves:
                self.arbiter.step(0)

    def frame(self) -> Frame:
        """Return sensor values that match the lines; they vary, since a constant sensor counts as frozen."""
        self._number += 1
        values: dict[str, int | bool | None] = dict(AT_REST)
        for name, actuator in self.description.ordered:
            if self.chip.active[actuator.line]:
                shown = -80_000 if name.endswith("vacuum") else 600_000
                values[actuator.channel] = shown
                if name == "cylinder":
                    values |= {"cylinder_extended": True, "cylinder_retracted": False}
        noise = 25 * (self._number % 4)
        values |= {each: int(values[each] or 0) + noise for each in ("bottom", "cylinder", "top", "supply")}
        return Frame(now_us(), self._number, self._number * 20, values)

    def deliver(self, frame: Frame) -> None:
        """Process a frame, as in the thread of the link."""
        self.program.frame(frame)

    def until(self, reached: Callable[[], bool]) -> None:
        """Deliver frames until a condition holds."""
        for _ in range(MOST_FRAMES):
            if reached():
                return
            self.deliver(self.frame())
            time.sleep(PERIOD_S)
        raise SystemExit(f"The tool did not come so far: {self.program.status}.")

    def ready(self) -> bool:
        """Return whether a grip can begin."""
        status = self.program.status
        return (
            status.ee == EndEffectorState.STAND_BY
            and Evidence.UNKNOWN not in status.evidence
            and status.vented
        )

    def from_frame(self) -> Counter[str]:
        """Count from the frame that confirms the first actuator to the line of the second."""
        self._accepted(self.program.command("grip"))
        for _ in range(MOST_FRAMES):
            time.sleep(PERIOD_S)
            frame = self.frame()
            with self._serves:
                if sent := Count().of(lambda frame=frame: self.deliver(frame)):
                    return sent + self._arbiter_until_line()
        raise SystemExit(f"No line followed a frame: {self.program.status}.")

    @staticmethod
    def _accepted(answer: Answer) -> None:
        if not answer.accepted:
            raise SystemExit(f"The command was refused: {answer.reason}")

    def from_goal(self) -> Counter[str]:
        """Count from the command to the first line."""
        count, answers = Count(), list[Answer]()

        def command() -> None:
            count.of(lambda: answers.append(self.program.command("grip")))

        with self._serves:
            thread = threading.Thread(target=command)
            thread.start()
            while count.reached is None and thread.is_alive():
                time.sleep(0.001)
            if answers:
                self._accepted(answers[0])
            found = self._arbiter_until_line()
        thread.join()
        assert count.reached is not None
        return count.reached + found

    def from_death(self) -> Counter[str]:
        """Count from the detected death of a program to the first line of its last will."""
        self.program.close()
        predicates = PredicatePublisher(self.description)
        line = self.description.ordered[0][1].line
        with suppress(_DeathError), ArbiterClient(socket_path(self.description), "dying", [line]) as dying:
            predicates.frame(self.frame())
            dying.set({line: True}, [LastWillStep(line)])
            time.sleep(SETTLED_S)
            self._serves.acquire()
            raise _DeathError
        try:
            return self._arbiter_until_line("declare_dead")
        finally:
            self._serves.release()

    def _arbiter_until_line(self, first: str = "") -> Counter[str]:
        """Count the arbiter's calls in the cycle in which it writes a line."""
        for _ in range(MOST_FRAMES):
            self.chip.count = count = Count(first)
            if found := count.of(lambda: self.arbiter.step(0.01)):
                return found
        raise SystemExit("The arbiter has written no line.")

    def close(self) -> None:
        """End the program, then the arbiter."""
        self.program.close()
        self.predicates.close()
        self._ended.set()
        self._thread.join()
        self.arbiter.close()


def counted(path: Callable[[Tool], Counter[str]]) -> Counter[str]:
    """Return the least count of some runs."""
    found = []
    for _ in range(RUNS):
        with tempfile.TemporaryDirectory() as folder:
            tool = Tool(Path(folder))
            tool.until(tool.ready)
            found.append(path(tool))
            tool.close()
    return min(found, key=Counter.total)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--profile", action="store_true", help="list the functions")
    profile = parser.parse_args().profile
    logging.disable()
    for name, path in (
        ("from a frame to a line", Tool.from_frame),
        ("from a goal to a line", Tool.from_goal),
        ("from death to the last will", Tool.from_death),
    ):
        calls = counted(path)
        print(f"{name:30}{calls.total():6}", flush=True)
        if profile:
            print("\n".join(f"{number:10}  {what}" for what, number in calls.most_common()))


if __name__ == "__main__":
    main()
