"""Stop bits of a link: what the description says stands in the settings of the port, whoever opens it."""

from __future__ import annotations

import os
import pty
import termios
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._check import command as check
from end_effector_hal.codecs import codec_of, line_of
from end_effector_hal.description import Description, load
from end_effector_hal.errors import LinkError
from end_effector_hal.wires.bus import BusLink
from end_effector_hal.wires.bus._lines import BusLines
from end_effector_hal.wires.link import open_port
from end_effector_hal.wires.link._reader import LinkReader
from end_effector_hal.wires.sensors import SensorReader
from end_effector_lab.testbench import open_ports

TOOL = """\
name: cup
link: {{port: {port}, frame: {{text: {{start: "$"}}}}{more}}}
channels: {{cup: {{text: {{field: 1}}, unit: kPa}}}}
sequence: [cup]
actuators: {{cup: {{kind: vacuum, line: GPIO1, channel: cup}}}}
supply: {{channel: none}}
"""


@pytest.fixture
def port() -> Iterator[str]:
    master, slave = pty.openpty()
    yield os.ttyname(slave)
    os.close(master)
    os.close(slave)


def tool(folder: Path, port: str, more: str) -> Description:
    file = folder / "tool.yaml"
    file.write_text(TOOL.format(port=port, more=more))
    return load(file)


def two_stop_bits(port: str) -> bool:
    """As the kernel has it."""
    descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY)
    try:
        return bool(termios.tcgetattr(descriptor)[2] & termios.CSTOPB)
    finally:
        os.close(descriptor)


@pytest.mark.parametrize(("more", "expected"), [("", 1), (", stopbits: 1", 1), (", stopbits: 2", 2)])
def test_each_who_opens_the_port_sets_them(tmp_path: Path, port: str, more: str, expected: int) -> None:
    described = tool(tmp_path, port, more)
    codec = codec_of(described)
    settings = line_of(described.links[""], codec)
    assert settings == (115_200, "N", expected)
    reader = SensorReader(described, lambda _: None)._sources[0]  # of the HAL
    assert isinstance(reader, LinkReader)
    with closing(reader._open()):
        assert two_stop_bits(port) is (expected == 2)
    bus = BusLines.__new__(BusLines)  # of the line arbiter, which masters a bus
    bus._link = BusLink(port, codec, *settings)  # type: ignore[arg-type]
    with closing(bus._open()):
        assert two_stop_bits(port) is (expected == 2)
    (other_end,) = open_ports(port, described, None).values()  # of the testbench
    other_end.open()
    assert two_stop_bits(port) is (expected == 2)
    other_end.close()


def test_check_says_them_and_knows_the_word_of_others(tmp_path: Path, port: str) -> None:
    tool(tmp_path, port, ", stopbits: 2")
    said = CliRunner().invoke(check, [str(tmp_path / "tool.yaml")]).stdout
    assert "115200 baud 8N2" in said
    (tmp_path / "tool.yaml").write_text(TOOL.format(port=port, more=", stop_bits: 2"))
    other = CliRunner().invoke(check, [str(tmp_path / "tool.yaml")])
    assert "write stopbits" in other.output + str(other.exception)


def test_by_default_it_is_one(port: str) -> None:
    with open_port(port, 9600, stopbits=2):
        assert two_stop_bits(port)
    with open_port(port, 9600):
        assert not two_stop_bits(port)


@pytest.mark.parametrize("parity", ["E", "O"])
def test_a_pseudo_terminal_is_opened_again_with_a_parity_that_it_cannot_have(port: str, parity: str) -> None:
    for _ in range(3):
        open_port(port, 115_200, parity=parity).close()


def test_a_port_that_refuses_its_settings_is_one_sentence(port: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise termios.error(22, "Invalid argument")

    monkeypatch.setattr("serial.Serial", refuse)
    with pytest.raises(LinkError) as refused:
        open_port(port, 115_200, parity="E")
    assert refused.value.what == "the port refuses 115200 baud, parity E, 1 stop bits: Invalid argument."
