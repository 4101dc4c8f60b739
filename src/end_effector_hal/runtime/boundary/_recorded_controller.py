"""A controller that tells what goes in and what comes out; the same object is replayed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from end_effector_hal.control import Answer, Controller, Status
from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from timed_automata import Begun, Network, Observation, Received, Step, Written

from ._records import Acknowledged, Answered, Commanded, FrameTaken, Refused, Start, TimeTold, Told

Put = Callable[[str, int, object], None]
"""Takes the kind of a record, its time and its content."""
_KIND_OF: Mapping[type, str] = {Begun: "begin", Written: "write", Received: "event", Step: "step"}


class RecordedController(Controller):
    """Each input is recorded before it is taken, each output after it, in order."""

    def __init__(self, description: Description, network: Network, program: str, put: Put) -> None:
        super().__init__(description, network, program, observe=self._observed)
        self._put = put
        self._inside = False

    def start(self, levels: Mapping[str, bool], at: int, *, sensor_fault: bool = False) -> list[Status]:
        """Begin."""
        begin = partial(super().start, levels, at, sensor_fault=sensor_fault)
        return self._take("start", Start(at, dict(levels), sensor_fault), at, begin)

    def frame(self, frame: Frame, at: int | None = None) -> list[Status]:
        """One frame of the link."""
        taken_at = frame.at if at is None else at
        taken = FrameTaken(taken_at, frame.at, frame.seq, frame.device_ms, frame.values)
        return self._take("frame", taken, taken_at, partial(super().frame, frame, at))

    def tell(self, values: Mapping[str, int], at: int) -> list[Status]:
        """What another program says."""
        return self._take("tell", Told(at, dict(values)), at, partial(super().tell, values, at))

    def refused(self, at: int) -> list[Status]:
        """The line arbiter refused an activation."""
        return self._take("refused", Refused(at), at, partial(super().refused, at))

    def acknowledge(self, at: int) -> list[Status]:
        """Alarms that are over were seen."""
        return self._take("acknowledge", Acknowledged(at), at, partial(super().acknowledge, at))

    def advance(self, at: int) -> list[Status]:
        """Everything that is due at or before ``at``."""
        return self._take("time", TimeTold(at), at, partial(super().advance, at))

    def command(self, name: str, at: int) -> tuple[Answer, list[Status]]:
        """A command by the name of its channel."""
        answers: list[Answer] = []

        def command() -> list[Status]:
            answer, statuses = super(RecordedController, self).command(name, at)
            answers.append(answer)
            return statuses

        statuses = self._take("command", Commanded(at, name), at, command)
        self._put("answer", at, Answered(at, answers[0].accepted, answers[0].reason))
        return answers[0], statuses

    def _take(self, kind: str, record: object, at: int, call: Callable[[], list[Status]]) -> list[Status]:
        if self._inside:  # one input makes use of another: it is recorded once
            return call()
        self._put(kind, at, record)
        self._inside = True
        try:
            statuses = call()
        finally:
            self._inside = False
        for status in statuses:
            self._put("status", status.at, status)
        return statuses

    def _observed(self, observation: Observation) -> None:
        self._put(_KIND_OF[type(observation)], observation.at, observation)
