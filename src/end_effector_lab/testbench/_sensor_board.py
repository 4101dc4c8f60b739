"""The device that samples the sensors and sends frames of a codec, sans-IO: it has a counter, an age, and restarts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from end_effector_hal.codecs import Codec, is_polled
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.signals import Frame, Kind, Value

from ._bench import Bench
from ._modbus import CommandedRegisters


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
    """

    data: bytes
    seq: int
    values: Mapping[str, Value]
    clean: bytes
    late_us: int = 0


class SensorBoard:
    """Sends the readings of a bench over one link, in the format of its codec.

    Args:
        codec: streamed (call `frame`) or polled (call `answer`).
        bench: source of the readings, and of the faults of the link.
        start: time at which the device was switched on, µs.
        link: name of the link; None: it is the only one.
        registers: registers that are commanded over the link, if there are any.
    """

    def __init__(
        self,
        codec: Codec,
        bench: Bench,
        description: Description,
        start: int,
        link: str | None = None,
        registers: CommandedRegisters | None = None,
    ) -> None:
        self._link, self._registers = link, registers
        self._codec, self._bench, self._description = codec, bench, description
        self._booted, self._seq = start, 0
        self._device = codec.device() if is_polled(codec) else None

    def frame(self, at: int) -> Sent:
        """Return the frame that is due at ``at`` (µs)."""
        sample, seq = self._bench.sample(at), self.count(at)
        age_ms = max(0, at - self._booted) // 1000
        return self._sent(self._codec.encode(Frame(0, seq, age_ms, self._carried(sample))), seq, sample, at)

    def advance(self, at: int) -> None:
        """Advance the outputs in time while there is no request; call it now and then."""
        if self._registers:
            self._registers.advance(at)

    def answer(self, request: bytes, at: int) -> Sent | None:
        """Return the answer to the bytes of a request at ``at`` (µs), or None if there is none."""
        self.advance(at)
        sample = self._bench.sample(at)
        if self._registers:
            if self._bench.silent(at):  # without power, or without a wire: it hears nothing
                return None
            self._registers.hear(request, at)
            if done := self._registers.answer(request):
                return self._sent(done, self.count(at), sample, at)
            sample |= self._registers.values
        answers = self._device.answer(request, self._carried(sample)) if self._device else b""
        if not answers:
            return None
        answers, late_us = self._bench.answered(answers, at, self._link)
        return self._sent(answers, self.count(at), sample, at)._replace(late_us=late_us)

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

    def _carried(self, sample: Mapping[str, Value]) -> dict[str, Value]:
        return carried(sample, self._codec.channels, self._description)
