"""A wrapper around a controller that records its inputs and outputs; a replay runs the same wrapper."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from end_effector_hal.control import Answer, Controller, Status
from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from timed_automata import Network

from ._records import (
    Acknowledged,
    ActivationRefused,
    Answered,
    Commanded,
    FrameTaken,
    Start,
    TimeAdvanced,
)

Put = Callable[[object], None]
"""Stores a record, of a type in `KINDS`."""


class RecordedController:
    """Has the methods of a :class:`Controller`; records every input before the call and every output after it."""

    def __init__(
        self,
        description: Description,
        network: Network,
        put: Put,
    ) -> None:
        self._put = put
        self._controller = Controller(description, network, observe=put)
        self.status, self.refuse_maintenance = self._controller.status, self._controller.refuse_maintenance
        self.refusal, self.foresee = self._controller.refusal, self._controller.foresee
        self.announce_to = self._controller.announce_to
        self.senses = self._controller.senses
        self.snapshot, self.resume = self._controller.snapshot, self._controller.resume

    @property
    def deadline(self) -> int | None:
        """Time of the next event that needs no input, µs, or None."""
        return self._controller.deadline

    @property
    def discrete_state(self) -> object:
        """A value that is equal for equal locations and values of the automata."""
        return self._controller.discrete_state

    def start(
        self,
        levels: Mapping[str, bool],
        at: int,
        *,
        sensor_fault: bool = False,
        grip_error: bool = False,
        part: str = "",
    ) -> list[Status]:
        """Record the start, and start the controller."""
        self._put(Start(at, dict(levels), sensor_fault, grip_error, part))
        started = self._controller.start(
            levels, at, sensor_fault=sensor_fault, grip_error=grip_error, part=part
        )
        return self._decided(started)

    def frame(self, frame: Frame, at: int | None = None) -> list[Status]:
        """Record a frame of the link, and process it."""
        taken_at = frame.at if at is None else at
        self._put(FrameTaken.of(frame, taken_at))
        return self._decided(self._controller.frame(frame, at))

    def pass_over(self, frame: Frame) -> list[Status]:
        """Process the frame like any other, because a recording must have every frame."""
        return self.frame(frame)

    def refused(self, at: int, *, unlock: bool = False) -> list[Status]:
        """Record and process that the line arbiter refused an activation."""
        self._put(ActivationRefused(at, unlock))
        return self._decided(self._controller.refused(at, unlock=unlock))

    def acknowledge(self, at: int) -> list[Status]:
        """Record and process that the alarms that are over were seen."""
        self._put(Acknowledged(at))
        return self._decided(self._controller.acknowledge(at))

    def advance(self, at: int) -> list[Status]:
        """Record the time, and do everything that is due at or before ``at``."""
        self._put(TimeAdvanced(at))
        return self._decided(self._controller.advance(at))

    def command(self, name: str, at: int, part: str = "") -> tuple[Answer, list[Status]]:
        """Record and execute a command, given by the name of its channel; ``part``: what is to be gripped."""
        self._put(Commanded(at, name, part))
        answer, statuses = self._controller.command(name, at, part)
        self._decided(statuses)
        self._put(Answered(at, answer.accepted, answer.reason))
        return answer, statuses

    def _decided(self, statuses: list[Status]) -> list[Status]:
        for status in statuses:
            self._put(status)
        return statuses


AnyController = Controller | RecordedController
_CALLS: Mapping[str, Callable[[AnyController, Any], object]] = {
    "start": lambda controller, record: controller.start(
        record.levels,
        record.at,
        sensor_fault=record.sensor_fault,
        grip_error=record.grip_error,
        part=record.part,
    ),
    "frame": lambda controller, record: controller.frame(record.frame, record.at),
    "command": lambda controller, record: controller.command(record.name, record.at, record.part),
    "refused": lambda controller, record: controller.refused(record.at, unlock=record.unlock),
    "acknowledge": lambda controller, record: controller.acknowledge(record.at),
    "time": lambda controller, record: controller.advance(record.at),
}


def feed(controller: AnyController, kind: str, record: Any) -> None:
    """Give a controller a recorded input, as its program did; ``kind`` is a key of `INPUTS`."""
    _CALLS[kind](controller, record)
