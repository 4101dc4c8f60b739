"""A description against the channels that it declares itself: what no wire carries, in words."""

from __future__ import annotations

from functools import partial
from itertools import count
from pathlib import Path

import pytest

from end_effector_hal.codecs import match_codec
from end_effector_hal.description import examine_text
from end_effector_hal.errors import LinkBusyError
from end_effector_hal.wires.link import _port, _reader
from end_effector_hal.wires.sensors import SensorReader

TEXT = "frame: {text: {}}"
CUP = "cup: {text: {field: 1}, unit: kPa}"
PART = "part: {text: {field: 2}}"
ANALOG = "adc: {analog: {device: ads1015, channel: voltage0}, unit: kPa}"


def matched(
    link: str, channels: list[str], actuator: str, more: str = "supply: {channel: none}"
) -> list[str]:
    """The faults of a tool; a channel stands in line 6 and those that follow, the actuator in the last but one."""
    lines = [
        "name: tool",
        "sequence: [a]",
        *([f"link: {{port: x, {link}}}"] if link else []),
        *(["channels:", *(f"  {each}" for each in channels)] if channels else []),
        "actuators:",
        f"  a: {actuator}",
        more,
    ]
    examination = examine_text("\n".join(lines) + "\n", "tool.yaml")
    assert examination.description is not None, examination.lines()
    return [
        f"{fault.line}:{fault.column}: {fault.message} [{fault.code}]"
        for fault in match_codec(examination.description).faults
    ]


@pytest.mark.parametrize(
    ("link", "channels", "actuator", "faults"),
    [
        (TEXT, [CUP], "{kind: vacuum, line: A, channel: cup}", []),
        (TEXT, [PART], "{kind: vacuum, line: A, channel: part}", []),
        (
            TEXT,
            [CUP, PART],
            "{kind: vacuum, line: A, channel: cupp}",
            [
                "8:39: the declared frame carries nothing that could confirm 'a' (cupp), expected a free channel of "
                "the declared frame: cup, part; did you mean 'cup'? [EE-225]"
            ],
        ),
        (
            TEXT,
            [PART],
            "{kind: cylinder, line: A, channel: none, extended_bit: part, retracted_bit: back}",
            [
                "7:82: the declared frame carries no 'back' (back), expected a bit of the declared frame: part; "
                "if there is no such sensor, write retracted_bit: none [EE-225]"
            ],
        ),
        (
            "",
            [ANALOG],
            "{kind: vacuum, line: A, channel: cup}",
            [
                "6:39: the board carries nothing that could confirm 'a' (cup), expected a free channel of the board: "
                "adc [EE-225]"
            ],
        ),
        (
            TEXT,
            [CUP, ANALOG],
            "{kind: vacuum, line: A, channel: top}",
            [
                "8:39: the wiring carries nothing that could confirm 'a' (top), expected a "
                "free channel of the wiring: cup, adc [EE-225]"
            ],
        ),
        (
            "codec: ees1-ascii",
            ["bottom: {analog: {device: ads1015, channel: voltage0}, unit: kPa}"],
            "{kind: vacuum, line: A, channel: bottom}",
            ["5:3: ees1-ascii carries a channel of this name, too (bottom), expected another name [EE-221]"],
        ),
        (
            "frame: {modbus: {}}, period_ms: 20",
            ["cup: {modbus: {address: 1}, unit: kPa}", "b: {modbus: {unit: 2, address: 1}, unit: kPa}"],
            "{kind: vacuum, line: A, channel: cup}",
            ["3:49: one frame takes 51 ms at 9600 baud (20), expected at least 51 [EE-228]"],
        ),
        (
            "frame: {record: {start: AA, length: 100}}, baudrate: 9600, period_ms: 100",
            ["cup: {record: {byte: 1}, unit: kPa}"],
            "{kind: vacuum, line: A, channel: cup}",
            ["3:87: one frame takes 106 ms at 9600 baud (100), expected at least 106 [EE-228]"],
        ),
    ],
)
def test_what_is_said(link: str, channels: list[str], actuator: str, faults: list[str]) -> None:
    assert matched(link, channels, actuator) == faults


def test_a_supply_that_nobody_declares() -> None:
    (fault,) = matched(TEXT, [PART], "{kind: vacuum, line: A, channel: part}", "supply: {warn_kpa: 450}")
    assert fault == (
        "8:1: the declared frame carries no 'supply' (channel: supply (default)), expected such a pressure under "
        "channels; if there is no such sensor, write channel: none [EE-225]"
    )


def test_without_pymodbus_the_command_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    for name in [
        name for name in sys.modules if name.endswith("described._modbus") or ".codecs.modbus" in name
    ]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pymodbus.framer", None)
    monkeypatch.setitem(sys.modules, "pymodbus", None)
    (fault,) = matched(
        "frame: {modbus: {}}",
        ["cup: {modbus: {address: 1}, unit: kPa}"],
        "{kind: vacuum, line: A, channel: cup}",
    )
    assert "a Modbus frame needs pymodbus, which is not installed" in fault
    assert "pip install '.[modbus]' in a checkout of end-effector-hal" in fault


def test_a_recorded_description_can_be_read_again() -> None:
    """A trace has every key with its default; replay examines it as it does a file."""
    for folder in ("diy_text", "diy_record", "two_epick"):
        path = Path("examples/tools", folder, "end_effector.yaml")
        tool = examine_text(path.read_text(encoding="utf-8"), path).description
        assert tool is not None
        again = examine_text(tool.model_dump_json(by_alias=True, exclude={"automata"}), path)
        assert again.lines() == []
        assert again.description is not None
        assert again.description.fingerprint() == tool.fingerprint()


def test_the_port_is_opened_as_the_link_says(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[tuple[str, int, str, int]] = []

    def open_port(path: str, baudrate: int, *, parity: str, stopbits: int) -> None:
        opened.append((path, baudrate, parity, stopbits))
        raise LinkBusyError("the port is used by a test.")

    monkeypatch.setattr(_port, "open_port", open_port)
    monkeypatch.setattr(_reader, "now_us", partial(next, count(step=2_000_000)))  # nobody waits for the port
    for link in (
        "frame: {text: {}}",
        "frame: {text: {}}, baudrate: 9600, parity: E",
        "parity: O, stopbits: 2",
    ):
        channel = "channels: {cup: {text: {field: 1}, unit: kPa}}\n" if "frame" in link else ""
        text = f"name: tool\nsequence: [a]\n{channel}link: {{port: p, {link}}}\n"
        examination = examine_text(
            text + "actuators: {a: {kind: vacuum, line: A, channel: cup}}\nsupply: {channel: none}\n",
            "tool.yaml",
        )
        assert examination.description is not None, examination.lines()
        with pytest.raises(LinkBusyError):
            SensorReader(examination.description, lambda frame: None).start()
    assert [*dict.fromkeys(opened)] == [("p", 115_200, "N", 1), ("p", 9_600, "E", 1), ("p", 115_200, "O", 2)]
