"""A gripper that is commanded over its bus, with real processes: a pty, and a 2F-85 or an EPick at its far end."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.codecs import load_tool
from end_effector_hal.errors import NotReadyError
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import Command, EndEffectorState, Evidence
from end_effector_hal.wires import now_us
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL, Child
from end_effector_lab.testbench._ports import PtyPort
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.robotiq import Gripper2F85, SimulatedEPick
from tests.support.rtu_server import RtuServer

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
TOOLS = Path(__file__).parents[3] / "examples" / "tools"
READY_S = 30.0
OPEN, CLOSE = (0x0900, 0, 0xFFFF), (0x0900, 0x00FF, 0xFFFF)


class Cable:
    """A pty with one device of Robotiq's at its far end; ``cut`` while nothing passes."""

    def __init__(self, place: Path, device: Gripper2F85 | SimulatedEPick) -> None:
        self.port, self.device, self.cut = str(place / "uart"), device, False
        self._pty = PtyPort(self.port)
        self._pty.open()
        self._server, self._ended = RtuServer({9: device}), threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._pty.close()

    def _serve(self) -> None:
        while not self._ended.is_set():
            request = self._pty.receive(0.05)
            if request and not self.cut and (answer := self._server.answer(request, now_us())):
                self._pty.send(answer)


def releasing(text: str) -> str:
    """A description of one actuator, whose output is made inactive at a start."""
    before = "device: robotiq-epick"
    assert before in text
    return (
        text.replace(before, f"{before}, endings: {{power_up: release}}") + "\ninterlocks: {IL-09: false}\n"
    )


class Rig:
    """Cable and line arbiter; programs are started by the tests."""

    def __init__(
        self, name: str, device: Gripper2F85 | SimulatedEPick, folder: Path, *, power_up: str = "hold"
    ) -> None:
        path = TOOLS / name / "end_effector.yaml"
        if power_up == "release":
            text, path = path.read_text("utf-8"), folder / "declared.yaml"
            path.write_text(releasing(text), "utf-8")
        tool = load_tool(path)
        self.cable, self.device = Cable(folder, device), device
        self.world = World(
            tool.with_virtual(folder / "chip", self.cable.port), "nominal", folder, own_wires=True
        )
        self.folder = folder

    def __enter__(self) -> Rig:
        self.world.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self.world.__exit__(*error)
        self.cable.close()

    def kill_arbiter(self) -> None:
        with ArbiterClient(self.world.socket, "test") as observer:
            os.kill(observer.status()["pid"], signal.SIGKILL)

    def arbiter_again(self) -> Child:
        again = self.world.children.start(
            "line arbiter again",
            [*EEHAL, "arbiter", str(self.world.description_path)],
            log=self.folder / "again.log",
        )
        again.wait_until(lambda: "ready:" in again.text(), timeout_s=PATIENCE_S, what="it was ready")
        return again

    @contextmanager
    def ready(self) -> Iterator[EndEffector]:
        """A program in this process, once it knows the tool's state."""
        with EndEffector.open(self.world.description) as tool:
            tool.wait_ready(READY_S)
            yield tool

    @contextmanager
    def gripping(self) -> Iterator[EndEffector]:
        """The same, which has gripped."""
        with self.ready() as tool:
            wait_until("a grip", lambda: tool.grip().succeeded)
            yield tool

    def program(self, script: str) -> Child:
        command = [*EEHAL, "run", str(self.world.description_path), "--script", script]
        return self.world.children.start("program", command, log=self.folder / "run.log")

    def faults(self) -> str:
        with ArbiterClient(self.world.socket, "test") as observer:
            return " ".join(observer.status()["faults"].values())


@pytest.fixture
def gripper(tmp_path: Path) -> Iterator[Rig]:
    with Rig("gripper_2f85", Gripper2F85(now_us()), tmp_path) as rig:
        yield rig


def test_it_grips_and_drops_and_an_empty_grip_says_so(gripper: Rig) -> None:
    with gripper.ready() as tool:
        assert gripper.device.written == []  # nothing moves at a start
        wait_until("a grip", lambda: tool.grip().succeeded)
        assert gripper.device.holds
        assert not tool.status.alarm_texts
        assert tool.drop().succeeded
        assert gripper.device.written[-2:] == [CLOSE, OPEN]
        gripper.device.has_part = False
        running = tool.begin(Command.GRIP)
        assert not running.wait().succeeded
        assert "closed on nothing" in running.wait().reason


def test_a_killed_program_holds_what_it_held_and_its_successor_drops_it(gripper: Rig) -> None:
    program = gripper.program("grip; wait 60")
    program.wait_until(lambda: "GRIPPED" in program.text(), timeout_s=PATIENCE_S, what="GRIPPED")
    told = len(gripper.device.written)
    os.killpg(program.pid, signal.SIGKILL)
    with ArbiterClient(gripper.world.socket, "test") as observer:
        wait_until("its death is known", lambda: not observer.status()["clients"])
    with gripper.ready() as tool:
        assert tool.status.ee == EndEffectorState.GRIPPED
        assert len(gripper.device.written) == told
        assert tool.drop().succeeded
    assert not gripper.device.holds


def test_a_program_that_is_killed_while_it_grips_has_its_last_will_done_over_the_bus(gripper: Rig) -> None:
    gripper.device.has_part = False
    program = gripper.program("grip; wait 60")
    wait_until("it closes", lambda: CLOSE in gripper.device.written)
    os.killpg(program.pid, signal.SIGKILL)
    wait_until("the last will", lambda: gripper.device.written[-1] == OPEN)


def test_a_killed_arbiter_leaves_it_holding_and_the_next_one_adopts_and_writes_nothing(gripper: Rig) -> None:
    with gripper.gripping() as tool:
        told = len(gripper.device.written)
        gripper.kill_arbiter()
    again = gripper.arbiter_again()
    assert "modbus:9/0x03E8=1" in again.text()
    with gripper.ready() as tool:
        assert tool.status.ee == EndEffectorState.GRIPPED
        assert len(gripper.device.written) == told
        assert tool.drop().succeeded


def test_a_cut_cable_while_it_holds_is_told_and_changes_nothing(gripper: Rig) -> None:
    with gripper.gripping() as tool:
        told = len(gripper.device.written)
        gripper.cable.cut = True
        wait_until("the alarm", lambda: tool.status.alarm_texts)
        assert tool.status.ee == EndEffectorState.GRIPPED
        gripper.cable.cut = False
        wait_until("it is over", lambda: all(each.startswith("Over:") for each in tool.status.alarm_texts))
        assert tool.status.ee == EndEffectorState.GRIPPED
        assert len(gripper.device.written) == told
        assert tool.drop().succeeded


def test_a_fault_of_the_gripper_is_told_in_words_holds_the_part_and_refuses_the_next_grip_until_a_reset(
    gripper: Rig,
) -> None:
    with EndEffector.open(gripper.world.description) as tool:
        tool.wait_ready(READY_S)
        wait_until("a grip", lambda: tool.grip().succeeded)
        told = len(gripper.device.written)
        gripper.device.fault = 0xC
        wait_until(
            "the alarm", lambda: "Fingers fault: internal fault; ask Robotiq." in tool.status.alarm_texts
        )
        assert tool.status.ee == EndEffectorState.GRIPPED
        wait_until("its sensors prove nothing", lambda: tool.status.evidence[0] is Evidence.UNKNOWN)
        wait_until(
            "the arbiter has latched it", lambda: "fingers_fault has shown a fault" in gripper.faults()
        )
        assert not tool.reset().accepted
        assert len(gripper.device.written) == told
        gripper.device.fault = 0
        wait_until("it is proven again", lambda: tool.status.evidence[0] is Evidence.CONFIRMED)
        assert tool.status.ee == EndEffectorState.GRIPPED
        assert tool.drop().succeeded
        refused = tool.begin(Command.GRIP)
        assert "IL-07: Over: Fingers fault: internal fault; ask Robotiq. Reset it first." in str(refused)
        assert tool.reset().accepted
        wait_until("no alarm", lambda: not tool.status.alarm_texts)
        wait_until("a grip", lambda: tool.grip().succeeded)


def test_a_latched_fault_of_the_gripper_outlives_the_program_and_the_arbiter(gripper: Rig) -> None:
    with EndEffector.open(gripper.world.description) as tool:
        tool.wait_ready(READY_S)
        gripper.device.fault = 0xC
        wait_until(
            "the arbiter has latched it", lambda: "fingers_fault has shown a fault" in gripper.faults()
        )
        gripper.device.fault = 0
    gripper.kill_arbiter()
    gripper.arbiter_again()
    with EndEffector.open(gripper.world.description) as tool:
        with pytest.raises(NotReadyError, match="latched: IL-07: fingers_fault has shown a fault"):
            tool.wait_ready(READY_S)
        failed = tool.grip()
        assert not failed.succeeded
        assert "fingers_fault has shown a fault; reset the faults first" in failed.reason
        assert CLOSE not in gripper.device.written
        assert tool.reset().accepted
        wait_until("a grip", lambda: tool.grip().succeeded)


def test_a_fault_that_an_activation_clears_is_cleared_by_the_next_grip_and_never_before(gripper: Rig) -> None:
    with EndEffector.open(gripper.world.description) as tool:
        tool.wait_ready(READY_S)
        wait_until("a grip", lambda: tool.grip().succeeded)
        assert tool.drop().succeeded
        told = len(gripper.device.written)
        gripper.device.fault = 0xE
        alarm = "Fingers fault: overcurrent; the next grip activates it again."
        wait_until("the alarm", lambda: alarm in tool.status.alarm_texts)
        assert len(gripper.device.written) == told
        wait_until("a grip", lambda: tool.grip().succeeded)
        assert gripper.device.written[told:][:2] == [(0, 0, 0), (0x0100, 0, 0)]
        wait_until("it is over", lambda: f"Over: {alarm}" in tool.status.alarm_texts)
        assert tool.reset().accepted


def test_a_drop_over_a_cut_cable_is_no_success_and_the_next_one_activates_and_releases(gripper: Rig) -> None:
    with gripper.gripping() as tool:
        gripper.cable.cut = True
        assert not tool.drop().succeeded
        assert gripper.faults()
        assert gripper.device.holds
        told = len(gripper.device.written)
        gripper.cable.cut = False
        wait_until(
            "it has a fault that its activation clears", lambda: gripper.device.fault or gripper.device._lost
        )
        wait_until("its readings are back", lambda: tool.status.evidence[0] is Evidence.CONFIRMED)
        assert gripper.device.holds
        assert len(gripper.device.written) == told
        assert tool.drop().succeeded
        assert not gripper.device.holds


def test_a_start_without_the_device_guesses_and_knows_when_it_is_there(tmp_path: Path) -> None:
    rig = Rig("gripper_2f85", Gripper2F85(now_us()), tmp_path)
    rig.cable.cut = True
    with rig:
        wait_until("the levels are told", lambda: "modbus:9/0x03E8=1" in rig.world.arbiter.text())
        rig.cable.cut = False
        with ArbiterClient(rig.world.socket, "test") as observer:
            wait_until("it is known", lambda: observer.levels() == {"modbus:9/0x03E8": False})
        assert rig.device.written == []


@pytest.mark.parametrize(
    ("power_up", "ends_in"),
    [("hold", EndEffectorState.GRIP_ERROR), ("release", EndEffectorState.STAND_BY)],
)
def test_an_epick_that_lost_its_part_with_its_arbiter_is_a_lost_grip_or_withdrawn_as_declared(
    power_up: str, ends_in: EndEffectorState, tmp_path: Path
) -> None:
    """It still echoes the request, and has a fault that its activation clears: no release is written, which would
    activate it, and no grip begins."""
    with Rig("epick_commanded", SimulatedEPick(now_us()), tmp_path, power_up=power_up) as rig:
        with rig.gripping():
            before = len(rig.device.written)
            rig.kill_arbiter()
        heard = rig.device._heard_at
        wait_until("no communication for a second", lambda: now_us() - heard > 1_100_000)
        rig.arbiter_again()
        with rig.ready() as tool:
            wait_until("the start is over", lambda: tool.status.ee == ends_in)
            assert rig.device.written[before:] == []
            assert not rig.device.holds


def test_a_gripper_that_lost_its_power_while_it_held_is_activated_by_a_drop_and_by_nothing_before(
    gripper: Rig,
) -> None:
    gripper.device.ACTIVATION_US = 4_000_000
    with gripper.gripping() as tool:
        told = len(gripper.device.written)
        gripper.device.power_up(now_us())
        wait_until("it is lost", lambda: tool.status.ee == EndEffectorState.GRIP_ERROR)
        assert len(gripper.device.written) == told
        dropped = tool.drop()
        assert dropped.succeeded, dropped.reason
        assert tool.status.ee == EndEffectorState.STAND_BY
        wait_until("it is open", lambda: gripper.device.written[-1] == OPEN)
        assert gripper.device.written[told:] == [(0, 0, 0), (0x0100, 0, 0), OPEN]


def test_fingers_that_are_found_half_open_are_opened_by_a_drop(tmp_path: Path) -> None:
    device = Gripper2F85(now_us())
    device.position, device.has_part = 100.0, False
    device.commands, device._activated_at = [0x09, 0, 0, 100, 0xFF, 0xFF], 0
    with (
        Rig("gripper_2f85", device, tmp_path) as rig,
        EndEffector.open(rig.world.description) as tool,
    ):
        wait_until("STAND_BY", lambda: tool.status.ee == EndEffectorState.STAND_BY)
        wait_until("a reading", lambda: tool.status.evidence[0] is Evidence.PARTIAL)
        refused = tool.grip()
        assert not refused.succeeded
        assert "fingers" in refused.reason.lower()
        assert "Drop" in refused.reason
        assert device.written == []
        dropped = tool.drop()
        assert dropped.succeeded, dropped.reason
        wait_until("it was told to open", lambda: device.written[-1] == OPEN)
        assert device.position < 10
