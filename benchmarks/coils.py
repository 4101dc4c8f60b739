"""A coil over Modbus TCP: the line arbiter's bus beside pymodbus alone, in turns, on the same server.

``python benchmarks/coils.py [--blocks N]``. The server is one of pymodbus in a process of its own, with 1, 8 and 32
units that are read every 20 ms.

- Command: from the call that releases the coil to its acknowledgement. An activation is left out: the bus delays it on
  purpose as much as the release before it was late.
- Reaction: from the answer that shows a changed input to the write that releases the coil, both as the server sees
  them. Both ways decide after the whole cycle; with the bus it passes the relay to a reader.

The automata are not part of it: `benchmarks/run.py` measures those.
"""

from __future__ import annotations

import argparse
import asyncio
import select
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any, cast

from pymodbus.client import ModbusTcpClient
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from end_effector_hal.codecs import codec_of, line_of
from end_effector_hal.codecs.modbus import BusCodec, RelayedBus
from end_effector_hal.description import Description, examine_text, network_address
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.signals import Frame
from end_effector_hal.wires._relay import connect_relay
from end_effector_hal.wires.bus import BusLines, BusLink
from end_effector_hal.wires.link._reader import LinkReader

UNITS, PERIOD_S = (1, 8, 32), 0.02
COMMANDS, REACTIONS = 100, 60
TOOL = Path(__file__).parent.parent / "examples/tools/remote_io/end_effector.yaml"
COIL, INPUT, WATCH, WRITES = 0, 1, 2, (5, 15)


class Watch:
    """Prints how long the write of the coil of unit 1 came after the first answer with another input, µs.

    Coil 1 sets the input.
    """

    def __init__(self) -> None:
        self._input = self._shown = False
        self._since = 0

    def __call__(self, sending: bool, pdu: Any) -> Any:
        now, ours = time.perf_counter_ns(), pdu.dev_id == 1
        if ours and not sending and pdu.function_code in WRITES:
            if pdu.address == INPUT:
                self._input = bool(pdu.bits[0])
            elif self._since:
                sys.stdout.write(f"{(now - self._since) / 1000}\n")
                sys.stdout.flush()
                self._since = 0
        if ours and sending and pdu.function_code == WATCH:
            pdu.bits = [self._input, *pdu.bits[1:]]
            if self._input is not self._shown:
                self._shown, self._since = self._input, now
        return pdu


def device(unit: int) -> SimDevice:
    """Return a unit with 16 values in each table."""
    bits = [[SimData(0, count=16, values=False, datatype=DataType.BITS)] for _ in range(2)]
    words = [[SimData(0, count=16, values=0, datatype=DataType.REGISTERS)] for _ in range(2)]
    return SimDevice(unit, simdata=(*bits, *words))


async def serve(units: int) -> None:
    """Serve until the process is killed; print the port first."""
    devices = [device(unit + 1) for unit in range(units)]
    server = ModbusTcpServer(devices, address=("127.0.0.1", 0), trace_pdu=Watch())
    await server.listen()
    sys.stdout.write(f"{server.transport.sockets[0].getsockname()[1]}\n")
    sys.stdout.flush()
    await asyncio.Event().wait()


class Server:
    """The server in a process of its own, and the reactions that it saw."""

    def __init__(self, units: int) -> None:
        words = [sys.executable, __file__, "--serve", str(units)]
        self._process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout is not None
        self.port = int(self._process.stdout.readline())

    def change_input(self, other: ModbusTcpClient, *, level: bool) -> float:
        """Change the input of unit 1; return the reaction, µs."""
        other.write_coil(INPUT, value=level, device_id=1)
        assert self._process.stdout is not None
        return float(self._process.stdout.readline())

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait()


def tool_at(port: int, units: int) -> Description:
    """Return the example with one more channel for each further unit."""
    more = "".join(
        f"  in_{unit}: {{modbus: {{unit: {unit + 1}, address: 0, register_type: discrete_input}}}}\n"
        for unit in range(1, units)
    )
    text = TOOL.read_text().replace("tcp://192.168.1.20 ", f"tcp://127.0.0.1:{port} ")
    found = examine_text(text.replace("\nsequence:", f"{more}\nsequence:"), "bench.yaml")
    assert found.description is not None, found.lines()
    return found.description


@contextmanager
def bus(tool: Description, units: int) -> Iterator[Callable[[bool], None]]:
    """The bus of the line arbiter, with a reader of its relay that answers each change of the input with the coil.

    Yields a function that commands the coil and returns when that is acknowledged.
    """
    codec = cast(BusCodec, codec_of(tool))
    outputs = {
        f"coil {unit}": RegisterOutput(
            unit=unit + 1, address=COIL, register_type="coil", command_on=(1,), command_off=(0,)
        )
        for unit in range(units)
    }
    with tempfile.TemporaryDirectory() as folder:
        relay = Path(folder) / "relay"
        link = BusLink(tool.links[""].port, codec, *line_of(tool.links[""], codec))
        lines = BusLines(link, outputs, relay)
        lines.request([*outputs])
        shown = False

        def on_frame(frame: Frame) -> None:
            nonlocal shown
            level = frame.values["down"]
            if level is not None and level is not shown:
                shown = bool(level)
                lines.set({"coil 0": shown})

        def command(level: bool) -> None:
            lines.set({"coil 0": level})
            while lines.levels().get("coil 0") is not level:
                select.select(lines.filenos(), [], [], 1.0)
                lines.heard()

        reader = LinkReader(
            link.port, RelayedBus(codec), 0, on_frame, lambda *_: None, connect=partial(connect_relay, relay)
        )
        reader.start()
        try:
            yield command
        finally:
            reader.close()
            lines.close()


@contextmanager
def alone(tool: Description, units: int) -> Iterator[Callable[[bool], None]]:
    """pymodbus's client: a thread reads the same every 20 ms, and answers each change of the input with the coil.

    Yields a function that commands the coil and returns when that is acknowledged.
    """
    del units
    address = network_address(tool.links[""].port)
    assert address is not None
    reads, ended, lock = cast(BusCodec, codec_of(tool)).reads, threading.Event(), threading.Lock()
    client = ModbusTcpClient(address.host, port=address.port)
    client.connect()
    ask = {1: client.read_coils, 2: client.read_discrete_inputs, 4: client.read_input_registers}

    def command(level: bool) -> None:
        with lock:
            assert not client.write_coil(COIL, value=level, device_id=1).isError()

    def read() -> None:
        shown, due = False, time.monotonic()
        while not ended.wait(max(0.0, due - time.monotonic())):
            due = max(due + PERIOD_S, time.monotonic())
            level = shown
            for each in reads:
                with lock:
                    found = ask[each.function](each.address, count=each.count, device_id=each.unit)
                if (each.unit, each.function) == (1, WATCH):
                    level = found.bits[0]
            if level is not shown:
                shown = level
                command(shown)

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    try:
        yield command
    finally:
        ended.set()
        thread.join()
        client.close()


def measured(units: int, way: Callable[[Description, int], Any]) -> tuple[list[float], list[float]]:
    """Return the commands and the reactions of one block, µs."""
    commands, reactions = [], []
    with (
        closing(Server(units)) as server,
        ModbusTcpClient("127.0.0.1", port=server.port) as other,
        way(tool_at(server.port, units), units) as command,
    ):
        time.sleep(0.5)
        for number in range(2 * COMMANDS):
            time.sleep(0.013)  # at any time of the cycle
            begun, active = time.perf_counter_ns(), number % 2 == 0
            command(active)
            if not active:
                commands.append((time.perf_counter_ns() - begun) / 1000)
        for number in range(2 * REACTIONS):
            time.sleep(0.05)
            active = number % 2 == 0
            reaction = server.change_input(other, level=active)
            reactions += [] if active else [reaction]
    return commands, reactions


def main(blocks: int) -> None:
    """Print the medians of both ways and their ratio."""
    for units in UNITS:
        found: dict[str, tuple[list[float], list[float]]] = {"bus": ([], []), "alone": ([], [])}
        for _ in range(blocks):
            for name, way in (("bus", bus), ("alone", alone)):
                for kept, new in zip(found[name], measured(units, way), strict=True):
                    kept += new
        for number, what in enumerate(("command", "reaction")):
            ours, theirs = (statistics.median(found[name][number]) for name in ("bus", "alone"))
            sys.stdout.write(
                f"{units:2} units, {what:8}: {ours:6.0f} µs; pymodbus alone {theirs:6.0f} µs; {ours / theirs:.2f}\n"
            )
            sys.stdout.flush()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=int, default=3, help="blocks of each way, in turns")
    parser.add_argument("--serve", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.serve:
        asyncio.run(serve(arguments.serve))
    else:
        main(arguments.blocks)
