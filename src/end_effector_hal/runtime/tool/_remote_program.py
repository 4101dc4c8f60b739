"""The program of a tool in another process, followed and commanded over its socket."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import Answer, Status, unknown_now
from end_effector_hal.description import Description, content_hash
from end_effector_hal.errors import ReportedError
from end_effector_hal.kinds import kind_of
from end_effector_hal.runtime.boundary import STREAMED, FrameTaken, Header, Published
from end_effector_hal.runtime.programs import LatestStatus, proof
from end_effector_hal.runtime.stream import (
    HEALTH,
    MAINTENANCE_WORDS,
    PUBLISHED,
    READINGS,
    SWITCH_WORDS,
    program_socket,
)
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Alarm, ChangerState, Command, EndEffectorState, Evidence
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc.aio import ANSWER_S, AsyncClient
from end_effector_hal.wires.sensors import SensorHealth

SILENT_US = 1_200_000
"""Silence after which the HAL counts as lost, µs; a HAL that works sends a sign of life every 0.4 s."""
LOOK_S = 0.3
FOLLOWS_S = 1.0
"""Longest wait for the status that follows an answer, s."""
_RECORDS = {kind: STREAMED[kind] for kind in ("header", "frame", PUBLISHED, READINGS, HEALTH)}


class RemoteProgram:
    """Gives commands to a program in another process, and receives its statuses; thread-safe.

    Args:
        description: the tool; a HAL that runs another one is not followed.
        on_status: called with each status.
        on_frame: called with each frame that the program has processed.
        on_readings: called with what the sensors read.

    Attributes:
        health: state of the sensor links and inputs, as the HAL has sent it last.
        why: reason why the HAL is lost, a sentence; empty: it is not lost.
        is_other: whether the last HAL that was reached runs another description.
    """

    def __init__(
        self,
        description: Description,
        on_status: Callable[[Status], None],
        on_frame: Callable[[Frame], None],
        on_readings: Callable[[JudgedReadings], None],
    ) -> None:
        self._description, self._hash = description, content_hash(description)
        self._latest = LatestStatus(_nothing_known(description), on_status)
        self._on_frame, self._on_readings = on_frame, on_readings
        self._channels = carrier_of(description).channels
        self.health = SensorHealth({}, None)
        self._published: Status | None = None  # the latest status of the program itself
        self._heard_at = 0
        self.why, self.is_other = "Nothing was received from the HAL yet.", False
        self._client = AsyncClient(program_socket(description), "The HAL", _RECORDS, self._take, self._lose)
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="HAL's records", daemon=True)

    def start(self) -> None:
        """Connect, and connect again whenever the HAL is back, until `close`."""
        self._thread.start()

    def close(self) -> None:
        """End the connection."""
        self._latest.end()
        if self._thread.ident is None:  # never started
            self._loop.close()
            return
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._end)
        if self._thread is not threading.current_thread():
            self._thread.join(2.0)

    @property
    def status(self) -> Status:
        """The latest status; while the HAL is lost, what is still known (`unknown_now`)."""
        return self._latest.status

    @property
    def alive(self) -> bool:
        """Whether the HAL is connected and not silent; False after `close`."""
        return not self.why and not self._latest.ended

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        """Block until a status satisfies ``until``; return False on a time-out or after `close`."""
        return self._latest.wait(until, timeout_s)

    def command(self, name: str, part: str = "") -> Answer:
        """Give the program a command by its channel, and return its decision; ``part``: what is to be gripped."""
        return self._ask(name, part)

    def acknowledge(self) -> None:
        """Acknowledge the alarms that are over."""
        self._ask("acknowledge")

    def set_actuator(self, name: str, active: bool) -> Answer:
        """Drive one actuator in maintenance (IL-12); success requires sensor evidence."""
        answer = self._ask(MAINTENANCE_WORDS[0 if active else 1], name)
        return (
            proof(self._latest, self._description, name, None, active=active) if answer.accepted else answer
        )

    def switch(self, name: str, active: bool) -> Answer:
        """Switch a plain output."""
        return self._ask(SWITCH_WORDS[0 if active else 1], name)

    def _ask(self, command: str, name: str = "") -> Answer:
        request = self._client.request(command=command, name=name)
        try:
            answer = Answer(*asyncio.run_coroutine_threadsafe(request, self._loop).result(ANSWER_S + 1.0))
        except (TimeoutError, RuntimeError, asyncio.CancelledError):
            request.close()
            return Answer(False, "The HAL does not answer.", decided=False)
        # as in one process: the first statuses are there before the answer
        self._latest.wait(lambda status: not self.alive or status.count >= answer.count, FOLLOWS_S)
        return answer

    # From here on: in the thread of the records.

    def _run(self) -> None:
        self._following = self._loop.create_task(self._follow())
        with suppress(asyncio.CancelledError):
            self._loop.run_until_complete(self._following)
        asked = asyncio.all_tasks(self._loop)  # requests without an answer: each gets its end
        self._loop.run_until_complete(asyncio.wait(asked) if asked else asyncio.sleep(0))
        self._loop.close()

    async def _follow(self) -> None:
        records = self._loop.create_task(self._client.run())
        try:
            while True:
                looked_at = now_us()
                await asyncio.sleep(LOOK_S)
                # if this process did not run, records may wait to be read
                late = now_us() - looked_at > 2e6 * LOOK_S
                if not self.why and not late and now_us() - self._heard_at > SILENT_US:
                    self._lose("The HAL is silent.")
        finally:
            records.cancel()
            with suppress(asyncio.CancelledError):
                await records

    def _end(self) -> None:
        self._following.cancel()

    def _take(
        self,
        kind: str,
        at: int,
        record: Header | FrameTaken | Published | JudgedReadings | SensorHealth | None,
    ) -> None:
        self._heard_at = now_us()
        if isinstance(record, Header):
            self.is_other = record.hash != self._hash
            if self.is_other:
                raise ReportedError(f"The HAL runs another description: {record.source} ({record.hash}).")
            self._published = None
        elif isinstance(record, Published):
            _check(self._description, record.status)
            # the events of the first status were before this connection
            is_first = self._published is None
            self._published = replace(record.status, events=()) if is_first else record.status
            self._publish()
        elif isinstance(record, FrameTaken):
            self._on_frame(record.frame)
        elif isinstance(record, JudgedReadings):
            self._on_readings(record)
        elif isinstance(record, SensorHealth):
            self.health = record
        if self.why and self._published is not None:
            self._publish()

    def _publish(self) -> None:
        self.why = ""
        if self._published is not None:
            self._latest.publish(self._published)

    def _lose(self, why: str) -> None:
        self.why = why
        if self._latest.status.alarm("hal.lost"):
            return  # it is said once, with its first reason
        self.health = SensorHealth({}, None)
        self._on_readings(JudgedReadings(now_us(), dict.fromkeys(self._channels)))
        alarm = Alarm("hal.lost", values={"why": why}, since=now_us())
        self._latest.publish(replace(unknown_now(self._latest.status), at=now_us(), alarms=(alarm,)))


def _check(description: Description, status: Status) -> None:
    """Raise ValueError or KeyError if a status does not fit the actuators and the parts of the tool."""
    description.for_part(status.part)
    each = zip(description.ordered, status.actuators, status.outputs, status.evidence, strict=True)
    for (_, actuator), state, _, _ in each:
        kind_of(actuator).states(state)


def _nothing_known(description: Description) -> Status:
    count = len(description.sequence)
    return Status(
        now_us(),
        EndEffectorState.OFF,
        Command.NONE,
        actuators=(0,) * count,
        outputs=(False,) * count,
        evidence=(Evidence.UNKNOWN,) * count,
        changer=ChangerState.UNKNOWN,
    )
