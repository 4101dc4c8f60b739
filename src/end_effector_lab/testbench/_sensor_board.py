"""What samples the sensors, sans-IO: a board that sends frames of a codec, and sensors on inputs of the board."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from end_effector_hal.codecs import board_inputs, codec_of, is_polled
from end_effector_hal.description import Channel, Description, Inputs
from end_effector_hal.errors import WireError
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.signals import Frame, Kind, Value
from end_effector_hal.wires.inputs import find_device, input_lines, pulls_of
from end_effector_hal.wires.lines import VirtualPins

from ._bench import Bench
from ._modbus import CommandedRegisters
from ._units import ModelledUnits, Models
from .devices import RemoteIo, read_request


def carried(
    values: Mapping[str, Value], channels: Mapping[str, Kind], description: Description
) -> dict[str, Value]:
    """Return the values that the codec's channels can carry; a pressure on a bit channel becomes "present".

    Args:
        values: channel -> gauge Pa, bit, or None: invalid (of :meth:`Bench.sample`).
        channels: the channels of the codec.
        description: description whose thresholds the switches use.
    """
    seen = {name: values[name] for name in channels if name in values}
    for name, value in seen.items():
        if type(value) is int and channels[name] is Kind.BIT:
            seen[name] = abs(value) >= _present_pa(name, description)
    return seen


def _present_pa(channel: str, description: Description) -> float:
    """Return the pressure at which a switch on this channel closes, as a magnitude, Pa."""
    for actuator in description.actuators.values():
        if actuator.channel == channel:
            limits = kind_of(actuator).limits(actuator, description.supply)
            if "confirmed_kpa" in limits:
                return limits["confirmed_kpa"] * 1000
    return description.supply.refuse_kpa * 1000


class Sent(NamedTuple):
    """The output of the link at one time.

    Attributes:
        data: bytes, as they arrive; b"": the link is silent, or there was no request.
        seq: number of the frame or answer since the start of the device.
        values: readings of all sensors.
        clean: the bytes before any disturbance.
        late_us: delay of the bytes, µs.
        reset: whether the connection is reset in the middle of these bytes.
    """

    data: bytes
    seq: int
    values: Mapping[str, Value]
    clean: bytes
    late_us: int = 0
    reset: bool = False


class SensorBoard:
    """Sends the readings of a bench over one link, in the format of its codec.

    On a bus that is commanded it is all units; `begin` switches them on.

    Args:
        description: the tool; the codec of the link is streamed (call `frame`) or polled (call `answer`).
        bench: source of the readings, and of the faults of the link.
        start: time at which the device was switched on, µs.
        link: name of the link; empty: it is the only one.
        obey: called with the name and level of an output that was commanded.
        models: the units that have a model; the others are played from the description.
    """

    def __init__(
        self,
        description: Description,
        bench: Bench,
        start: int,
        link: str = "",
        obey: Callable[[str, bool], None] = lambda _, __: None,
        models: Models = MappingProxyType({}),
    ) -> None:
        self.codec = codec = codec_of(description, link)
        self._bench, self._description, self._link = bench, description, link or None
        self._booted, self._seq = start, 0
        self._device = codec.device() if is_polled(codec) else None
        self._other = RemoteIo({}, lambda channel, level: None)  # it has all tables, of 0
        self._foreign_write_at: int | None = None
        self._registers: CommandedRegisters | None = None
        self._units: ModelledUnits | None = None
        outputs, own = description.buses.get(link, {}), models.get(link, {})
        self._outputs = tuple(outputs.values())
        if outputs:
            parts = [each.buses[link] for each in description.per_part]
            self._registers = CommandedRegisters(
                {name: each for name, each in outputs.items() if each.unit not in own},
                obey,
                {name: [each[name].values(level=True) for each in parts] for name in outputs},
            )
        if own:
            self._units = ModelledUnits(description, link, own, bench, obey)

    def begin(self, levels: Mapping[str, bool], at: int) -> None:
        """Switch the commanded units on at ``at`` (µs), with the outputs that are active."""
        if self._registers:
            self._registers.start(dict(levels), at)
        if self._units:
            self._units.start(levels, at)

    def lose_power(self, at: int) -> None:
        """Cut the power of the commanded units, which returns at once."""
        if self._registers:
            self._registers.start({}, at)
        if self._units:
            self._units.power_up(at)

    @property
    def due(self) -> int | None:
        """Time at which `advance` must be called, µs; None: nothing happens without a request."""
        parts = [each.due for each in (self._registers, self._units) if each]
        parts += [self._next_foreign_write]
        return min([due for due in parts if due is not None], default=None)

    def frame(self, at: int) -> Sent:
        """Return the frame that is due at ``at`` (µs)."""
        sample, seq = self._bench.sample(at), self.count(at)
        age_ms = max(0, at - self._booted) // 1000
        return self._sent(self.codec.encode(Frame(0, seq, age_ms, self.carried(sample))), seq, sample, at)

    def advance(self, at: int) -> None:
        """Advance the outputs in time while there is no request; call it now and then."""
        if self._registers:
            self._registers.advance(at)
        if self._units:
            self._bench.sample(at)  # the physics comes first
            self._units.advance(at)
        due = self._next_foreign_write
        if due is not None and due <= at:
            self._foreign_write_at = due
            for output in self._outputs:
                self._release(output, at)

    @property
    def _next_foreign_write(self) -> int | None:
        """Time at which another client writes, µs; None: it does not, or has."""
        at = self._bench.foreign_write_at(self._link) if self._outputs else None
        return None if at == self._foreign_write_at else at

    def _release(self, output: RegisterOutput, at: int) -> None:
        """Make an output inactive, as another client does; it writes a bit without its neighbours."""
        from end_effector_hal.codecs.modbus import RegisterWrite, write_request  # with pymodbus

        coils, multiple = output.register_type == "coil", output.use_write_multiple
        for address, values in output.writes(level=False):
            mask = output.bitmask_at(address)
            request = write_request(RegisterWrite(output.unit, address, values, coils, multiple, mask))
            if self._units and self._units.owns(request):
                self._units.answer(request, self.carried(self._bench.sample(at)), at)
            elif self._registers:
                self._registers.hear(request, at)
                self._registers.answer(request)

    def answer(self, request: bytes, at: int) -> Sent | None:
        """Return the answer to the bytes of a request at ``at`` (µs), or None if there is none."""
        self.advance(at)
        sample = self._bench.sample(at)
        if self._outputs and self._bench.exchanged(at, self._link):
            asked = read_request(request) is not None
            answer = self._other.answer(request[0], request[1:-2], at) if asked else b""
            return self._answered(answer, sample, at)
        answers = b""
        if self._units and not self._bench.silent(at, self._link):
            answers = self._units.answer(request, self.carried(sample), at)
        if self._units and self._units.owns(request):
            return self._answered(answers, sample, at)
        if self._registers:
            if self._bench.silent(at):  # without power, or without a wire: it hears nothing
                return None
            self._registers.hear(request, at)
            if done := self._registers.answer(request):
                return self._answered(done, sample, at)
            sample |= self._registers.values
        answers += self._device.answer(request, self.carried(sample)) if self._device else b""
        return self._answered(answers, sample, at)

    def _answered(self, answers: bytes, sample: Mapping[str, Value], at: int) -> Sent | None:
        """Return what becomes of the answers; None: there are none."""
        if not answers:
            return None
        answers, late_us = self._bench.answered(answers, at, self._link)
        sent = self._sent(answers, self.count(at), sample, at)._replace(late_us=late_us)
        return sent._replace(reset=self._bench.cuts(at, self._link))

    def closed(self, at: int) -> bool:
        """Return whether the device refuses connections at ``at`` (µs), and has reset those it had."""
        return self._bench.closed(at, self._link)

    def count(self, at: int) -> int:
        """Return the number of the frame or answer at ``at`` (µs); every call counts."""
        if (booted := self._bench.booted(at, self._link)) != self._booted:
            self._booted, self._seq = booted, 0
        seq = self._seq
        if at >= booted:  # before that it does not work yet
            self._seq += 1
        return seq

    def _sent(self, clean: bytes, seq: int, sample: Mapping[str, Value], at: int) -> Sent:
        silent = self._bench.silent(at, self._link)
        data = b"" if silent else self._bench.corrupt(clean, at, self._link)
        return Sent(data, seq, sample, clean)

    def carried(self, sample: Mapping[str, Value]) -> dict[str, Value]:
        """Return the part of a sample that its codec carries."""
        return carried(sample, self.codec.channels, self._description)


SCALE_MV = 0.0625
"""Scale of an ADS1115 after power-up, mV per count."""
LONGEST_PERIOD_US = 5_000
"""Longest update period, µs; so short that edges of switches, which have no period of their own, come between two
readings.
"""


class BoardSensors:
    """Drives input lines and writes analog files, only for changed values.

    For an invalid sensor the line goes to its pull, and the file is removed; while all sensors are silent, lines keep
    their levels, and the files are removed.

    Args:
        chip: path of its virtual chip.
    """

    def __init__(self, description: Description, chip: str | Path) -> None:
        self._description = description
        self._channels = {name: each for name, each in description.channels.items() if each.on_board}
        self._kinds = {name: each.kind for name, each in self._channels.items()}
        self._pins = VirtualPins(chip)
        self._pulls = pulls_of(input_lines(description))
        self._iio = Path((description.inputs or Inputs()).iio)
        self._devices: dict[str, Path] = {}
        self._levels: dict[str, bool] = {}
        self._counts: dict[Path, int | None] = {}
        inputs = board_inputs(description)
        self.period_us = min(LONGEST_PERIOD_US, inputs.period_us if inputs else LONGEST_PERIOD_US)

    def start(self) -> None:
        """Create the missing devices; raises WireError if that fails."""
        for each in self._channels.values():
            if each.analog:
                try:
                    self._devices[each.analog.device] = device = self._device(each.analog.device)
                    (device / f"in_{each.analog.channel}_scale").write_text(f"{SCALE_MV}\n", encoding="ascii")
                except OSError as error:
                    where = str(error.filename or self._iio)
                    raise WireError(f"cannot be made: {error.strerror}.", where=where) from error

    def play(self, values: Mapping[str, Value], *, silent: bool) -> None:
        """Output the values of the sensors; raises WireError if lines or files cannot be written.

        Args:
            values: channel -> gauge Pa, bit, or None: invalid (of `Bench.sample`).
            silent: no value reaches the board.
        """
        for name, value in carried(values, self._kinds, self._description).items():
            if (channel := self._channels[name]).analog:
                self._show(channel, None if silent or value is None else round(channel.raw(value) / SCALE_MV))
        levels = {} if silent else self.levels(values)
        if levels != self._levels and levels:
            self._pins.drive(levels)
            self._levels = levels

    def levels(self, values: Mapping[str, Value]) -> dict[str, bool]:
        """Return the level of every input line for these values of the sensors."""
        levels: dict[str, bool] = {}
        for name, value in carried(values, self._kinds, self._description).items():
            if digital := (channel := self._channels[name]).digital:
                pulled_up = self._pulls[digital.line] == "up"
                levels[digital.line] = pulled_up if value is None else bool(channel.raw(value))
        return levels

    def close(self) -> None:
        """Stop the output; the board keeps the last levels and values."""
        self._pins.close()

    def _show(self, channel: Channel, count: int | None) -> None:
        assert channel.analog
        file = self._devices[channel.analog.device] / f"in_{channel.analog.channel}_raw"
        if file in self._counts and count == self._counts[file]:
            return
        self._counts[file] = count
        try:
            if count is None:
                file.unlink(missing_ok=True)
                return
            fresh = file.with_name(f".{file.name}.{os.getpid()}")  # a reader finds a whole number
            fresh.write_text(f"{count}\n", encoding="ascii")
            fresh.replace(file)
        except FileNotFoundError:  # somebody has unplugged the device
            return
        except OSError as error:
            raise WireError(f"cannot be written: {error.strerror}.", where=str(file)) from error

    def _device(self, name: str) -> Path:
        """Return the folder of a device, created if necessary as the kernel would; raises OSError."""
        with suppress(WireError):
            return find_device(self._iio, name)
        number = 0
        while (self._iio / f"iio:device{number}").exists():
            number += 1
        folder = self._iio / (name if name.startswith("iio:device") else f"iio:device{number}")
        folder.mkdir(parents=True)
        (folder / "name").write_text(f"{name}\n", encoding="ascii")
        return folder
