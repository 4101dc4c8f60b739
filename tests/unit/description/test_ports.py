"""The port of a link: a device, or an address in a network that fits its frames; all else that looks like one is
refused with the right form.
"""

from __future__ import annotations

import pytest

from end_effector_hal.description import NetworkAddress, examine_text, network_address

TOOL = """
name: tool
link: {{port: "{port}", frame: {{{frame}: {{}}}}{more}}}
channels: {{cup: {{{channel}, unit: kPa}}}}
sequence: [a]
actuators: {{a: {{kind: vacuum, line: A, channel: cup}}}}
supply: {{channel: none}}
"""
CHANNEL = {"modbus": "modbus: {address: 1}", "text": "text: {field: 1}"}
TCP, GATEWAY = "tcp://{} for Modbus TCP", "or rtu+tcp://{} for a gateway"


def faults(port: str, frame: str, more: str = "") -> list[str]:
    text = TOOL.format(port=port, frame=frame, channel=CHANNEL[frame], more=more)
    return list(examine_text(text, "tool.yaml").lines())


@pytest.mark.parametrize(
    ("port", "frame"),
    [
        ("/dev/ttyUSB0", "modbus"),
        ("/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0", "modbus"),
        ("uart.pty", "text"),
        ("/dev/canary0", "text"),
        ("tcp://192.168.1.20", "modbus"),
        ("tcp://plc.local:1502", "modbus"),
        ("tcp://[fe80::1%eth0]:502", "modbus"),
        ("rtu+tcp://192.168.1.20:4001", "modbus"),
        ("socket://scale-3:4001", "text"),
        ("rfc2217://192.168.1.20:4001", "text"),
    ],
)
def test_a_device_or_an_address_that_fits_the_frames_is_a_port(port: str, frame: str) -> None:
    assert faults(port, frame) == []


@pytest.mark.parametrize(
    ("port", "frame", "expected"),
    [
        ("192.168.1.20:502", "modbus", TCP.format("192.168.1.20:502")),
        ("192.168.1.20", "modbus", TCP.format("192.168.1.20:502")),
        ("http://192.168.1.20:8502/api", "modbus", TCP.format("192.168.1.20:8502")),
        ("socket://gateway:4001", "modbus", GATEWAY.format("gateway:4001")),
        ("rfc2217://gateway:4001", "modbus", GATEWAY.format("gateway:4001")),
        ("rtu+tcp://gateway", "modbus", GATEWAY.format("gateway:PORT")),
        ("TCP://plc:502", "modbus", TCP.format("plc:502")),
        ("tcp://plc:0", "modbus", TCP.format("plc:502")),
        ("tcp://plc:70000", "modbus", TCP.format("plc:502")),
        ("tcp://plc:502/1", "modbus", TCP.format("plc:502")),
        ("tcp://", "modbus", TCP.format("HOST:502")),
        ("modbus://plc", "modbus", TCP.format("plc:502")),
        ("tcp://scale:4001", "text", "socket://scale:4001"),
        ("scale.local", "text", "socket://scale.local:PORT"),
        ("scale:4001", "text", "socket://scale:4001"),
        ("rfc2217://scale:4001?logging=debug", "text", "socket://scale:4001"),
    ],
)
def test_anything_else_that_looks_like_an_address_is_refused_with_the_right_form(
    port: str, frame: str, expected: str
) -> None:
    (fault,) = faults(port, frame)
    assert "'port' is no address that this link can use" in fault
    assert expected in fault


@pytest.mark.parametrize(
    ("port", "fieldbus"),
    [
        ("ethercat://eth0", "EtherCAT"),
        ("profinet:10.0.0.1", "PROFINET"),
        ("enip://10.0.0.2", "EtherNet/IP"),
        ("can0", "CAN"),
        ("/dev/can1", "CAN"),
        ("socketcan:can0", "CAN"),
        ("opc.tcp://plc:4840", "OPC UA"),
    ],
)
@pytest.mark.parametrize("frame", ["text", "modbus"])
def test_a_fieldbus_that_is_not_supported_is_named(port: str, fieldbus: str, frame: str) -> None:
    (fault,) = faults(port, frame)
    assert f"{fieldbus} is not supported" in fault
    assert "use a gateway or an I/O station with Modbus TCP" in fault


@pytest.mark.parametrize("key", ["baudrate: 9600", "parity: E", "stopbits: 2"])
def test_settings_of_a_serial_line_are_only_for_a_port_that_sets_one(key: str) -> None:
    assert faults("rfc2217://plc:4001", "text", f", {key}") == []
    for port, frame in (
        ("socket://plc:4001", "text"),
        ("tcp://plc", "modbus"),
        ("rtu+tcp://plc:1", "modbus"),
    ):
        (fault,) = faults(port, frame, f", {key}")
        assert f"'{key.partition(':')[0]}' is for a serial line" in fault


@pytest.mark.parametrize("second", ["tcp://plc", "rtu+tcp://PLC:502"])
def test_two_links_cannot_have_one_address(second: str) -> None:
    text = f"""
name: tool
links:
  one: {{port: "tcp://plc:502", frame: {{modbus: {{}}}}}}
  two: {{port: "{second}", frame: {{modbus: {{}}}}}}
channels:
  cup: {{link: one, modbus: {{address: 1}}, unit: kPa}}
  rod: {{link: two, modbus: {{address: 1}}, unit: kPa}}
sequence: [a, b]
actuators: {{a: {{kind: vacuum, line: A, channel: cup}}, b: {{kind: vacuum, line: B, channel: rod}}}}
supply: {{channel: none}}
"""
    (fault,) = examine_text(text, "tool.yaml").lines()
    assert "this port already belongs to link 'one'" in fault


UNITS = """
name: tool
link: {{port: "{port}", frame: {{modbus: {{}}}}}}
channels:
  cup: {{modbus: {{unit: {unit}, address: 1}}, unit: kPa}}
  told: {{modbus: {{unit: {unit}, address: 0, register_type: coil}}}}
sequence: [a]
actuators:
  a:
    kind: vacuum
    channel: cup
    modbus: {{unit: {unit}, address: 0, register_type: coil, command_on: [1], command_off: [0], verify: told}}
supply: {{channel: none}}
"""


@pytest.mark.parametrize("unit", [1, 248, 255])
def test_units_over_247_are_units_like_others(unit: int) -> None:
    for port in ("/dev/ttyUSB0", "tcp://plc", "rtu+tcp://plc:4001"):
        assert list(examine_text(UNITS.format(port=port, unit=unit), "tool.yaml").lines()) == []


def test_unit_0_is_a_device_over_modbus_tcp_and_the_broadcast_of_a_line() -> None:
    assert list(examine_text(UNITS.format(port="tcp://plc", unit=0), "tool.yaml").lines()) == []
    for port in ("/dev/ttyUSB0", "rtu+tcp://plc:4001"):
        found = list(examine_text(UNITS.format(port=port, unit=0), "tool.yaml").lines())
        assert len(found) == 3
        assert all("unit 0 is the broadcast of a serial line" in each for each in found), found


def test_an_address_has_a_place_that_is_the_same_in_every_form() -> None:
    assert network_address("tcp://PLC") == NetworkAddress("tcp", "PLC", 502)
    found = [network_address(text) for text in ("tcp://PLC", "rtu+tcp://plc:502", "socket://plc:502")]
    assert {each.place for each in found if each} == {"plc:502"}
    six = network_address("tcp://[::1]:1502")
    assert (six.host, six.place, str(six)) == ("::1", "[::1]:1502", "tcp://[::1]:1502")
    assert network_address("/dev/ttyUSB0") is None


def test_a_virtual_copy_has_an_address_of_this_machine_of_its_own() -> None:
    text = TOOL.format(port="tcp://plc", frame="modbus", channel=CHANNEL["modbus"], more="")
    tool = examine_text(text, "tool.yaml").description
    ports = {tool.with_virtual("/x/chip", f"/x/{number}/uart").links[""].port for number in range(200)}
    assert len(ports) == 200
    for port in ports:
        address = network_address(port)
        assert address.scheme == "tcp"
        assert address.host.startswith("127.")
