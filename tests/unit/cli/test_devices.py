"""``eehal devices``, and what ``eehal check`` and ``eehal init`` say of devices."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import DeviceLibrary, load
from end_effector_hal.errors import DescriptionError, UsageError


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(eehal, arguments, catch_exceptions=False)


def said(*arguments: str) -> str:
    """The output of a command that succeeds, with single blanks."""
    result = run(*arguments)
    assert result.exit_code == 0, result.output
    return "\n".join(" ".join(line.split()) for line in result.stdout.splitlines())


def test_all_are_listed_with_their_kind_and_how_each_is_confirmed() -> None:
    lines = said("devices").splitlines()
    assert lines[0] == "name device kind confirmed by from"
    assert "robotiq-epick Robotiq EPick vacuum drivers shipped" in lines
    assert len(lines) == len(DeviceLibrary().names()) + 1


def test_one_is_shown_with_its_registers_and_what_is_not_confirmed() -> None:
    lines = said("devices", "robotiq-2f85").splitlines()
    assert lines[0] == "robotiq-2f85: Robotiq 2F-85 (Robotiq), kind gripper"
    assert "0x03E9: low byte: position; 0 open, 255 closed (document 1, p. 31)" in lines
    assert "not confirmed: the whole, on a real device" in lines


def test_as_json_it_is_what_the_file_says() -> None:
    shown = json.loads(said("devices", "robotiq-2f85", "--json"))
    assert (shown["name"], shown["kind"], shown["confirmed"], shown["unit"]) == (
        "robotiq-2f85", "gripper", "maker", 9,
    )  # fmt: skip
    listed = json.loads(said("devices", "--json"))["devices"]
    assert [each["name"] for each in listed] == DeviceLibrary().names()


def test_a_folder_of_ones_own_is_listed_too_and_a_fault_in_it_is_said() -> None:
    Path("mine").mkdir()
    Path("mine/jaw.yaml").write_text("title: x\n")
    with pytest.raises(DescriptionError, match=r"mine/jaw.yaml:1:1: maker: field required"):
        run("devices", "jaw", "--folder", "mine")
    with pytest.raises(UsageError, match="There is no such folder"):
        run("devices", "--folder", "nowhere")


def test_an_unknown_one_is_refused_with_the_nearest() -> None:
    with pytest.raises(UsageError, match=r"There is no device 'robotik-2f85'. Did you mean 'robotiq-2f85'"):
        run("devices", "robotik-2f85")


def test_a_new_tool_with_devices_takes_few_lines_and_is_valid() -> None:
    said("init", "tool", "--actuators", "fingers:robotiq-2f85")
    text = Path("tool/end_effector.yaml").read_text()
    assert len(text.splitlines()) == 7
    assert load("tool/end_effector.yaml").used_devices["fingers"].name == "robotiq-2f85"
    assert "(EE-" not in run("check", "tool/end_effector.yaml").output


def test_two_equal_devices_on_one_bus_get_two_units_and_two_cup_groups_one() -> None:
    said("init", "two", "--actuators", "left:robotiq-epick,right:robotiq-epick")
    outputs = load("two/end_effector.yaml").register_outputs
    assert [each.unit for each in outputs.values()] == [9, 10]
    said("init", "both", "--actuators", "fingers:robotiq-2f85,cup:robotiq-epick")
    assert [each.unit for each in load("both/end_effector.yaml").register_outputs.values()] == [9, 10]
    said("init", "groups", "--actuators", "left:onrobot-vg10,right:onrobot-vg10")
    assert [each.unit for each in load("groups/end_effector.yaml").register_outputs.values()] == [65, 65]


def test_devices_on_links_of_their_own() -> None:
    said("init", "tool", "--virtual", "--actuators", "fingers:robotiq-2f85:left,cup:onrobot-vg10:right")
    tool = load("tool/end_effector.yaml")
    assert {name: Path(each.port).name for name, each in tool.links.items()} == {
        "left": "uart_left", "right": "uart_right"
    }  # fmt: skip
    assert tool.lines.backend == "virtual"


def test_devices_at_addresses() -> None:
    said("init", "one", "--actuators", "fingers:robotiq-2f85", "--port", "tcp://192.168.1.11")
    assert load("one/end_effector.yaml").links[""].port == "tcp://192.168.1.11"
    two = ("--port", "left=tcp://plc", "--port", "right=/dev/ttyS1")
    said("init", "two", "--actuators", "fingers:robotiq-2f85:left,cup:onrobot-vg10:right", *two)
    ports = {name: each.port for name, each in load("two/end_effector.yaml").links.items()}
    assert ports == {"left": "tcp://plc", "right": "/dev/ttyS1"}


@pytest.mark.parametrize(
    ("actuators", "more", "why"),
    [
        ("a:robotiq-2f85,b:vacuum", (), "b is a kind, and others are devices"),
        ("a:robotiq-2f85:x,b:robotiq-epick", (), "Only some of the actuators name a link"),
        ("a:robotiq-2f85", ("--link", "text"), "A device of the library has its own link"),
        ("a:robotiq-2f85", ("--port", "b=tcp://plc"), "Expected: --port PORT."),
        ("a:robotiq-2f85", ("--port", "tcp://plc", "--virtual"), "--virtual has ports of its own"),
        ("a:waveshare-io-8", (), "waveshare-io-8 is an I/O board"),
        ("a:robotiq-2f8", (), "There is no kind and no device 'robotiq-2f8'"),
        ("a:robotiq-2f85,b:onrobot-vg10", (), "robotiq-2f85 needs parity: N, and onrobot-vg10 on the same link E"),
    ],
)  # fmt: skip
def test_what_cannot_be_written_is_refused(actuators: str, more: tuple[str, ...], why: str) -> None:
    with pytest.raises(UsageError, match=why):
        run("init", "tool", "--actuators", actuators, *more)
    assert not Path("tool").exists()


def test_check_says_what_came_from_where() -> None:
    Path("tool.yaml").write_text(
        "name: tool\nlink: {port: /dev/a}\nsequence: [fingers]\n"
        "actuators: {fingers: {device: robotiq-2f85, timeout_s: 9}}\nsupply: {channel: none}\n"
    )
    (line,) = [each for each in said("check", "tool.yaml").splitlines() if each.startswith("device ")]
    assert line.startswith("device fingers: robotiq-2f85, Robotiq 2F-85 (/")
    assert line.endswith("confirmed by a document of the maker; written here: actuators.fingers.timeout_s")
    (device,) = json.loads(said("check", "tool.yaml", "--json"))["devices"]
    assert device["written_here"] == ["actuators.fingers.timeout_s"]
    assert "fingers_part" in device["channels"]
