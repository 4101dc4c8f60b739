"""Interlocks that need a sensor, at the line arbiter: real arbiter, real testbench; no program can pass them by."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.arbiter.client._sender import PredicateSender
from end_effector_hal.description import Description, EStop, load, profile_path
from end_effector_hal.errors import LineRefusedError
from end_effector_hal.runtime import EndEffector
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import read_chip
from end_effector_lab.demo._world import World
from tests.support.nightly import NIGHTLY
from tests.support.patience import wait_until
from tests.support.stopped import stop

pytestmark = [pytest.mark.wall, pytest.mark.timeout(90)]
UNLOCK, BOTTOM = "SODIMM_206", "SODIMM_208"
STAND_BY = EndEffectorState.STAND_BY
REFUSED = (
    "IL-13: the emergency stop was opened. Nothing is activated until it is closed and the faults are reset."
)
LATE_US = 100_000
"""Frames come every 20 ms; what they prove counts for 150 ms."""


def quick() -> Description:
    """The shipped tool with one short attempt per step, and an e-stop."""
    tool = load(profile_path())
    short = {"timeout_s": 1.0, "attempts": 1}
    actuators = {name: actuator.model_copy(update=short) for name, actuator in tool.actuators.items()}
    return tool.model_copy(update={"actuators": actuators, "e_stop": EStop()})


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with World(quick(), "nominal", tmp_path_factory.mktemp("world")) as running:
        yield running


def active(world: World, line: str) -> bool:
    return bool(read_chip(world.chip).lines[line].level)


def refusal(client: ArbiterClient, line: str) -> str:
    with pytest.raises(LineRefusedError) as caught:
        client.set({line: True})
    return str(caught.value)


def test_whoever_writes_to_the_arbiter_is_refused_as_well(world: World) -> None:
    with ArbiterClient(world.socket, "hand", [UNLOCK, BOTTOM]) as hand:
        assert "no process that reads the sensors has reported yet whether nothing is gripped" in refusal(
            hand, UNLOCK
        )
        assert "no process that reads the sensors has reported yet whether the tool is locked" in refusal(
            hand, BOTTOM
        )
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        wait_until("it", lambda: tool.lock().succeeded)
        assert tool.grip().succeeded
        stop(world.testbench.pid)
        try:
            with ArbiterClient(world.socket, "look") as look:
                wait_until("it", lambda: look.status()["told"]["locked"]["age_us"] > 150_000)
            assert active(world, BOTTOM), "a predicate that expires deactivates nothing"
            assert tool.status.ee == EndEffectorState.GRIPPED
        finally:
            os.kill(world.testbench.pid, signal.SIGCONT)
        wait_until("it", lambda: tool.drop().succeeded)


class Rhythm:
    """How regularly frames come: where they do not, the program rightly refuses to work."""

    def __init__(self, tool: EndEffector) -> None:
        self._last_us, self.regular, self.breaks = now_us(), 0, 0
        tool.subscribe_frames(self._came)

    def _came(self, frame: Frame) -> None:
        at = now_us()
        late = max(at - frame.at, at - self._last_us) > LATE_US
        self._last_us, self.regular = at, 0 if late else self.regular + 1
        self.breaks += late


def test_what_one_command_has_proven_the_next_may_rest_on_at_once(world: World) -> None:
    """The arbiter knows of a frame before the program decides by it.

    A machine that stands still makes frames late, and then a refusal is right: only rounds without such a break count.
    """
    with EndEffector.open(world.description) as tool:
        rhythm, rounds = Rhythm(tool), 0
        tool.wait_ready(30.0)
        while rounds < (5 if NIGHTLY else 3):
            wait_until("the tool is locked", lambda: tool.lock().succeeded)
            wait_until("a second of regular frames", lambda: rhythm.regular > 50)
            before = rhythm.breaks
            reasons = [command().reason for command in (tool.grip, tool.drop, tool.unlock, tool.lock)]
            if rhythm.breaks == before:
                assert reasons == ["", "", "", ""]
                rounds += 1
            wait_until("nothing is held", lambda: tool.status.ee == STAND_BY or tool.drop().succeeded)


def test_why_the_arbiter_refused_stands_in_the_result(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        wait_until("it", lambda: tool.lock().succeeded)
        # frames go on to the program, and nothing of them to the arbiter
        monkeypatch.setattr(PredicateSender, "send", lambda *_: False)
        time.sleep(0.7)  # the claims expire, and IL-01 has its half second
        outcome = tool.unlock()
        assert not outcome.succeeded
        assert f"IL-01: {UNLOCK} (unlock) is not activated: for " in outcome.reason
        wait_until("it", lambda: tool.lock().succeeded)
        outcome = tool.grip()
        assert (outcome.succeeded, outcome.state) == (False, STAND_BY)
        assert outcome.reason.startswith("The line arbiter refused to activate Bottom vacuum.")
        assert f"IL-05: {BOTTOM} (bottom_vacuum) is not activated: for " in outcome.reason
        by_hand = tool.set_actuator("cylinder", True)
        assert not by_hand.accepted
        assert by_hand.reason.startswith("IL-05: SODIMM_210 (cylinder) is not activated: for ")
        monkeypatch.undo()
        wait_until("it", lambda: tool.grip().succeeded)
        assert tool.status.reason == ""
        assert tool.drop().succeeded


def test_il_13_an_open_e_stop_holds_what_is_held_and_latches(world: World) -> None:
    with EndEffector.open(world.description) as tool, ArbiterClient(world.socket, "look") as look:
        tool.wait_ready(30.0)
        wait_until("it", lambda: tool.lock().succeeded)
        assert tool.grip().succeeded
        world.choose("estop-open")
        wait_until("it", lambda: "e_stop_closed" in look.status()["faults"])
        wait_until("it", lambda: "IL-13: the emergency stop was opened." in tool.status.alarm_texts)
        assert tool.status.ee == EndEffectorState.GRIPPED
        assert tool.drop().succeeded, "a deactivation is never refused"
        assert tool.grip().reason == REFUSED
        with pytest.raises(LineRefusedError, match="stop is open: this fault stays"):
            look.reset()
        assert "stop is open: this fault stays" in tool.reset().reason
        world.choose("nominal")
        wait_until("it", lambda: look.status()["told"]["e_stop_closed"]["holds"])
        assert tool.grip().reason == REFUSED, "it stays latched"
        assert tool.reset().accepted
        assert tool.grip().succeeded, "at once"
