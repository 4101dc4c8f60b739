"""The master of a commanded bus in virtual time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import cast

from end_effector_hal.codecs import codec_of, line_of
from end_effector_hal.codecs.modbus import BusCodec, ModbusMaster, RelayedBus, cycle_record
from end_effector_hal.description import Description, has_line, network_address
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import to_us
from end_effector_hal.wires.bus import BusOutputs, BusTraffic, fresh_for_us
from end_effector_lab.testbench import SensorBoard

ADOPT_US, FLUSH_US = 1_000_000, 1_000_000
"""Longest wait of a start for the devices' reports, and of an end for pending writes, µs."""
FIRST_WAIT_US, LONGEST_WAIT_US, TICK_US = 100_000, 2_000_000, 100_000
"""Waits before a lost connection is made again, and longest time between two looks at the outputs meanwhile, µs."""
TURN_US = 100
"""Time that the master needs for one action, µs; it does one at a time."""
NEVER = 2**62


class VirtualBus:
    """A `LineBackend` and `RemoteLines` of registers for one life of the arbiter, as `BusLines` on a real port.

    Args:
        description: the description of the tool.
        name: name of the link.
        devices: all units of the bus.
        clock: returns the time, µs.
    """

    def __init__(
        self, description: Description, name: str, devices: SensorBoard, clock: Callable[[], int]
    ) -> None:
        outputs, link = description.buses[name], description.links[name]
        self._codec = codec = cast(BusCodec, codec_of(description, name))
        self._names, self._devices, self._clock = frozenset(outputs), devices, clock
        self._longest_pulse_us = max(to_us(each.pulse_s or 0) for each in outputs.values())
        self._outputs = BusOutputs(outputs, fresh_for_us(codec.period_us), description.release_us)
        address = network_address(link.port)
        self._numbers_requests = address is not None and address.scheme == "tcp"
        self._connect()
        self._reopens_at: int | None = None
        self._looks_at, self._wait_us = NEVER, FIRST_WAIT_US
        self._relayed = RelayedBus(codec, outputs).decoder()
        self._byte_us = 10 * 1_000_000 // line_of(link, codec)[0] if has_line(link.port) else 0
        self._busy_until = clock()
        self._adopts_until = clock() + ADOPT_US
        self._ends_at = NEVER
        self._told: tuple[frozenset[str], Mapping[str, str]] = self._names, {}

    # What happens

    @property
    def due(self) -> int:
        """Time at which `frames` must be called, µs."""
        if self._reopens_at is not None:
            return min(self._reopens_at, self._looks_at, self._ends_at)
        coming = min((at for at, _ in self._coming), default=NEVER)
        return min(coming, max(self._traffic.due, self._busy_until), self._ends_at)

    def frames(self, at: int) -> list[Frame]:
        """Return the frames for the program from the cycles that have ended by ``at`` µs."""
        if self._reopens_at is not None and not self._reopen(self._reopens_at, at):
            return []
        if self._devices.closed(at):
            self._lose(at)
            return []
        self._coming.sort()
        cycles = []
        while self._coming and self._coming[0][0] <= at:
            cycles.append(self._traffic.feed(self._coming.pop(0)[1], at))
            self._wait_us = FIRST_WAIT_US
        request, cycle = self._traffic.poll(at)
        cycles.append(cycle)
        self._busy_until = at + TURN_US
        if request:
            if self._numbers_requests:  # an answer to an earlier one is none
                self._coming.clear()
            sent = self._devices.answer(request, at)
            if sent is not None and sent.reset:
                self._lose(at)
            elif sent is not None and sent.data:
                wire_us = (len(request) + len(sent.data)) * self._byte_us
                self._coming.append((at + wire_us + sent.late_us, sent.data))
        records = [cycle_record(each.answers, each.at, each.inactive) for each in cycles if each is not None]
        return [frame for record in records for frame in self._relayed.feed(record, at)]

    def _connect(self) -> None:
        master = self._codec.decoder()
        assert isinstance(master, ModbusMaster)
        self._traffic = BusTraffic(master, self._outputs)
        self._coming: list[tuple[int, bytes]] = []

    def _lose(self, at: int) -> None:
        """Lose the connection; it is made again after a wait, as on a real port."""
        self._connect()
        self._reopens_at, self._looks_at = at + self._wait_us, at + TICK_US
        self._wait_us = min(2 * self._wait_us, LONGEST_WAIT_US)

    def _reopen(self, due: int, at: int) -> bool:
        """Return whether there is a connection again; meanwhile commands are given up whose time is over."""
        self._outputs.advance(at)
        if at < due:
            self._looks_at = at + TICK_US
            return False
        if self._devices.closed(at):
            self._lose(at)
            return False
        self._reopens_at = None
        self._outputs.reopened(at)
        return True

    @property
    def adopted(self) -> bool:
        """Whether a start has all it waits for, or has waited long enough."""
        return not self.unsure() or self._clock() >= self._adopts_until

    @property
    def news(self) -> bool:
        """Whether `unsure` or `troubles` have changed since the last query."""
        before, self._told = self._told, (self.unsure(), self.troubles())
        return before != self._told

    def end(self) -> None:
        """Begin the proper end of the arbiter: pending writes get some time."""
        self._ends_at = self._clock() + FLUSH_US + self._longest_pulse_us

    @property
    def over(self) -> bool:
        """Whether the port has been released after `end`."""
        return self._ends_at != NEVER and (not self._outputs.pending or self._clock() >= self._ends_at)

    # For the arbiter

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """See `LineBackend`."""
        return {name: level for name, level in self.levels().items() if name in names}

    def levels(self) -> dict[str, bool]:
        """See `LineBackend`."""
        return self._outputs.known(self._clock())

    def set(self, levels: Mapping[str, bool]) -> None:
        """See `LineBackend`."""
        self._outputs.command(levels, self._clock())

    def close(self) -> None:
        """Do nothing; the registers keep their values."""

    def unsure(self) -> frozenset[str]:
        """See `RemoteLines`."""
        return self._names.difference(self.levels())

    def owed(self) -> frozenset[str]:
        """See `RemoteLines`."""
        return self._outputs.owed

    def activating(self) -> frozenset[str]:
        """See `RemoteLines`."""
        return self._outputs.activating(self._clock())

    def withdraw(self, lines: Iterable[str], why: str) -> None:
        """See `RemoteLines`."""
        self._outputs.withdraw(lines, why)

    def prepare(
        self, lines: Iterable[str], values: Mapping[str, tuple[int, ...]], given: Mapping[str, int]
    ) -> None:
        """See `RemoteLines`."""
        self._outputs.prepare(lines, values, given)

    def acknowledge(self) -> None:
        """See `RemoteLines`."""
        self._outputs.acknowledge(self._clock())

    def troubles(self) -> dict[str, str]:
        """See `RemoteLines`."""
        return self._outputs.troubles(self._clock())

    def filenos(self) -> tuple[int, ...]:
        """Return an empty tuple: `news` is used instead."""
        return ()

    def heard(self) -> None:
        """See `RemoteLines`."""
