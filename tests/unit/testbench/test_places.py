from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.description import Description, load
from end_effector_hal.errors import UsageError
from end_effector_lab.testbench import open_inputs, open_ports, write_description
from end_effector_lab.testbench._ports import PtyPort, SerialPort
from end_effector_lab.testbench.inputs import (
    GpioInputs,
    GpioSimInputs,
    VirtualInputs,
)
from tests.support.parts import with_parts
from tools.board import pins_of


@pytest.fixture
def virtual(verdin: Description) -> Description:
    return verdin.with_virtual("/nowhere/chip", "/nowhere/uart")


def test_the_description_decides_where_nothing_is_said(virtual: Description) -> None:
    inputs, port = open_inputs(None, virtual), open_ports(None, virtual, None)[""]
    assert isinstance(inputs, VirtualInputs)
    assert isinstance(port, PtyPort)
    assert (inputs.text, port.text) == ("virtual:/nowhere/chip", "/nowhere/uart")


def test_a_copy_has_the_same_default_part(verdin: Description, tmp_path: Path) -> None:
    write_description(with_parts(verdin), tmp_path / "copy.yaml", "a copy")
    assert load(tmp_path / "copy.yaml").part_names == ("panel", "lid")


def test_the_preset_is_the_wiring_of_the_paper(verdin: Description) -> None:
    inputs, port = open_inputs("rpi3", verdin), open_ports(None, verdin, "rpi3")[""]
    assert isinstance(inputs, GpioInputs)
    assert inputs.lines == {
        "SODIMM_206": "GPIO19",
        "SODIMM_208": "GPIO16",
        "SODIMM_210": "GPIO26",
        "SODIMM_212": "GPIO20",
    }
    assert isinstance(port, SerialPort)
    assert port.text == "/dev/serial0"


def test_the_wiring_follows_the_devices_and_not_the_sequence(verdin: Description) -> None:
    turned = verdin.model_copy(update={"sequence": verdin.sequence[::-1]})
    inputs = open_inputs("rpi3", turned)
    assert isinstance(inputs, GpioInputs)
    assert inputs.lines["SODIMM_212"] == "GPIO20"


def test_lines_of_this_machine(verdin: Description) -> None:
    same = open_inputs("gpiod", verdin)
    assert isinstance(same, GpioInputs)
    assert same.lines["SODIMM_206"] == "SODIMM_206"
    other = open_inputs("gpiod:SODIMM_206=A,SODIMM_208=B,SODIMM_210=C,SODIMM_212=D", verdin)
    assert isinstance(other, GpioInputs)
    assert other.lines["SODIMM_212"] == "D"


def test_lines_of_a_kernel_that_simulates_them(verdin: Description) -> None:
    assert isinstance(open_inputs("gpio-sim", verdin), GpioSimInputs)


def test_ports(verdin: Description) -> None:
    pty = open_ports("pty:/tmp/x", verdin, "rpi3")[""]
    device = open_ports("/dev/ttyUSB0", verdin, "virtual:/x")[""]
    assert isinstance(pty, PtyPort)
    assert pty.text == "/tmp/x"
    assert isinstance(device, SerialPort)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "the description has no virtual lines"),  # the HAL's own outputs are never taken as inputs
        ("virtual", "lines cannot be read from 'virtual'"),
        ("virtual:", "lines cannot be read from"),
        ("virtual-gpio:x", "lines cannot be read from 'virtual-gpio:x'"),
        ("rpi4", "Expected: virtual:PATH, gpiod"),
        ("gpiod:SODIMM_206=A", "Expected: gpiod:SODIMM_206=NAME,SODIMM_208=NAME"),
        ("gpiod:SODIMM_206=,SODIMM_208=B,SODIMM_210=C,SODIMM_212=D", "does not name each line once"),
    ],
)
def test_refuses_lines(verdin: Description, text: str | None, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        open_inputs(text, verdin)
    assert message in str(caught.value)


def test_a_device_that_the_preset_does_not_know(verdin: Description) -> None:
    cup = verdin.actuators["top_vacuum"].model_copy(update={"channel": "side"})
    other = verdin.model_copy(update={"actuators": dict(verdin.actuators) | {"top_vacuum": cup}})
    with pytest.raises(UsageError, match="rpi3 has no pin for SODIMM_212"):
        open_inputs("rpi3", other)


def test_a_line_that_the_emulated_board_does_not_have(verdin: Description) -> None:
    cup = verdin.actuators["top_vacuum"].model_copy(update={"line": "SODIMM_999"})
    other = verdin.model_copy(update={"actuators": dict(verdin.actuators) | {"top_vacuum": cup}})
    with pytest.raises(UsageError, match="has no line SODIMM_999"):
        pins_of(other)


def test_real_lines_cannot_be_power_cycled(verdin: Description) -> None:
    with pytest.raises(UsageError, match="only virtual lines"):
        open_inputs("rpi3", verdin, power_cycle=True)


def test_no_port_is_known_for_other_boards(verdin: Description) -> None:
    with pytest.raises(UsageError, match="Give --port PATH"):
        open_ports(None, verdin, "gpiod")
