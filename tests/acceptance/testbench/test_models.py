"""Simulated devices, commanded by a driver that others wrote and by the whole product, over a pseudo-terminal."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pyrobotiqgripper
import pytest
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.exceptions import ModbusIOException

from end_effector_hal.codecs import load_tool
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import now_us
from end_effector_lab.demo._world import World
from end_effector_lab.testbench import Testbench, chosen_models, open_inputs, open_ports, write_virtual_copy
from end_effector_lab.testbench._ports import PtyPort
from end_effector_lab.testbench.devices import FrameReader, model_for
from end_effector_lab.testbench.physics import Device, Fingers, VacuumCircuit, Valve
from tests.support.patience import wait_until
from tests.support.places import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
GRIPPER = ROOT / "examples/tools/gripper_2f85/end_effector.yaml"
MODEL = "9=robotiq-2f85"


@contextmanager
def simulated(folder: Path, port: str | None = None) -> Iterator[tuple[Testbench, str]]:
    """A testbench in this process, and the port of its bus."""
    tool = load_tool(write_virtual_copy(load_tool(GRIPPER), folder))
    inputs, ports = open_inputs(None, tool), open_ports(port, tool, None)
    with Testbench(tool, inputs, ports, models=chosen_models(MODEL, tool)) as bench:
        yield bench, tool.link.port


def test_a_driver_that_others_wrote_activates_moves_grips_and_reads_it(tmp_path: Path) -> None:
    with simulated(tmp_path) as (bench, port):
        gripper = pyrobotiqgripper.RobotiqGripper(com_port=port)
        try:
            with pytest.raises(pyrobotiqgripper.GripperNotActivatedError):
                gripper.move(100)
            gripper.activate()
            assert gripper.isActivated()
            assert gripper.position() == 3
            gripper.move(100)  # the driver returns when it estimates that the motion is over
            wait_until("the place", lambda: (gripper.position(), gripper.objectDetection()) == (100, 3))
            gripper.close()
            wait_until("the part", lambda: (gripper.position(), gripper.objectDetection()) == (139, 2))
            bench.choose("no-part:fingers")
            wait_until("the fingers go on", lambda: gripper.objectDetection() == 3)
            wait_until("the end of the stroke", lambda: gripper.position() == 230)
            gripper.open()
            wait_until("open", lambda: (gripper.position(), gripper.objectDetection()) == (3, 3))
            gripper.reset()
            assert not gripper.isActivated()
        finally:
            gripper.disconnect()


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def test_the_same_driver_over_a_gateway_and_another_client_over_tcp(tmp_path: Path) -> None:
    number = free_port()
    with simulated(tmp_path / "gateway", f"rtu+tcp://127.0.0.1:{number}"):
        gripper = pyrobotiqgripper.RobotiqGripper(
            connection_type=pyrobotiqgripper.GRIPPER_MODE_RTU_VIA_TCP, tcp_port=number
        )
        try:
            gripper.activate()
            gripper.close()
            wait_until("the part", lambda: (gripper.position(), gripper.objectDetection()) == (139, 2))
        finally:
            gripper.disconnect()
    number = free_port()
    with simulated(tmp_path / "tcp", f"tcp://127.0.0.1:{number}"):
        master = ModbusTcpClient("127.0.0.1", port=number, timeout=5)
        assert master.connect()
        try:
            assert not master.write_registers(0x03E8, [0x0100], device_id=9).isError()
            wait_until(
                "the activation",
                lambda: master.read_input_registers(0x07D0, count=1, device_id=9).registers == [0x3100],
            )
            assert master.read_coils(0, count=1, device_id=9).exception_code == 1
        finally:
            master.close()


class Line:
    """One modelled unit at the far end of a pty, without any description."""

    def __init__(self, port: Path, unit: int, name: str, devices: dict[int, Device]) -> None:
        self._port, self._unit, self._devices = PtyPort(str(port)), unit, devices
        model = model_for(name)
        assert model is not None
        self._model = model(devices, self._tell)
        self._frames, self._ended = FrameReader(115_200), threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> Line:
        self._port.open()
        self._model.power_up(now_us())
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        self._port.close()

    def _tell(self, channel: int, level: bool) -> None:
        if channel in self._devices:
            self._devices[channel].command(level, now_us())

    def _serve(self) -> None:
        while not self._ended.is_set():
            data, at = self._port.receive(0.05), now_us()
            for device in self._devices.values():
                device.advance(at)
            for frame in self._frames.feed(data, at):
                if frame[0] in (0, self._unit) and (answer := self._model.answer(frame[0], frame[1:-2], at)):
                    self._port.send(answer)


@contextmanager
def client(port: Path, timeout_s: float = 5.0) -> Iterator[ModbusSerialClient]:
    """pymodbus's client, which shares no code with the models."""
    made = ModbusSerialClient(port=str(port), baudrate=115_200, timeout=timeout_s, retries=0)
    assert made.connect()
    try:
        yield made
    finally:
        made.close()


@pytest.mark.parametrize(
    ("unit", "name", "device", "register", "status"),
    [
        (9, "robotiq-2f85", Fingers, 0x03E8, 0x07D0),
        (9, "robotiq-2f140", Fingers, 0x03E8, 0x07D0),
        (9, "robotiq-hand-e", Fingers, 0x03E8, 0x07D0),
        (9, "robotiq-epick", VacuumCircuit, 0x03E8, 0x07D0),
        (65, "onrobot-vg10", VacuumCircuit, 0, 18),
        (1, "remote-io", Fingers, 0, 0),
    ],
)
def test_another_client_reads_every_model(
    tmp_path: Path, unit: int, name: str, device: type[Device], register: int, status: int
) -> None:
    port = tmp_path / "uart"
    physics = device(Valve(0), start=now_us())
    with Line(port, unit, name, {0: physics}), client(port) as master:
        read = master.read_holding_registers(status, count=2, device_id=unit)
        assert len(read.registers) == 2
        assert not master.write_registers(register, [0x0100], device_id=unit).isError()
        assert not master.write_register(register, 0x0100, device_id=unit).isError()
        assert master.read_holding_registers(0x9000, count=1, device_id=unit).exception_code == 2
        if name == "remote-io":
            assert not master.write_coils(0, [True, False, True], device_id=unit).isError()
            assert master.read_coils(0, count=3, device_id=unit).bits[:3] == [True, False, True]
            assert master.mask_write_register(address=0, and_mask=0, or_mask=7, device_id=unit).or_mask == 7
            both = master.readwrite_registers(
                read_address=0, read_count=2, write_address=1, values=[5], device_id=unit
            )
            assert both.registers == [7, 5]
        else:
            assert master.read_coils(0, count=1, device_id=unit).exception_code == 1


def test_a_client_that_asks_another_unit_gets_no_answer(tmp_path: Path) -> None:
    port = tmp_path / "uart"
    with Line(port, 9, "robotiq-2f85", {0: Fingers(start=now_us())}), client(port, 0.2) as master:
        with pytest.raises(ModbusIOException):
            master.read_holding_registers(0x07D0, count=1, device_id=8)
        assert master.read_holding_registers(0x07D0, count=1, device_id=9).registers == [0]


@pytest.mark.thinned
def test_the_product_grips_loses_and_drops_with_it(tmp_path: Path) -> None:
    with World(load_tool(GRIPPER), "nominal", tmp_path, models=MODEL) as world:
        assert f"unit 9 plays the model of {MODEL[2:]}" in world.testbench.text()
        with EndEffector.open(world.description) as tool:
            tool.wait_ready(30)
            assert tool.grip().succeeded
            world.choose("lost-after:fingers:0.1")
            wait_until("the loss", lambda: tool.status.ee == EndEffectorState.GRIP_ERROR)
            world.choose("nominal")
            assert tool.drop().succeeded
            assert tool.grip().succeeded
            world.choose("reboot-after:0")
            wait_until(
                "it is not activated", lambda: "not activated any more" in " ".join(tool.status.alarm_texts)
            )
            assert tool.drop().succeeded
