"""Hints about valid descriptions: times that are too short for a link, numbers that are probably not meant."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli import _check
from tests.support.places import ROOT
from tests.unit.cli.check.conftest import NIBBLE, Check, sentences


def test_times_that_the_link_is_too_slow_for_are_told(check: Check) -> None:
    result = check("--json", replace=NIBBLE)
    told = json.loads(result.stdout)
    assert (told["ok"], result.exit_code) == (True, 0)
    too_early = "is over before a reading of legacy-nibble is stale (3 s, one each 1 s): a late or lost frame fails it"
    again = "is no longer than a period of legacy-nibble (1 s): what one attempt showed may confirm the next"
    names = ("bottom_vacuum", "cylinder", "top_vacuum")
    assert told["warnings"] == [
        *(f"{name}: release_s = 2 s {too_early}" for name in names),
        f"tool changer: prove_s = 2 s {too_early}",
        *(f"{name}: reset_s = 1 s {again}" for name in names),
    ]
    plain = check(replace=NIBBLE)
    assert plain.stdout.count("\nwarning  ") == 7
    enough = {"release_s: 2.0": "release_s: 3.1", "reset_s: 1.0": "reset_s: 1.1"}
    result = check("--json", replace=enough | NIBBLE)
    assert [each for each in json.loads(result.stdout)["warnings"] if each.startswith("bottom_vacuum")] == []
    slow = json.loads(check("--json", replace={"baudrate: 115200": "stale_s: 2.5\n  down_s: 3"}).stdout)
    assert "tool changer: prove_s = 2 s is over before" in slow["warnings"][-1]


def test_samples_that_take_longer_than_the_time_out_can_never_confirm(check: Check) -> None:
    slow = NIBBLE | {"lost_kpa: 50.0": "confirmed_samples: 6"}
    result = check(replace=slow)
    assert result.exit_code == 2
    assert sentences(result) == [
        "tool.yaml:31:24: 'bottom_vacuum' can never be confirmed: 6 samples take 5 s (legacy-nibble), "
        "expected less than timeout_s = 5 [EE-225]"
    ]
    assert check(replace=slow | {"lost_kpa: 50.0": "confirmed_samples: 5"}).exit_code == 0


def test_the_number_of_a_register_in_a_manual_is_told(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(
        "schema: 2\nname: tool\nlink: {port: x, frame: {modbus: {}}}\n"
        "channels: {p: {modbus: {address: 40003}, unit: kPa}}\n"
        "sequence: [a]\nactuators: {a: {kind: vacuum, line: A, channel: p}}\nsupply: {channel: none}\n"
    )
    assert _check.check(path).hints == (
        f"{path}:4:34: is 40003 the number in a manual? On the wire that is address: 2, register_type: holding",
    )


def test_a_frame_without_a_checksum_and_a_channel_that_nothing_uses_are_told(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    frame = "link: {port: x, period_ms: 20, frame: {text: {separator: ';'%s}}}\n"
    rest = (
        "channels: {p: {text: {key: A}, unit: kPa}, q: {text: {key: B}, unit: kPa}}\n"
        "sequence: [a]\nactuators: {a: {kind: vacuum, line: A, channel: p}}\nsupply: {channel: none}\n"
    )
    path.write_text("schema: 2\nname: tool\n" + frame % "" + rest)
    unchecked, unused = _check.check(path).hints
    assert unchecked.startswith(f"{path}:3:")
    assert "without a checksum" in unchecked
    assert unused.startswith(f"{path}:4:")
    assert unused.endswith("nothing uses the channel q")
    path.write_text("schema: 2\nname: tool\n" + frame % ", checksum: xor8" + rest)
    assert _check.check(path).hints == (unused,)


def test_a_sequence_of_numbers_is_not_called_empty(check: Check) -> None:
    result = check(replace={"sequence: [bottom_vacuum, cylinder, top_vacuum]": "sequence: [1, 2]"})
    assert result.exit_code == 2
    assert "'sequence[0]' is of the wrong type (1), expected text" in result.stderr
    assert "is empty" not in result.stderr


def test_what_a_commanded_device_reports_of_itself_is_used() -> None:
    for tool in ("epick_commanded", "gripper_2f85"):
        assert _check.check(ROOT / "examples" / "tools" / tool / "end_effector.yaml").hints == ()


def test_a_threshold_that_alarms_and_the_page_do_not_show_is_told(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    text = (
        "schema: 2\nname: tool\nlink: {port: x, frame: {text: {checksum: xor8}}}\n"
        "channels: {p: {text: {field: 1}, unit: kPa}}\nsequence: [a]\n"
        "actuators: {a: {kind: vacuum, line: A, channel: p, gone_kpa: %s}}\nsupply: {channel: none}\n"
    )
    path.write_text(text % 9.5)
    assert _check.check(path).hints == ()
    path.write_text(text % 9.95)
    (said,) = _check.check(path).hints
    assert said.startswith(f"{path}:6:")
    assert "a threshold finer than 0.1 kPa" in said


PASTED = """\
schema: 2
name: pasted
link: {port: /dev/ttyUSB0, LINK, frame: {modbus: {FRAME}}}
channels:
  v: {modbus: {unit: 1, address: 0x9005, REGISTER}, CHANNEL, unit: kPa}
supply: {channel: none}
actuators:
  cup:
    kind: vacuum
    channel: v
    modbus: {address: 5, command_on: [1], command_off: [0], COMMAND, on_link_loss: hold}
sequence: [cup]
"""


def pasted(**keys: str) -> str:
    """PASTED with these keys at their places, and none at the others."""
    text = PASTED
    for place in ("LINK, ", "COMMAND, ", "FRAME", ", REGISTER", "CHANNEL, "):
        name = place.strip(", ")
        text = text.replace(name, keys[name]) if name in keys else text.replace(place, "")
    return text


@pytest.mark.parametrize(
    ("where", "key", "hint"),
    [
        ("LINK", "timeout: 5", "; write timeout_ms under frame.modbus of the link, in milliseconds"),
        ("COMMAND", "timeout: 5", "; write timeout_ms under frame.modbus of the link, in milliseconds"),
        ("FRAME", "timeout: 5", "; write timeout_ms"),
        ("LINK", "scan_interval: 1", "; write period_ms under the link, in milliseconds"),
        ("LINK", "delay: 2", ""),
        ("LINK", "message_wait_milliseconds: 30", "; write pause_ms under frame.modbus of the link"),
        ("FRAME", "message_wait_milliseconds: 30", "; write pause_ms"),
        ("LINK", "method: rtu", "; leave it out: frame: {modbus: {}} is RTU, with the port tcp://HOST Modbus TCP"),
        ("LINK", "bytesize: 8", "; leave it out: a byte has 8 bits"),
        ("FRAME", "retries: 3", "; leave it out: the next period asks again"),
        ("LINK", "serial_port: /dev/ttyS0", "; write port"),
        ("REGISTER", "data_type: int16", "; write value_type"),
        ("REGISTER", "device_address: 3", "; write unit"),
        ("REGISTER", "nan_value: 0x8000", "; write invalid, beside modbus"),
        ("CHANNEL", "min_value: -100", "; write range: [lowest, highest]"),
        ("CHANNEL", "payload_on: ON", "; write on"),
        (
            "CHANNEL",
            'value_template: "{{ value_json.p }}"',
            "; write json: {key: …} with the path behind value_json, and frame: {json: {}} for the link",
        ),
        ("COMMAND", "on_power_loss: hold", "; it belongs to actuators.cup"),
        ("FRAME", "on_power_loss: hold", "; it belongs to actuators.<name>"),
    ],
)  # fmt: skip
def test_a_pasted_key_is_sent_to_its_place_or_nowhere(
    where: str, key: str, hint: str, tmp_path: Path
) -> None:
    text = pasted(**{where: key})
    path = tmp_path / "tool.yaml"
    path.write_text(text, "utf-8")
    faults = json.loads(CliRunner().invoke(_check.command, ["--json", str(path)]).output)["faults"]
    (said,) = (each["message"] for each in faults if key.partition(":")[0] in each["message"])
    assert said.partition(";")[1] + said.partition(";")[2] == hint


@pytest.mark.parametrize(
    ("link", "bus"),
    [
        ("port: ethercat://0, frame: {modbus: {}}", "EtherCAT"),
        ("port: /dev/ttyS0, frame: {ethercat: {}}", "EtherCAT"),
        ("port: /dev/ttyS0, ethercat: {slave: 1}, frame: {modbus: {}}", "EtherCAT"),
        ("port: 'profinet://plc', frame: {modbus: {}}", "PROFINET"),
        ("port: /dev/ttyS0, codec: profinet", "PROFINET"),
        ("port: eip://192.168.1.20, frame: {modbus: {}}", "EtherNet/IP"),
        ("port: tcp://192.168.1.20, codec: ethernet-ip", "EtherNet/IP"),
        ("port: can0, frame: {modbus: {}}", "CAN"),
        ("port: can0, frame: {canopen: {}}", "CAN"),
        ("port: opc.tcp://plc:4840, frame: {modbus: {}}", "OPC UA"),
        ("port: tcp://plc, codec: opc_ua", "OPC UA"),
    ],
)
def test_a_fieldbus_that_is_not_supported_is_refused_by_its_name(link: str, bus: str, tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(
        f"schema: 2\nname: tool\nlink: {{{link}}}\nsequence: [a]\n"
        "actuators: {a: {kind: vacuum, line: A, channel: p}}\nsupply: {channel: none}\n"
    )
    result = CliRunner().invoke(_check.command, ["--json", str(path)])
    assert result.exit_code == 2
    said = [each["message"] for each in json.loads(result.output)["faults"]]
    assert any(
        f"{bus} is not supported: use a gateway or an I/O station with Modbus TCP" in each for each in said
    ), said
    assert not any("for Modbus TCP, or rtu+tcp" in each for each in said)


def test_a_hexadecimal_address_is_no_number_of_a_manual(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    text = pasted()
    for written, told in (("0x9005", False), ("0x9C41", False), ("40001", True)):
        path.write_text(text.replace("0x9005", written), "utf-8")
        hints = json.loads(CliRunner().invoke(_check.command, ["--json", str(path)]).output)["hints"]
        assert any("manual" in each for each in hints) is told, written


@pytest.mark.parametrize(
    ("contact", "told"),
    [
        ("bias: pull_up}", "wire a normally closed contact to ground and write invert: true"),
        ("bias: pull_up}, on: [1]", "write invert: true"),
        ("bias: pull_up}, invert: true", ""),
        ("bias: pull_up}, on: [0]", ""),
        ("bias: pull_down}, invert: true", "wire a normally closed contact to the supply and write invert: false"),
        ("bias: pull_down}", ""),
        ("bias: as_is}", ""),
    ],
)  # fmt: skip
def test_an_e_stop_whose_cut_wire_reads_as_closed_is_warned_of(
    contact: str, told: str, tmp_path: Path
) -> None:
    jaw = ROOT / "examples/tools/double_acting_jaw/end_effector.yaml"
    text = re.sub(r"(estop_ok: \{digital: \{line: \w+).*", rf"\1, {contact}}}", jaw.read_text("utf-8"))
    path = tmp_path / "tool.yaml"
    path.write_text(text, "utf-8")
    result = json.loads(CliRunner().invoke(_check.command, ["--json", str(path)]).output)
    warned = [each for each in result["warnings"] if each.startswith("e_stop: estop_ok: a cut wire")]
    assert result["ok"], result
    assert (told in warned[0] and len(warned) == 1) if told else not warned


def test_a_period_with_which_a_silence_is_seen_late_is_warned_of(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    for period, told in (
        ({}, ""),
        ({"LINK": "period_ms: 150"}, ""),
        ({"LINK": "period_ms: 2000"}, "only after 6 s, and the link is down after 14 s"),
    ):
        path.write_text(pasted(**period), "utf-8")
        warned = json.loads(CliRunner().invoke(_check.command, ["--json", str(path)]).output)["warnings"]
        late = [each for each in warned if "may be detected only after" in each]
        assert [told in each for each in late] == [True] * bool(told), warned
