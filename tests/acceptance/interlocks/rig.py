"""One end-effector in this process: real line arbiter on a real socket, real program, simulated sensors."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

from end_effector_hal.arbiter import (
    ArbiterClient,
    ArbiterServer,
    PredicatePublisher,
    arbiter_policy,
)
from end_effector_hal.control import Answer
from end_effector_hal.control.goals import CHANNELS
from end_effector_hal.description import Description, EStop, load, profile_path
from end_effector_hal.errors import ReportedError
from end_effector_hal.kinds.stanza import BlowOff
from end_effector_hal.kinds.vacuum import VacuumActuator
from end_effector_hal.runtime import GoalRunner, open_program
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ChangerState
from end_effector_hal.vocabulary import EndEffectorState as State
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import VirtualChip, VirtualLines

UNLOCK, BOTTOM, CYLINDER, TOP = "SODIMM_206", "SODIMM_208", "SODIMM_210", "SODIMM_212"
BLOW_OFF = "SODIMM_214"
LONGEST_S = 15.0
LEASE_US = 60_000_000
"""Program, arbiter and sensors share one process: on a busy machine a thread may not renew a lease within a second."""
COMMANDS = {channel: command for command, channel in CHANNELS.items()}


def quick() -> Description:
    """The shipped tool with short times, a blow-off valve and an e-stop: whatever an interlock can need."""
    tool = load(profile_path())
    short = {"timeout_s": 0.5, "reset_s": 0.05, "release_s": 0.5, "attempts": 1}
    actuators = {name: actuator.model_copy(update=short) for name, actuator in tool.actuators.items()}
    bottom = actuators["bottom_vacuum"]
    assert isinstance(bottom, VacuumActuator)
    actuators["bottom_vacuum"] = bottom.model_copy(update={"blow_off": BlowOff(line=BLOW_OFF)})
    changer = tool.tool_changer.model_copy(update={"prove_s": 0.5, "unlock_max_s": 0.8})
    return tool.model_copy(update={"actuators": actuators, "tool_changer": changer, "e_stop": EStop()})


class Rig:
    """Answers every line as its device would; ``odd`` are channels that show something else.

    ``silent``: no frame comes. ``program``: there is the HAL; without it the lines are free for a hand.
    """

    def __init__(self, folder: Path, *, program: bool = True) -> None:
        self.description = quick().with_virtual(folder / "chip", "none", folder / "arbiter.sock")
        self.chip = VirtualChip.create(folder / "chip", self.description.output_lines).path
        self.socket = folder / "arbiter.sock"
        self.odd: dict[str, int | bool | None] = {}
        self.silent = False
        self.program, self._frames = program, 0
        self._ended = threading.Event()
        self._stack = ExitStack()

    def __enter__(self) -> Rig:
        policy = replace(arbiter_policy(self.description), lease_us=LEASE_US)
        self.arbiter = ArbiterServer(VirtualLines(self.chip), self.socket, policy)
        serving = threading.Thread(target=self.arbiter.run)
        serving.start()
        self._stack.callback(self.arbiter.close)
        self._stack.callback(serving.join)
        self._stack.callback(self.arbiter.stop)
        self._stack.callback(self.arbiter.stop)
        self.predicates = PredicatePublisher(self.description)
        self._stack.callback(self.predicates.close)
        if self.program:
            self.start()
            self._goals = GoalRunner(self.hal, lambda: self.hal.status)
            self._stack.callback(lambda: self.hal.close())
        feeding = threading.Thread(target=self._feed)
        feeding.start()
        self._stack.callback(feeding.join)
        self._stack.callback(self._ended.set)
        with ArbiterClient(self.socket, "look") as look:
            self.until(
                lambda: bool(told := look.status()["told"]) and all(one["holds"] for one in told.values())
            )
        if self.program:
            self.until(lambda: self.hal.status.ee == State.STAND_BY)
            self.until(lambda: self.hal.status.changer == ChangerState.LOCKED)
        return self

    def start(self) -> None:
        """Start the program, which tells the arbiter what its sensors prove."""
        self.hal = open_program(self.description, publisher=self.predicates)
        self.hal.start()

    def __exit__(self, *_: object) -> None:
        self.silent = False
        self._stack.close()

    def until(self, condition: Callable[[], bool]) -> None:
        end = time.monotonic() + LONGEST_S
        while not condition():
            assert time.monotonic() < end, f"it did not happen; {self.hal.status if self.program else ''}"
            time.sleep(0.01)

    def show(self, **odd: int | bool | None) -> None:
        """What some channels show from now on, for ten frames at least."""
        self.odd |= odd
        shown = self._frames + 10
        self.until(lambda: self._frames >= shown)

    @contextmanager
    def hand(self, *lines: str) -> Iterator[ArbiterClient]:
        """A client of the socket that is none of ours."""
        with ArbiterClient(self.socket, "hand", lines) as client:
            yield client

    def faults(self) -> dict[str, str]:
        with ArbiterClient(self.socket, "look") as look:
            return dict(look.status()["faults"])

    # The action door, as HALMain and `EndEffector` open it.

    def action(self, command: str) -> str:
        """The reason of a goal that failed; empty: it succeeded."""
        if command == "cancel":
            return self.hal.command(command).reason
        return self._goals.begin(COMMANDS[command]).wait().reason

    # The service door: the /Set* services.

    def service(self, actuator: str, active: bool) -> Answer:
        if actuator == "tool_changer":
            why = self.action("unlock" if active else "lock")
            return Answer(not why, why)
        return self.hal.set_actuator(actuator, active)

    def gripped(self) -> None:
        """What a frame proves expires within 150 ms: a busy machine may have a grip refused until the next ones."""
        self.until(lambda: not self.action("grip"))

    def _feed(self) -> None:
        while not self._ended.wait(0.02):
            seq = self._frames = self._frames + 1
            if not self.silent:
                frame = Frame(now_us(), seq, seq * 20, self._values())
                (self.hal if self.program else self.predicates).frame(frame)

    def _values(self) -> dict[str, int | bool | None]:
        on = self.arbiter.levels()
        return {
            "bottom": -80_000 if on[BOTTOM] else 0, "top": -80_000 if on[TOP] else 0,
            "cylinder": 600_000 if on[CYLINDER] else 0, "supply": 600_000,
            "cylinder_extended": on[CYLINDER], "cylinder_retracted": not on[CYLINDER],
            "locked": not on[UNLOCK], "unlocked": on[UNLOCK],
            "tool_present": True, "in_stand": True, "estop_ok": True,
        } | self.odd  # fmt: skip


def refusal(client: ArbiterClient, line: str, **more: object) -> str:
    """The sentence of the arbiter; it must refuse."""
    try:
        client.set({line: True}, **more)  # type: ignore[arg-type]
    except ReportedError as error:
        return str(error)
    raise AssertionError(f"{line} was activated")
