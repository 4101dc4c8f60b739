"""Translate sensor frames to messages and back, once for all nodes of a process, and refuse stamps that are
ahead of now.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description
from end_effector_hal.signals import Frame, Kind, StampGate
from end_effector_hal.vocabulary import Alarm
from end_effector_hal.wires import now_us

from ._messages import FrameMessage


class StampCheck:
    """Checks the stamps of one kind of message, and logs when it begins to refuse; not thread-safe.

    Args:
        what: plural noun for the messages, used in a sentence.
        log: the logger of the node.
    """

    def __init__(self, what: str, log: logging.Logger) -> None:
        self._gate, self._log = StampGate(what), log

    def accepts(self, *stamps: int) -> bool:
        """Return whether no stamp of a message (µs, monotonic clock of this machine) is in the future."""
        now = now_us()
        before = self._gate.notices(now)
        accepted = all(self._gate.passes(stamp, now) for stamp in stamps)
        for alarm in self._gate.notices(now):
            if alarm not in before:
                self._log.error("%s", alarm)
        return accepted

    def notices(self, at_us: int) -> tuple[Alarm, ...]:
        """Return the alarm about recently refused messages."""
        return self._gate.notices(at_us)


AMBIENT_PA = 101_325
"""The standard atmosphere, Pa: the difference between FluidPressure, which is absolute, and a frame, which is gauge."""


class Frames:
    """Frames and their messages, for the nodes of one process that work with the same tool; thread-safe."""

    def __init__(self, description: Description) -> None:
        self._kinds = carrier_of(description).channels
        self._newest: tuple[object, Frame | None] = (None, None)

    def message_of(self, frame: Frame) -> FrameMessage:
        """Return the message of a frame from the link."""
        message = frame_to_message(frame)
        self._newest = (message, frame)
        return message

    def frame_of(self, message: FrameMessage) -> Frame:
        """Return the frame of a message, with the channels of the codec."""
        known, frame = self._newest
        if frame is None or message is not known:
            frame = frame_from_message(message, self._kinds)
            self._newest = (message, frame)
        return frame


class SharedFrames:
    """The `Frames` of a process with several nodes; only nodes with equal descriptions share them."""

    def __init__(self) -> None:
        self._of: list[tuple[Description, Frames]] = []

    def of(self, description: Description) -> Frames:
        """Return the frames that the nodes of this tool share."""
        for known, frames in self._of:
            if known == description:
                return frames
        self._of.append((description, Frames(description)))
        return self._of[-1][1]


def frame_to_message(frame: Frame) -> FrameMessage:
    """Return the message of a frame."""
    values = frame.values.values()
    return FrameMessage(
        at_us=frame.at,
        seq=-1 if frame.seq is None else frame.seq,
        device_ms=-1 if frame.device_ms is None else frame.device_ms,
        channels=list(frame.values),
        values=[0 if value is None else int(value) for value in values],
        valid=[value is not None for value in values],
    )


def frame_from_message(message: FrameMessage, kinds: Mapping[str, Kind]) -> Frame:
    """Return the frame of a message; ``kinds`` are the channels of the codec, others are left out."""
    values: dict[str, int | bool | None] = {}
    for channel, value, valid in zip(message.channels, message.values, message.valid, strict=False):
        if channel in kinds:
            plain = bool(value) if kinds[channel] is Kind.BIT else value
            values[channel] = plain if valid else None
    return Frame(
        at=message.at_us,
        seq=None if message.seq < 0 else message.seq,
        device_ms=None if message.device_ms < 0 else message.device_ms,
        values=values,
    )


def absolute_pa(value: int | bool | None) -> float:
    """Return the absolute pressure of a gauge pressure, Pa; NaN if it is invalid, or a bit."""
    return float("nan") if value is None or isinstance(value, bool) else float(AMBIENT_PA + value)
