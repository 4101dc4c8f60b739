"""A tool with two links and an input of the board: each is read for itself."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli.doctor._check_result import Level
from end_effector_hal.cli.doctor._link import look_at_link
from end_effector_hal.cli.listen import _listen
from end_effector_hal.codecs import load_tool
from end_effector_hal.runtime import EndEffector, Refused
from end_effector_hal.vocabulary import Command, EndEffectorState, Evidence
from end_effector_hal.wires.link import LinkState
from end_effector_lab.demo._world import World
from end_effector_lab.testbench import Testbench, open_sensors
from end_effector_lab.testbench._ports import PtyPort
from end_effector_lab.testbench.inputs import VirtualInputs
from tests.support.command import eehal, eehal_here
from tests.support.patience import wait_until

from .conftest import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.timeout(180)]
TOOL = ROOT / "examples/tools/two_links/end_effector.yaml"
READY_S = 60.0


@pytest.mark.thinned
def test_it_is_checked_verified_demonstrated_and_replayed(tmp_path: Path) -> None:
    assert "link      jaws: /dev/ttyACM0" in eehal_here("check", TOOL)
    proof = json.loads(eehal_here("verify", TOOL, "--json"))
    assert all(each["holds"] for each in proof["requirements"])
    eehal("demo", TOOL, "--no-ros", "--only", "nominal", "-o", tmp_path)
    assert "decisions, all identical" in eehal_here("replay", tmp_path / "nominal")


def alarms(tool: EndEffector, what: str) -> bool:
    return any(what in alarm for alarm in tool.status.alarm_texts)


def test_one_link_falls_silent_while_held_and_comes_back(world: World) -> None:
    jaws = world.description.links["jaws"].port
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(READY_S)
        assert tool.grip().succeeded
        world.choose("silent-after:jaws:0")
        down = f"The sensor link jaws ({jaws}) is down."
        wait_until("the alarm", lambda: down in tool.status.alarm_texts)
        assert not alarms(tool, "sensor link cups")
        assert tool.status.ee is EndEffectorState.GRIPPED
        assert all(tool.status.outputs)
        assert tool.status.evidence == (Evidence.CONFIRMED, Evidence.UNKNOWN)
        world.choose("lost-after:cup:0.001,silent-after:jaws:0")  # the other one goes on being judged
        wait_until("it is lost", lambda: tool.status.ee is EndEffectorState.GRIP_ERROR)
        assert all(tool.status.outputs)
        world.choose("nominal")
        wait_until("it is up", lambda: tool.status.link_up)
        assert tool.drop().succeeded
        world.choose("silent-after:cups:0")
        wait_until("it is down", lambda: not tool.status.link_up)
        refused = tool.begin(Command.GRIP)
        assert isinstance(refused, Refused)
        assert (
            refused.reason
            == f"IL-07: the sensor link cups ({world.description.links['cups'].port}) is not up."
        )


@pytest.mark.nightly  # one that falls silent comes back, too
def test_a_port_that_is_unplugged_comes_back_while_the_other_goes_on(tmp_path: Path) -> None:
    with World(load_tool(TOOL), "nominal", tmp_path) as world, EndEffector.open(world.description) as tool:
        tool.wait_ready(READY_S)
        assert tool.grip().succeeded
        world.testbench.end()
        wait_until("both are lost", lambda: {each.state for each in tool.links.values()} == {LinkState.DOWN})
        wait_until("nothing is proven", lambda: set(tool.status.evidence) == {Evidence.UNKNOWN})
        assert tool.status.ee is EndEffectorState.GRIPPED
        one = PtyPort(world.description.links["jaws"].port)
        inputs = VirtualInputs(world.chip, [actuator.line for _, actuator in world.description.ordered])
        sensors = open_sensors(None, world.description)
        with Testbench(world.description, inputs, {"jaws": one}, sensors):
            wait_until("one is back", lambda: tool.links["jaws"].state is LinkState.UP)
            assert tool.links["cups"].state is LinkState.DOWN
            wait_until("it is judged", lambda: tool.status.evidence[1] is Evidence.CONFIRMED)
            assert tool.status.evidence[0] is Evidence.UNKNOWN
            assert tool.status.ee is EndEffectorState.GRIPPED
            wait_until("the alarm", lambda: alarms(tool, "sensor link cups"))
            assert not alarms(tool, "sensor link jaws")


def test_listen_and_doctor_see_every_source(world: World) -> None:
    said = [*look_at_link(world.description)]
    assert [each.level for each in said] == [Level.OK, Level.OK], said
    heard = CliRunner().invoke(
        _listen.command, [str(world.description_path), "--seconds", "3", "--json"], catch_exceptions=False
    )
    events = [json.loads(line) for line in heard.stdout.splitlines()]
    told = {each["channel"]: each for each in events if each["event"] == "channel"}
    assert told.keys() == {"vacuum", "opened", "gripped", "air"}
    assert 99 <= told["vacuum"]["raw"] <= 101  # kPa below 100, which is ambient
    assert (told["opened"]["value"], told["air"]["value"]) == (True, True)
    evidence = {each["actuator"]: each["evidence"] for each in events if each["event"] == "evidence"}
    assert evidence == {"cup": "GONE", "jaw": "GONE"}
