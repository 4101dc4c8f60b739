"""Device registers as output lines: one thread is the master of the bus, for reads and writes."""

from __future__ import annotations

import logging
import os
import select
import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing, suppress
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from end_effector_hal.codecs.modbus import BusCodec, ModbusMaster, cycle_record
from end_effector_hal.description import Description
from end_effector_hal.errors import LinkBusyError, WireError
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires._relay import RELAYED, relay_path
from end_effector_hal.wires.bus._output import fresh_for_us
from end_effector_hal.wires.bus._outputs import BusOutputs
from end_effector_hal.wires.bus._traffic import BusTraffic
from end_effector_hal.wires.link import WirePort, open_wire
from end_effector_hal.wires.rpc import Server

_log = logging.getLogger("end_effector_hal.wires")
FIRST_WAIT_S, LONGEST_WAIT_S = 0.1, 2.0
ADOPT_S = 1.0
"""Longest wait at the start for the devices to report their outputs, s."""
PATIENCE_S = 1.0
"""Longest wait for another process to release the port, s: a predecessor may be ending."""
FLUSH_S = 1.0
"""Longest wait at the end for pending writes, s."""
CLOSE_S = 2.0
TICK_S = 0.1


class BusLink(NamedTuple):
    """The link of a bus: its port (a device, or an address in a network), its codec and the settings of the port."""

    port: str
    codec: BusCodec
    baudrate: int
    parity: str
    stopbits: int = 1


def bus_relay(description: Description, socket: Path, name: str) -> Path:
    """Return the path of the relay on which the line arbiter at ``socket`` sends the readings of a bus; ``name``: of
    its link.
    """
    return relay_path(socket, f"bus.{name}" if len(description.buses) > 1 else "bus")


class BusLines:
    """A `LineBackend` and `RemoteLines` of registers: setting a line does not wait for the device.

    A write ends with the device's acknowledgement; until then the state of the output is unknown. A deactivation is
    repeated until the device acknowledges it. An activation is given up after a time, so that nothing moves
    unexpectedly when a bus recovers. Nothing is written at the start.

    Args:
        link: the bus.
        outputs: the outputs by name.
        relay: path of the socket that relays each cycle.
        group: the group whose members may read there; default: the group of the process.
        release_us: how long the release of an output takes, µs, by its name.
    """

    def __init__(
        self,
        link: BusLink,
        outputs: Mapping[str, RegisterOutput],
        relay: Path,
        group: str | None = None,
        release_us: Mapping[str, int] = MappingProxyType({}),
    ) -> None:
        self._link, self._relay_path, self._group = link, relay, group
        self._outputs = BusOutputs(outputs, fresh_for_us(link.codec.period_us), release_us)
        self._names = frozenset(outputs)
        self._longest_pulse_s = max(each.pulse_s or 0.0 for each in outputs.values())
        self._lock = threading.Lock()
        self._cycle = threading.Event()
        self._ended = False
        self._error = self._logged = ""
        self._wait_s = FIRST_WAIT_S
        self._thread: threading.Thread | None = None
        self._told: tuple[frozenset[str], Mapping[str, str]] = frozenset(), {}

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """Open the port and adopt the reported states; see `LineBackend.request`. Nothing is written at the start.

        Raises:
            LinkBusyError: another process has the port; the message names it.
            WireError: the relay cannot be created.
        """
        del names  # all of them
        port = self._claimed()
        try:
            self._relay = Server(self._relay_path, RELAYED, self._group)
        except BaseException:
            if port is not None:
                port.close()
            raise
        self._news_read, self._news = os.pipe()
        for end in (self._news_read, self._news):
            os.set_blocking(end, False)
        self._thread = threading.Thread(
            target=self._run, args=(port,), name=f"bus {self._link.port}", daemon=True
        )
        self._thread.start()
        until = time.monotonic() + ADOPT_S
        while self._names - self.levels().keys() and (left := until - time.monotonic()) > 0:
            self._cycle.wait(left)
            self._cycle.clear()
        return self.levels()

    def levels(self) -> dict[str, bool]:
        """Return the known levels: commanded and acknowledged, or reported by a device."""
        with self._lock:
            return self._outputs.known(now_us())

    def set(self, levels: Mapping[str, bool]) -> None:
        """Request that these levels be written; returns at once."""
        with self._lock:
            self._outputs.command(levels, now_us())
        self._relay.wake()

    def unsure(self) -> frozenset[str]:
        """See `RemoteLines`."""
        return self._names.difference(self.levels())

    def owed(self) -> frozenset[str]:
        """See `RemoteLines`."""
        with self._lock:
            return self._outputs.owed

    def activating(self) -> frozenset[str]:
        """See `RemoteLines`."""
        with self._lock:
            return self._outputs.activating(now_us())

    def withdraw(self, lines: Iterable[str], why: str) -> None:
        """See `RemoteLines`."""
        with self._lock:
            self._outputs.withdraw(lines, why)

    def prepare(
        self, lines: Iterable[str], values: Mapping[str, tuple[int, ...]], given: Mapping[str, int]
    ) -> None:
        """See `RemoteLines`."""
        with self._lock:
            self._outputs.prepare(lines, values, given)

    def acknowledge(self) -> None:
        """See `RemoteLines`."""
        with self._lock:
            self._outputs.acknowledge(now_us())
        self._relay.wake()

    def troubles(self) -> dict[str, str]:
        """See `RemoteLines`."""
        with self._lock:
            found = self._outputs.troubles(now_us())
            unknown = self._outputs.unknown(now_us()) if self._error else frozenset[str]()
        found = dict.fromkeys(unknown, "is not known: its bus cannot be read") | found
        return {line: f"{why}{f' ({self._error})' if self._error else ''}" for line, why in found.items()}

    def filenos(self) -> tuple[int, ...]:
        """See `RemoteLines`."""
        return (self._news_read,)

    def heard(self) -> None:
        """See `RemoteLines`."""
        with suppress(BlockingIOError):
            os.read(self._news_read, 4096)

    def close(self) -> None:
        """Close the port after a short wait for pending writes; the registers keep their values."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        until = time.monotonic() + FLUSH_S + self._longest_pulse_s
        while self._pending and (left := until - time.monotonic()) > 0:
            self._cycle.wait(min(left, 0.05))
            self._cycle.clear()
        self._ended = True
        self._relay.wake()
        if thread.ident is not None:
            thread.join(CLOSE_S)
        self._relay.close()
        for end in (self._news, self._news_read):
            os.close(end)

    @property
    def _pending(self) -> bool:
        with self._lock:
            return self._outputs.pending

    def _claimed(self) -> WirePort | None:
        """Return the port; None: no port can be opened yet."""
        until = time.monotonic() + PATIENCE_S
        while True:
            try:
                return self._open()
            except LinkBusyError:
                if time.monotonic() >= until:
                    raise
            except WireError as error:
                self._error = str(error)
                return None
            time.sleep(FIRST_WAIT_S)

    def _open(self) -> WirePort:
        return open_wire(
            self._link.port, self._link.baudrate, parity=self._link.parity, stopbits=self._link.stopbits
        )

    def _run(self, port: WirePort | None) -> None:
        while not self._ended:
            try:
                with closing(port or self._open()) as opened:
                    port = None
                    while opened.connecting and not self._ended:
                        if self._wait(LONGEST_WAIT_S, opened):
                            opened.establish()
                    self._talk(opened)
            except Exception as error:  # noqa: BLE001 a driver may raise anything: this thread outlives it
                port, self._error = None, str(error) or type(error).__name__
                if self._error != self._logged:
                    _log.error("the bus %s is lost: %s", self._link.port, self._error)
                self._logged = self._error
                try:
                    self._wait(self._wait_s)
                except Exception:  # noqa: BLE001 its end would end every release
                    _log.exception("readers of the bus %s", self._link.port)
                    time.sleep(self._wait_s)
                self._wait_s = min(2 * self._wait_s, LONGEST_WAIT_S)

    def _wait(self, wait_s: float, port: WirePort | None = None) -> bool:
        """Wait until the port is readable; return whether it is. Meanwhile, give up commands whose time is over, and
        serve the readers of the relay.
        """
        until, fds = time.monotonic() + wait_s, [port.fileno()] if port else []
        while not self._ended and (left := until - time.monotonic()) > 0:
            ready = self._select(fds, min(left, TICK_S))
            with self._lock:
                self._outputs.advance(now_us())
            self._tell()
            if ready:
                return True
        return False

    def _talk(self, port: WirePort) -> None:
        """Exchange requests and answers until the end; raises OSError when the port is lost."""
        codec = self._link.codec
        master = codec.decoder()
        assert isinstance(master, ModbusMaster)
        traffic, fd = BusTraffic(master, self._outputs), port.fileno()
        with self._lock:
            self._outputs.reopened(now_us())
        while not self._ended:
            with self._lock:
                wait_us = traffic.due - now_us()
            ready = self._select([fd], max(0, wait_us) / 1e6)
            cycles = []
            if ready:
                data = port.read()
                self._wait_s, self._error, self._logged = FIRST_WAIT_S, "", ""
                with self._lock:
                    cycles.append(traffic.feed(data, now_us()))
            with self._lock:
                request, cycle = traffic.poll(now_us())
            cycles.append(cycle)
            if request:
                port.write(request)
            for each in cycles:
                if each is not None:
                    self._relay.send(cycle_record(each.answers, each.at, each.inactive))
                    self._cycle.set()
            self._tell()

    def _select(self, ports: list[int], wait_s: float) -> list[int]:
        """Wait for data; return the readable ports. The relay is served too, and `Server.wake` ends the wait."""
        relay = self._relay.fileno()
        ready = select.select([*ports, relay], [], [], wait_s)[0]
        if relay in ready:
            self._relay.poll()
        return [port for port in ports if port in ready]

    def _tell(self) -> None:
        """Notify the arbiter if `unsure` or `troubles` have changed."""
        now = self.unsure(), self.troubles()
        if now != self._told:
            self._told = now
            with suppress(BlockingIOError):
                os.write(self._news, b"x")
