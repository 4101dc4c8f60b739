"""A whole tool in virtual time: what it decides, who dies, what outlives it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.control import network_of
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import LEASE_US, ChangerFault, ChangerState, EndEffectorState
from end_effector_lab.testbench.physics import _grippers
from end_effector_lab.virtual import VirtualTool
from tests.support.places import ROOT
from tests.unit.wires.bus.test_handshake import TOOL as HANDSHAKE_TOOL
from timed_automata.execute import Observation
from timed_automata.monitor import Monitor

SHIPPED = load(profile_path())
BOTTOM, CYLINDER, TOP = (actuator.line for _, actuator in SHIPPED.ordered)
assert SHIPPED.tool_changer
UNLOCK = SHIPPED.tool_changer.line
GRIPPING = EndEffectorState.GRIPPING
GRIPPED = EndEffectorState.GRIPPED
STAND_BY = EndEffectorState.STAND_BY


def until(tool: VirtualTool, state: EndEffectorState, seconds: float = 60.0) -> None:
    reached = tool.run_until(tool.at + round(seconds * 1e6), lambda: tool.status.ee == state)
    assert reached, f"{tool.status.ee.name}: {tool.status.reason} {tool.status.alarm_texts}"


def ready(description: Description = SHIPPED, scenario: str = "nominal", *, seed: int = 0) -> VirtualTool:
    tool = VirtualTool(description, scenario, seed=seed, models={})  # devices do what is declared of them
    until(tool, STAND_BY)
    tool.run(1.0)
    return tool


def gripped(scenario: str = "nominal", description: Description = SHIPPED) -> VirtualTool:
    tool = ready(description, scenario)
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    return tool


def pending_cylinder(scenario: str = "nominal") -> VirtualTool:
    tool = ready(scenario=scenario)
    assert tool.command("grip").accepted
    assert tool.run_until(tool.at + 10_000_000, lambda: tool.levels[CYLINDER])
    return tool


def moved(tool: VirtualTool, since: int) -> list[tuple[str, bool]]:
    return [(edge.line, edge.level) for edge in tool.edges[since:]]


def test_a_grip_and_a_drop() -> None:
    tool = gripped()
    assert moved(tool, 0) == [(BOTTOM, True), (CYLINDER, True), (TOP, True)]
    assert tool.status.lift_allowed
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    assert moved(tool, 3) == [(TOP, False), (CYLINDER, False), (BOTTOM, False)]
    assert not tool.status.alarm_texts


def test_one_seed_is_one_run() -> None:
    def story(seed: int) -> object:
        tool = ready(seed=seed, scenario="fails-once:cylinder,flips:0.001")
        tool.command("grip")
        until(tool, GRIPPED)
        return tool.edges, tool.statuses

    assert story(3) == story(3)
    assert story(3) != story(4)


def test_how_often_it_is_asked_changes_nothing() -> None:
    often, once = ready(), ready()
    for tool in (often, once):
        tool.command("grip")
    for _ in range(400):
        often.run(0.01)
    once.run(4.0)
    assert often.edges == once.edges
    assert often.statuses == once.statuses


def test_an_unlock_waits_for_its_proof_and_a_lock_follows() -> None:
    tool = gripped()
    tool.command("drop")
    until(tool, STAND_BY)
    assert tool.command("unlock").accepted
    tool.run(0.5)
    assert tool.status.changer == ChangerState.UNLOCKED
    assert tool.command("lock").accepted
    tool.run(3.0)
    assert tool.status.changer == ChangerState.LOCKED


def test_a_program_that_dies_in_a_grip_is_unwound_by_its_last_will() -> None:
    tool = pending_cylinder()
    before = len(tool.edges)
    tool.kill("hal")
    tool.run(5.0)
    assert moved(tool, before) == [(CYLINDER, False), (BOTTOM, False)]
    tool.start("hal")
    until(tool, STAND_BY)
    assert tool.command("grip").accepted
    until(tool, GRIPPED)


def test_a_program_that_dies_while_it_holds_lets_nothing_go() -> None:
    tool = gripped()
    before = len(tool.edges)
    tool.kill("hal")
    tool.run(5.0)
    assert tool.status.ee == EndEffectorState.OFF
    tool.start("hal")
    until(tool, GRIPPED)
    assert moved(tool, before) == []


def test_an_arbiter_that_dies_moves_nothing_and_the_grip_goes_on() -> None:
    tool = pending_cylinder()
    before = len(tool.edges)
    tool.kill("arbiter")
    tool.run(0.2)
    tool.start("arbiter")
    until(tool, GRIPPED)
    assert moved(tool, before) == [(TOP, True)]


@pytest.mark.parametrize("noticed", [False, True])
def test_the_tool_changer_obeys_nothing_while_the_arbiter_is_lost(*, noticed: bool) -> None:
    tool = ready()
    assert tool.command("unlock").accepted
    tool.run(1.0)
    assert (tool.status.changer, tool.status.unlock_output) == (ChangerState.UNLOCKED, True)
    tool.kill("arbiter")
    tool.run(0.3 if noticed else 0.0)
    before = len(tool.edges)
    for word in ("lock", "arm", "reset"):
        answer = tool.command(word)
        assert (answer.accepted, answer.decided) == (False, False), word
        assert answer.reason.startswith("The line arbiter is lost: nothing was written, and nothing will be.")
    assert (tool.status.changer, tool.status.unlock_output) == (ChangerState.UNLOCKED, True)
    tool.run(3.0)  # its longest time is over meanwhile
    assert (tool.status.unlock_output, tool.status.arbiter_lost) == (True, True)
    tool.start("arbiter")
    tool.run(1.0)
    assert not tool.status.arbiter_lost
    tool.run(3.0)
    assert moved(tool, before) == [(UNLOCK, False)], "only the line arbiter ends it (IL-03)"
    assert tool.reset().accepted
    assert tool.command("lock").accepted


def test_both_die_in_a_grip_and_the_next_arbiter_executes_the_last_will() -> None:
    tool = pending_cylinder()
    before = len(tool.edges)
    tool.kill("arbiter")
    tool.kill("hal")
    tool.run(1.0)
    assert moved(tool, before) == []
    tool.start("arbiter")
    tool.start("hal")
    until(tool, STAND_BY)
    assert moved(tool, before) == [(CYLINDER, False), (BOTTOM, False)]


def test_an_orderly_end_while_it_holds_lets_nothing_go() -> None:
    tool = gripped()
    before = len(tool.edges)
    tool.end("hal")
    tool.end("arbiter")
    tool.run(2.0)
    tool.start("arbiter")
    tool.start("hal")
    until(tool, GRIPPED)
    assert moved(tool, before) == []


def test_an_arbiter_that_is_asked_to_end_executes_the_last_will_of_who_ends_a_moment_later() -> None:
    tool = pending_cylinder()
    before = len(tool.edges)
    tool.end("arbiter")
    tool.run(0.3)
    tool.kill("hal")
    tool.start("arbiter")
    assert (tool.arbiters, tool.ending) == (1, True), "the next one comes when this one has gone"
    tool.run(5.0)
    assert moved(tool, before) == [(CYLINDER, False), (BOTTOM, False)]
    assert (tool.arbiters, tool.ending) == (2, False)


def test_an_arbiter_that_is_asked_to_end_waits_the_time_of_a_lease_for_who_lives() -> None:
    tool = pending_cylinder("never-confirms:cylinder")
    tool.end("arbiter")
    asked_at = tool.at
    assert tool.run_until(tool.at + 5_000_000, lambda: "arbiter" not in tool.living)
    assert tool.at - asked_at == LEASE_US
    tool = pending_cylinder()
    tool.end("arbiter")
    assert tool.run_until(tool.at + 5_000_000, lambda: "arbiter" not in tool.living)
    assert tool.status.ee == GRIPPED, "from then on it would hold"
    tool.start("arbiter")
    tool.end("arbiter")
    tool.end("arbiter")
    assert "arbiter" not in tool.living, "asked twice, it waits for nobody"


def test_a_latched_fault_survives_a_loss_of_power_but_not_on_a_disk_that_failed() -> None:
    for fails in (False, True):
        tool = ready()
        tool.memories.journal.fails = fails
        tool.choose("locked-shows:tool_changer:1,unlocked-shows:tool_changer:1")
        tool.run(2.0)
        latched = set(tool.latched)
        assert latched
        assert ("journal" in latched) is fails
        tool.memories.journal.fails = False
        tool.lose_power()
        tool.choose("nominal")
        tool.start("arbiter")
        assert set(tool.latched) == (set() if fails else latched)


BOTH_BITS = "locked-shows:tool_changer:1,unlocked-shows:tool_changer:1"


def started_with_a_slow_disk() -> VirtualTool:
    """A sensor fault of the tool changer was latched; after a loss of power the disk does not give it back yet."""
    tool = ready(scenario=BOTH_BITS)
    tool.run(2.0)
    assert {name: why[:5] for name, why in tool.latched.items()} == {"sensor_fault": "IL-04"}
    tool.lose_power()
    tool.choose("nominal")
    tool.memories.journal.hangs = True
    tool.start("arbiter")
    tool.start("hal")
    until(tool, STAND_BY)
    tool.run(1.0)
    assert tool.status.changer == ChangerState.LOCKED
    assert set(tool.latched) == {"journal"}
    return tool


def test_a_sensor_fault_that_a_slow_disk_gives_back_late_stays_until_its_reset() -> None:
    tool = started_with_a_slow_disk()
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    before = len(tool.edges)
    tool.memories.journal.hangs = False
    assert tool.run_until(tool.at + 250_000, lambda: "sensor_fault" in tool.latched)
    assert tool._connection
    told = tool._connection.renews_at
    assert tool.status.changer == ChangerState.LOCKED
    assert tool.reset().reason == "hal has latched sensor_fault, and has not been reset."
    assert tool.run_until(told + 150_000, lambda: tool.status.changer_fault == ChangerFault.SENSOR)
    assert tool.status.changer == ChangerState.FAULT
    assert not tool.reset().accepted
    tool.run(5.0)
    assert set(tool.latched) == {"sensor_fault"}
    assert tool.status.ee == GRIPPED
    assert len(tool.edges) == before
    assert tool.command("reset").accepted
    assert not tool.latched
    tool.run(5.0)
    assert (tool.status.changer, tool.status.changer_fault) == (ChangerState.LOCKED, ChangerFault.NONE)


def test_a_fault_that_came_late_while_its_arbiter_died_is_not_missed() -> None:
    tool = started_with_a_slow_disk()
    tool.memories.journal.hangs = False
    assert tool.run_until(tool.at + 250_000, lambda: "sensor_fault" in tool.latched)
    assert tool.status.changer == ChangerState.LOCKED
    tool.kill("arbiter")
    tool.start("arbiter")
    tool.run(1.0)
    assert tool.status.changer_fault == ChangerFault.SENSOR


@pytest.mark.parametrize("hangs", [False, True])
@pytest.mark.parametrize("dies", [False, True])
def test_an_arbiter_that_ends_before_its_journal_was_read_leaves_it_to_the_next(
    *, dies: bool, hangs: bool
) -> None:
    tool = started_with_a_slow_disk()
    if dies:
        tool.kill("arbiter")
    tool.memories.journal.hangs = hangs
    tool.end("arbiter")
    tool.run(2.0)
    assert "arbiter" not in tool.living
    tool.memories.journal.hangs = False
    tool.start("arbiter")
    assert "sensor_fault" in tool.latched
    tool.run(1.0)
    assert tool.status.changer_fault == ChangerFault.SENSOR
    tool.lose_power()
    tool.start("arbiter")
    assert "sensor_fault" in tool.latched, "the disk has it all the time"


def test_a_link_that_falls_silent_holds_what_is_held() -> None:
    tool = gripped()
    before = len(tool.edges)
    tool.choose("silent-after:0")
    tool.run(3.0)
    assert tool.status.held
    assert tool.status.alarm_texts
    assert moved(tool, before) == []


def test_what_never_confirms_is_unwound() -> None:
    tool = ready(scenario="never-confirms:cylinder")
    tool.command("grip")
    tool.run(1.0)
    until(tool, STAND_BY)
    assert [edge.level for edge in tool.edges if edge.line == CYLINDER] == [True, False] * 3
    assert not any(tool.levels.values())
    assert "Cylinder" in tool.status.reason


@pytest.mark.parametrize("name", ["six_cups", "diy_vacuum", "two_links", "two_epick", "double_acting_jaw"])
def test_other_tools(name: str) -> None:
    """Switches of the board, a device that is asked, several links, two coils."""
    tool = ready(load_tool(ROOT / "examples/tools" / name / "end_effector.yaml"))
    answer = tool.command("grip")
    assert answer.accepted, answer.reason
    until(tool, GRIPPED)
    assert tool.command("drop").accepted
    until(tool, STAND_BY)


def on_a_bus(name: str, fault: str = "nominal") -> VirtualTool:
    tool = ready(load_tool(ROOT / "examples/tools" / name / "end_effector.yaml"), fault)
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    return tool


def test_an_output_on_a_bus_moves_when_its_device_has_acknowledged_it() -> None:
    tool = on_a_bus("gripper_2f85")
    (edge,) = tool.edges
    begun = next(each.at for each in tool.statuses if each.ee == GRIPPING)
    assert begun < edge.at < begun + 200_000
    tool.choose("silent-after:0")
    tool.run(0.5)
    assert tool.command("drop").accepted
    tool.run(5)
    assert tool.edges == [edge], "nobody has heard it"
    assert any("its device does not say whether it is activated" in why for why in tool.latched.values())
    tool.choose("nominal")
    tool.run(5)
    assert [each.level for each in tool.edges] == [True, False], "a deactivation is written until it is done"


@pytest.mark.parametrize("acknowledged", [True, False])
def test_a_last_will_that_no_device_has_heard(acknowledged: bool) -> None:
    """It is executed again, also where the device has said that it is active."""
    tool = on_a_bus("gripper_2f85")
    tool.command("drop")
    until(tool, STAND_BY)
    tool.command("grip")
    assert tool.run_until(tool.at + 50_000, lambda: any(tool.levels.values())), (
        "the last will waits for IL-10"
    )
    if acknowledged:
        tool.run(0.15)
    tool.kill("hal")
    tool.kill("arbiter")
    tool.run(1.0)
    assert any(tool.levels.values())
    tool.start("arbiter")
    tool.start("hal")
    until(tool, STAND_BY)
    tool.run(0.5)
    assert not any(tool.levels.values())
    told = any("was not activated: its program has died" in alarm for alarm in tool.status.alarm_texts)
    assert told is not acknowledged


def test_an_arbiter_that_ends_writes_what_is_still_to_be_written() -> None:
    tool = on_a_bus("gripper_2f85")
    assert tool.command("drop").accepted
    tool.end("arbiter")
    tool.run(1.0)
    assert not any(tool.levels.values())


@pytest.mark.parametrize("restarts", [True, False])
def test_a_device_that_hears_nothing_lets_go_and_the_loss_is_told(restarts: bool) -> None:
    """`on_link_loss: release`, `keep_alive_ms: 1000`: while no line arbiter lives, or the wire is off."""
    tool = on_a_bus("epick_commanded")
    if restarts:
        tool.kill("arbiter")
    else:
        tool.choose("silent-after:0")
    tool.run(0.9)
    assert tool.edges[-1].level
    assert not tool.status.lift_allowed
    tool.run(0.2)
    assert not tool.edges[-1].level
    tool.choose("nominal")
    tool.start("arbiter")
    tool.run(2.0)
    assert not any(tool.levels.values()), "nothing is activated by itself (IL-11)"
    told = "went inactive while no line arbiter ran" if restarts else "Cup was lost"
    assert any(told in alarm for alarm in tool.status.alarm_texts)


@pytest.mark.parametrize(("who", "holds"), [("hal", False), ("arbiter", True)])
def test_power_up_release_counts_for_a_start_of_a_program_alone_not_for_one_of_the_arbiter(
    who: str, holds: bool, tmp_path: Path
) -> None:
    """`power_up: release` with `held.process_death: hold`; the arbiter is back before the device lets go."""
    text = (ROOT / "examples/tools/epick_commanded/end_effector.yaml").read_text()
    before = "device: robotiq-epick"
    assert before in text
    declared = text.replace(before, f"{before}, endings: {{power_up: release}}")
    path = tmp_path / "end_effector.yaml"
    path.write_text(f"{declared}\ninterlocks: {{IL-09: false}}\n")
    tool = ready(load_tool(path))
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    tool.kill(who)
    tool.run(0.5)
    assert tool.bench.devices["cup"].grips
    tool.start(who)
    tool.run(4.0)
    assert tool.bench.devices["cup"].grips == holds
    assert (tool.status.ee == GRIPPED) == holds


@pytest.mark.parametrize("keeps", [True, False])
def test_without_power_a_device_lets_go_or_keeps_what_it_holds(keeps: bool, tmp_path: Path) -> None:
    text = (ROOT / "examples/tools/epick_commanded/end_effector.yaml").read_text()
    path = tmp_path / "tool.yaml"
    path.write_text(
        text.replace(
            "device: robotiq-epick",
            f"device: robotiq-epick, on_power_loss: {'keep' if keeps else 'release'}",
        )
    )
    tool = ready(load_tool(path))
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    tool.lose_power()
    tool.start("arbiter")
    tool.start("hal")
    tool.run(2.0)
    assert tool.bench.devices["cup"].grips == keeps


@pytest.mark.parametrize("order", ["before", "after"])
def test_a_device_with_a_handshake_grips_and_releases(order: str, tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(HANDSHAKE_TOOL.replace("within_s: 0.4", f"within_s: 0.4, order: {order}"))
    tool = ready(load_tool(path))
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    assert [edge.level for edge in tool.edges] == [True, False]
    assert not tool.latched


def test_an_unknown_process_is_refused() -> None:
    with pytest.raises(UsageError, match="no process 'nobody'"):
        ready().kill("nobody")


def test_a_monitor_follows_every_program_of_a_run() -> None:
    monitors: list[Monitor] = []

    def watch() -> Callable[[Observation], None]:
        automata = SHIPPED.automata
        monitor = Monitor(network_of(SHIPPED), automata.executed, automata.interface, requirements=True)
        monitors.append(monitor)
        return monitor.observe

    tool = VirtualTool(SHIPPED, "fails-once:top_vacuum", watch=watch)
    until(tool, STAND_BY)
    tool.run(1.0)
    tool.command("grip")
    tool.run(1.0)
    tool.kill("hal")
    tool.run(3.0)
    tool.start("hal")
    until(tool, STAND_BY)
    assert [each.objections for each in monitors] == [[], []]
    assert all(each.steps for each in monitors)


QUICK = """\
schema: 2
name: quick
summary: a magnet whose switch answers at once
lines: {backend: gpiod}
inputs: {period_ms: 5}
channels:
  part: {digital: {line: GPIO22, bias: pull_up}, invert: true}
sequence: [magnet]
actuators:
  magnet: {kind: magnet, line: GPIO12, part_bit: part, confirmed_ms: 0, gone_ms: 0, timeout_s: 2}
supply: {channel: none}
"""


def test_nothing_is_told_as_held_while_its_deactivation_waits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """IL-10: the line goes inactive 50 ms after it was activated, although the next grip is confirmed by then."""
    monkeypatch.setattr(_grippers, "_SHARE", 0.9)  # its field is there at once
    description = tmp_path / "quick.yaml"
    description.write_text(QUICK, encoding="utf-8")
    tool = ready(load_tool(description))
    begun = tool.at
    assert tool.command("grip").accepted
    tool.run(0.01)
    assert tool.command("cancel").accepted
    tool.run(0.005)
    assert tool.command("grip").accepted
    assert tool.run_until(tool.at + 1_000_000, lambda: tool.status.held)
    assert [(edge.at - begun, edge.level) for edge in tool.edges] == [
        (0, True),
        (50_000, False),
        (100_000, True),
    ]
    assert tool.at - begun == 100_000
    # meanwhile the part has gone: it is told as lost, and never as gripped
    assert [EndEffectorState(each.ee).name for each in tool.statuses if each.held] == ["GRIP_ERROR"]
    tool.run(1.0)
    assert tool.command("drop").accepted
    until(tool, STAND_BY)


EDGES = """
import sys
from end_effector_hal.codecs import load_tool
from end_effector_lab.virtual import VirtualTool
tool = VirtualTool(load_tool(sys.argv[1]))
tool.run(1.0)
tool.command("grip")
tool.run(3.0)
print(*tool.edges, sep="\\n")
"""


def test_two_coils_that_are_driven_at_once_are_driven_in_the_same_order_by_every_process() -> None:
    tool = str(ROOT / "examples" / "tools" / "bistable_and_magnet" / "end_effector.yaml")
    one, other = (
        subprocess.run(
            [sys.executable, "-c", EDGES, tool],
            env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, text=True, check=True,
        ).stdout
        for seed in ("1", "2")
    )  # fmt: skip
    assert one == other != ""


OF_TWO_SOURCES = """
schema: 2
name: two_sources
link: {port: /dev/ttyUSB0, baudrate: 115200, period_ms: 40, frame: {modbus: {timeout_ms: 20}}}
inputs: {period_ms: 10}
channels:
  told: {modbus: {unit: 3, address: 0x0103}, on: [0]}
  state: {modbus: {unit: 3, address: 0x0201}, on: [2]}
  opened: {modbus: {unit: 3, address: 0x0202}, unit: "%", scale: 0.1, range: [0, 100]}
  support_out: {digital: {line: DI_1, bias: pull_up, debounce_ms: 3}, invert: true}
  support_in: {digital: {line: DI_2, bias: pull_up, debounce_ms: 3}, invert: true}
sequence: [fingers, support]
actuators:
  fingers:
    kind: gripper
    modbus: {unit: 3, address: 0x0103, command_on: [0], command_off: [1000], verify: told, on_link_loss: hold}
    on_power_loss: hold
    evidence:
      confirmed: {all: [{on: state}, {channel: opened, between: [20, 60]}], for_ms: 100}
      gone: {channel: opened, above: 98, for_ms: 80}
      lost: {any: [{not: {on: state}}, {channel: opened, below: 15}], for_ms: 80}
      empty: {channel: opened, below: 2, for_ms: 200}
    timeout_s: 7
    release_s: 4
  support:
    {kind: cylinder, line: DO_1, opposite: {line: DO_2}, channel: none, extended_bit: support_out,
     retracted_bit: support_in, timeout_s: 3}
supply: {channel: none}
"""


def test_a_start_at_rest_tells_of_no_part_that_is_held(tmp_path: Path) -> None:
    """Until the lines are adopted, an output that nobody has read yet counts as active."""
    (tmp_path / "end_effector.yaml").write_text(OF_TWO_SOURCES)
    tool = VirtualTool(load_tool(tmp_path / "end_effector.yaml"))
    until(tool, STAND_BY)
    told = [alarm for status in tool.statuses for alarm in status.alarm_texts]
    assert any(status.held for status in tool.statuses[:-1]), "nobody knows at first"
    assert not [alarm for alarm in told if "while it holds a part" in alarm]
