"""Units of a bus that have a model: who they are, their power, and a whole tool with one in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, examine_text
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.testbench import Bench, SensorBoard, chosen_models, text_of
from end_effector_lab.testbench._units import played_units
from end_effector_lab.testbench.devices import sealed
from end_effector_lab.virtual import VirtualTool
from tests.support.places import ROOT

S = 1_000_000
TOOLS = ROOT / "examples/tools"
STATUS = sealed(bytes.fromhex("09 04 07D0 0003"))


@pytest.fixture(scope="module")
def gripper() -> Description:
    return load_tool(TOOLS / "gripper_2f85/end_effector.yaml")


def board(
    tool: Description,
    scenario: str = "nominal",
    levels: dict[str, bool] | None = None,
    models: str = "9=robotiq-2f85",
) -> SensorBoard:
    bench = Bench(tool, scenario, levels=levels)
    chosen = chosen_models(models, tool)
    made = SensorBoard(tool, bench, 0, "", lambda name, level: bench.line(name, level, 0), chosen)
    made.begin(levels or {}, 0)
    return made


def test_a_text_chooses_models(gripper: Description) -> None:
    models = chosen_models("9=robotiq-2f85", gripper)
    assert models == {"": {9: "robotiq-2f85"}}
    assert [text for text, _ in played_units(gripper, models)] == ["unit 9 plays the model of robotiq-2f85"]
    assert text_of(models) == "9=robotiq-2f85"
    assert [text for text, _ in played_units(gripper, {})] == ["unit 9 plays the description, not the device"]


def naming(tool: Description, device: str) -> Description:
    """The tool, with the name of a device of a library."""
    ((name, part),) = tool.actuators.items()
    named = part.model_copy()
    object.__setattr__(named, "device", device)
    return tool.model_copy(update={"actuators": {name: named}})


def test_the_name_of_a_device_chooses_its_model_and_a_text_another_one_or_none(gripper: Description) -> None:
    named = naming(gripper, "robotiq-hand-e")
    assert chosen_models(None, named) == {"": {9: "robotiq-hand-e"}}
    assert chosen_models("9=robotiq-2f85", named) == {"": {9: "robotiq-2f85"}}
    assert chosen_models("9=", named) == {"": {}}
    assert chosen_models(None, naming(gripper, "a gripper of my own")) == {}


def test_a_tool_that_names_a_device_is_played_with_its_model(gripper: Description) -> None:
    tool = VirtualTool(naming(gripper, "robotiq-2f85"))
    tool.run(1)
    assert tool.command("grip").accepted
    fingers = tool.bench.devices["fingers"]
    strokes = tool.run_until(5 * S, lambda: not fingers.bits["open"] and not any(tool.levels.values()))
    assert strokes, "an activation moves the fingers"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("9=robotiq-2f86", "no model is named 'robotiq-2f86'. Did you mean 'robotiq-2f85'?"),
        (
            "8=robotiq-2f85",
            "no output of the tool is at '8'. Expected: UNIT=NAME or LINK:UNIT=NAME; there are the",
        ),
        ("robotiq-2f85", "no output of the tool is at 'robotiq-2f85'."),
    ],
)
def test_what_cannot_be_chosen(gripper: Description, text: str, why: str) -> None:
    with pytest.raises(UsageError) as refused:
        chosen_models(text, gripper)
    assert why in str(refused.value)


def test_a_model_drives_only_what_it_is_made_for() -> None:
    tool = load_tool(TOOLS / "epick_commanded/end_effector.yaml")
    with pytest.raises(UsageError, match="cannot drive an actuator of this kind"):
        board(tool)


def test_frames_for_others_and_damaged_ones_get_no_answer(gripper: Description) -> None:
    made = board(gripper)
    assert made.answer(STATUS, 0) is not None
    assert made.answer(STATUS[:-1] + b"\x00", S) is None
    assert made.answer(sealed(b"\x08" + STATUS[1:-2]), 2 * S) is None


def test_a_unit_that_is_active_at_the_start_holds_its_part(gripper: Description) -> None:
    (output,) = gripper.register_outputs
    sent = board(gripper, levels={output: True}).answer(STATUS, 0)
    assert sent is not None
    assert sent.data[:-2].hex(" ").upper() == "09 04 06 B9 00 00 FF 8B 00"


def test_a_restart_forgets_all(gripper: Description) -> None:
    (output,) = gripper.register_outputs
    made = board(gripper, "reboot-after:1", {output: True})
    assert made.due == S
    made.advance(S)
    assert made.due is None
    assert made.answer(STATUS, S + 100_000) is None, "it starts"
    sent = made.answer(STATUS, 2 * S)
    assert sent is not None
    assert sent.data[:-2].hex(" ").upper() == "09 04 06 00 00 00 00 8B 00", "the fingers stay where they are"


class Played:
    """The whole tool, at rest or holding a part; every status is looked at."""

    def __init__(self, tool: Description, model: str = "9=robotiq-2f85") -> None:
        self.tool = VirtualTool(tool, models=chosen_models(model, tool))
        (name,) = tool.sequence
        self.fingers = self.tool.bench.devices[name]
        self.tool.run(1)

    def command(self, name: str, state: EndEffectorState, limit_s: float = 30) -> None:
        answer = self.tool.command(name)
        assert answer.accepted, answer.reason
        assert self.tool.run_until(self.tool.at + round(limit_s * S), lambda: self.tool.status.ee == state)

    def holds_until_now(self, seconds: float) -> bool:
        """Whether the part is held for so long; a lift is not allowed half a second after it is lost."""
        held_at, held = self.tool.at, True

        def look() -> bool:
            nonlocal held_at, held
            if self.fingers.grips:
                held_at = self.tool.at
            else:
                held = False
                assert self.tool.at < held_at + S // 2 or not self.tool.status.lift_allowed
            return False

        self.tool.run_until(self.tool.at + round(seconds * S), look)
        return held


@pytest.fixture
def played(gripper: Description) -> Played:
    return Played(gripper)


def test_the_product_grips_and_drops(played: Played) -> None:
    played.command("grip", EndEffectorState.GRIPPED)
    assert played.holds_until_now(5)
    played.command("drop", EndEffectorState.STAND_BY)
    assert not played.tool.status.alarm_texts
    played.command("grip", EndEffectorState.GRIPPED)
    assert [each.level for each in played.tool.edges] == [True, False, True], "one activation only"


def test_closing_on_nothing_is_no_grip(played: Played) -> None:
    played.tool.choose("no-part:fingers")
    states = []
    assert played.tool.command("grip").accepted
    played.tool.run_until(played.tool.at + 40 * S, lambda: bool(states.append(played.tool.status.ee)))
    assert EndEffectorState.GRIPPED not in states
    assert states[-1] == EndEffectorState.STAND_BY


def test_a_lost_part_is_told_and_nothing_opens(played: Played) -> None:
    played.command("grip", EndEffectorState.GRIPPED)
    played.tool.choose("lost-after:fingers:0.1")
    assert not played.holds_until_now(3)
    assert played.tool.status.ee == EndEffectorState.GRIP_ERROR
    assert played.tool.levels == {"modbus:9/0x03E8": True}


def test_power_that_is_lost_while_held_drops_nothing_before_the_drop(played: Played) -> None:
    played.command("grip", EndEffectorState.GRIPPED)
    played.tool.choose("reboot-after:0")
    assert played.holds_until_now(10), "nothing activates it by itself"
    assert played.tool.status.ee == EndEffectorState.GRIP_ERROR
    assert any("is not activated any more" in text for text in played.tool.status.alarm_texts)
    played.tool.choose("nominal")
    played.command("drop", EndEffectorState.STAND_BY)
    assert not played.fingers.grips
    played.command("grip", EndEffectorState.GRIPPED)


def test_a_unit_that_falls_silent_keeps_its_part(played: Played) -> None:
    played.command("grip", EndEffectorState.GRIPPED)
    played.tool.choose("silent-after:0")
    assert played.holds_until_now(5)
    assert not played.tool.status.lift_allowed
    played.tool.choose("nominal")
    assert played.holds_until_now(2)
    played.command("drop", EndEffectorState.STAND_BY)


def test_a_cup_is_gripped_and_lets_go_when_it_hears_nothing() -> None:
    played = Played(load_tool(TOOLS / "epick_commanded/end_effector.yaml"), "9=robotiq-epick")
    played.command("grip", EndEffectorState.GRIPPED)
    assert played.holds_until_now(5)
    played.command("drop", EndEffectorState.STAND_BY)
    played.command("grip", EndEffectorState.GRIPPED)
    played.tool.choose("silent-after:0")
    assert played.holds_until_now(1.4)
    assert not played.holds_until_now(2)
    played.tool.choose("nominal")
    played.tool.run(2)
    assert played.tool.status.ee == EndEffectorState.GRIP_ERROR
    played.command("drop", EndEffectorState.STAND_BY)
    played.command("grip", EndEffectorState.GRIPPED)


STATION = """
schema: 2
name: jaw_on_a_station
lines: {backend: gpiod}
link: {port: /dev/ttyUSB0, baudrate: 115200, frame: {modbus: {}}}
channels:
  told: {modbus: {unit: 3, address: 5, register_type: coil}}
  part: {modbus: {unit: 3, address: 0, register_type: discrete_input}}
  opened: {modbus: {unit: 3, address: 1, register_type: discrete_input}}
  closed: {modbus: {unit: 3, address: 0, register_type: input, bitmask: 0x0004}}
sequence: [jaw]
actuators:
  jaw:
    kind: gripper
    modbus: {unit: 3, address: 5, register_type: coil, command_on: [1], command_off: [0], verify: told}
    part_bit: part
    open_bit: opened
    closed_bit: closed
supply: {channel: none}
"""


def test_sensors_are_wired_to_the_inputs_of_a_station(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(STATION)
    played = Played(load_tool(path), "3=remote-io")
    played.command("grip", EndEffectorState.GRIPPED)
    assert played.holds_until_now(2)
    played.tool.choose("lost-after:jaw:0.1")
    played.tool.run(1)
    assert any("closed on nothing" in text for text in played.tool.status.alarm_texts)
    played.command("drop", EndEffectorState.STAND_BY)


CUPS = """
schema: 2
name: cups
lines: {backend: gpiod}
link: {port: /dev/ttyUSB0, baudrate: 115200, parity: E, frame: {modbus: {}}}
channels:
  a_vacuum: {modbus: {unit: 65, address: 18}, unit: Pa, scale: -101.325}
  b_vacuum: {modbus: {unit: 65, address: 19}, unit: Pa, scale: -101.325}
  a_grips: {modbus: {unit: 65, address: 0}, on: [0x0150]}
  b_grips: {modbus: {unit: 65, address: 1}, on: [0x0150]}
sequence: [a, b]
actuators:
  a:
    {kind: vacuum, channel: a_vacuum,
     modbus: {unit: 65, address: 0, command_on: [0x0150], command_off: [0x0000], verify: a_grips}}
  b:
    {kind: vacuum, channel: b_vacuum,
     modbus: {unit: 65, address: 1, command_on: [0x0150], command_off: [0x0000], verify: b_grips}}
supply: {channel: none}
"""


def test_two_actuators_hang_on_one_unit(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(CUPS)
    tool = load_tool(path)
    played = VirtualTool(tool, models=chosen_models("65=onrobot-vg10", tool))
    played.run(1)
    assert played.command("grip").accepted
    assert played.run_until(10 * S, lambda: played.status.ee == EndEffectorState.GRIPPED)
    assert [each.line for each in played.edges] == ["modbus:65/0x0000", "modbus:65/0x0001"]
    played.choose("lost-after:b:0.1")
    played.run(2)
    assert [played.bench.devices[name].grips for name in "ab"] == [True, False]
    assert played.status.ee == EndEffectorState.GRIP_ERROR
    assert all(played.levels.values()), "only a Drop releases"
    assert played.command("drop").accepted
    played.run(8)
    assert not any(played.levels.values())


def test_unit_0_is_a_unit_where_a_device_has_it_and_all_of_them_elsewhere(gripper: Description) -> None:
    """Over Modbus TCP unit 0 is often the device itself; on a line it is the broadcast, which none answers."""
    read, on_a_line = sealed(bytes.fromhex("00 04 07D0 0003")), board(gripper)
    assert on_a_line.answer(sealed(bytes.fromhex("00 06 03E8 0100")), 1 * S) is None
    activates = on_a_line.answer(STATUS, 1 * S + 10_000)
    assert activates is not None
    assert activates.data[3] == 0x11, "gACT, and gSTA 1: it was executed"
    assert on_a_line.answer(read, 2 * S) is None
    text = (
        (TOOLS / "gripper_2f85/end_effector.yaml").read_text().replace("/dev/ttyUSB0", "tcp://192.168.1.20")
    )
    found = examine_text(
        text.replace("{device: robotiq-2f85}", "{device: robotiq-2f85, unit: 0}"), "tool.yaml"
    )
    assert found.description is not None, found.lines()
    sent = board(found.description, models="0=robotiq-2f85").answer(read, 1 * S)
    assert sent is not None
    assert sent.data.startswith(bytes.fromhex("00 04 06"))


@pytest.mark.parametrize(
    "valve",
    [
        "command_on: [1, 0], command_off: [0, 1], pulse_s: 0.1",
        "command_on: [1], command_off: [0], opposite: {address: 9}, pulse_s: 0.1",
        "command_on: [1], command_off: [0], opposite: {address: 9}",
    ],
)
def test_a_valve_with_two_coils_at_a_station_stays_where_a_coil_has_moved_it(valve: str) -> None:
    text = f"""
schema: 2
name: lift
link: {{port: /dev/ttyUSB0, baudrate: 115200, frame: {{modbus: {{}}}}}}
channels:
  up: {{modbus: {{address: 0, register_type: discrete_input}}}}
sequence: [lift]
actuators:
  lift: {{kind: cylinder, channel: none, extended_bit: up, retracted_bit: none,
    modbus: {{address: 3, register_type: coil, {valve}}}}}
supply: {{channel: none}}
"""
    tool = examine_text(text, "tool.yaml").description
    assert tool is not None
    played = VirtualTool(tool, models=chosen_models("1=remote-io", tool))
    played.run(1)
    for command, state in (("grip", EndEffectorState.GRIPPED), ("drop", EndEffectorState.STAND_BY)):
        assert played.command(command).accepted
        assert played.run_until(played.at + 10 * S, lambda state=state: played.status.ee == state)
        played.run(1)
        assert played.status.ee == state


def test_an_open_wire_reads_0_at_an_input_of_a_modelled_board() -> None:
    """The bit of one cup goes, the other one's stays; the description has no value for "open"."""
    tool = VirtualTool(load_tool(ROOT / "examples/cells/three_parts/end_effector.yaml"))
    tool.run(1.0)
    assert tool.command("grip", part="sheet").accepted
    assert tool.run_until(20 * S, lambda: tool.status.ee is EndEffectorState.GRIPPED)
    tool.choose("invalid:left")
    tool.run(1.0)
    assert tool.status.ee is EndEffectorState.GRIP_ERROR
    assert tool.status.reason.startswith("Left was lost")
    assert [each.name for each in tool.status.evidence] == ["PARTIAL", "CONFIRMED", "GONE"]
