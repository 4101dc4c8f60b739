"""The device that samples the sensors and sends what a codec carries, sans-IO: it counts, ages, and restarts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from end_effector_hal.codecs import Codec, is_polled
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.signals import Frame, Kind, Value

from ._bench import Bench
from .modbus import CommandedRegisters


def carried(
    values: Mapping[str, Value], channels: Mapping[str, Kind], description: Description
) -> dict[str, Value]:
    """The values that the codec's channels can carry; a pressure on a bit channel becomes "present".

    Args:
        values: channel -> gauge Pa, bit, or None: invalid (of :meth:`Bench.sample`).
        channels: of the codec.
        description: its thresholds are those of the switches.
    """
    seen = {name: values[name] for name in channels if name in values}
    for name, value in seen.items():
        if type(value) is int and channels[name] is Kind.BIT:
            seen[name] = abs(value) >= _present_pa(name, description)
    return seen


def _present_pa(channel: str, description: Description) -> float:
    """Where a pressure switch on this channel closes, as a magnitude."""
    for actuator in description.actuators.values():
        if actuator.channel == channel:
            limits = kind_of(actuator).limits(actuator, description.supply)
            if "confirmed_kpa" in limits:
                return limits["confirmed_kpa"] * 1000
    return description.supply.refuse_kpa * 1000


class Sent(NamedTuple):
    """What comes out of the link at one time.

    Attributes:
        data: bytes, as they arrive; b"": the link is silent, or nothing was asked.
        seq: number of the frame or answer, since the device was started.
        values: what every sensor showed.
        clean: the bytes before the cable.
        late_us: how much later they come.
    """

    data: bytes
    seq: int
    values: Mapping[str, Value]
    clean: bytes
    late_us: int = 0


class SensorBoard:
    """Sends what a bench shows over one link, in the format of its codec.

    Args:
        codec: streamed (call `frame`) or polled (call `answer`).
        bench: what is measured, and what is wrong with the link.
        description: of the tool.
        start: µs, when it was switched on.
        link: its name; None: it is the only one.
        registers: that are commanded over the link, if there are any.
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
        """The frame that is due at ``at`` (µs)."""
        sample, seq = self._bench.sample(at), self.count(at)
        age_ms = max(0, at - self._booted) // 1000
        return self._sent(self._codec.encode(Frame(0, seq, age_ms, self._carried(sample))), seq, sample, at)

    def advance(self, at: int) -> None:
        """What its outputs do when nobody speaks; called now and then."""
        if self._registers:
            self._registers.advance(at)

    def answer(self, request: bytes, at: int) -> Sent | None:
        """The answers to what was asked at ``at`` (µs); None: nothing was."""
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
        """The number of the frame, or the answer, of ``at`` (µs), each of which is counted once."""
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
