"""The program of a tool in another process, followed and commanded over its socket.

One thread reads the records and blocks until the next one comes: an idle face wakes only for what the HAL sends.
A record that no listener wants is skipped by its first bytes, without parsing it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from functools import cache
from typing import Any

from pydantic import TypeAdapter
from pydantic_core import from_json, to_json

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
    SWITCH_WORDS,
    ProgramCommand,
    program_socket,
)
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Alarm, ChangerState, Command, EndEffectorState, Evidence
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc import Client
from end_effector_hal.wires.sensors import SensorHealth

SILENT_S = 1.2
"""Silence after which the HAL counts as lost, s; a HAL that works sends a sign of life every 0.4 s."""
AGAIN_S = 0.3
GAP_S = 0.012
"""Shortest time between two commands, s: the HAL ends a connection that sends more than 100 lines in a second."""
VALID_US = 1_000_000
"""Time within which the HAL must begin a command, µs; later it is not executed."""
ANSWER_S = 4.0
FOLLOWS_S = 1.0
"""Longest wait for the status that follows an answer, s."""
END_S = 2.0
_UNSENT = Answer(False, "There is no connection to the HAL.")


class RemoteProgram:
    """Gives commands to a program in another process, and receives its statuses; thread-safe.

    Args:
        description: the tool; a HAL that runs another one is not followed.
        on_status: called with each status.
        on_frame: called with each frame that the program has processed, once :meth:`want` has asked for them.
        on_readings: called with what the sensors read, likewise.
        on_health: called once a second, while the HAL works.

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
        on_health: Callable[[], None],
    ) -> None:
        self._description, self._hash = description, content_hash(description)
        self._latest = LatestStatus(_nothing_known(description), on_status)
        self._on_frame, self._on_readings, self._on_health = on_frame, on_readings, on_health
        self._wanted, self._skipped = frozenset[str](), tuple[bytes, ...]()
        self.want("header", PUBLISHED, HEALTH)
        self.health = SensorHealth({}, None)
        self._published: Status | None = None  # the latest status of the program itself
        self.why, self.is_other = "Nothing was received from the HAL yet.", False
        self._client = Client(program_socket(description), SILENT_S)
        self._sending = threading.Lock()
        """Held while the connection changes, and while a command is sent."""
        self._asked: dict[int | None, Future[Answer]] = {}
        self._count, self._free_at = 0, 0.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="HAL's records", daemon=True)

    def want(self, *kinds: str) -> None:
        """Receive the records of these kinds of `STREAMED` from now on, too."""
        self._wanted |= set(kinds)
        unwanted = STREAMED.keys() - self._wanted
        self._skipped = tuple(f'{{"kind":"{kind}"'.encode() for kind in unwanted)

    def start(self) -> None:
        """Connect, and connect again whenever the HAL is back, until `close`."""
        self._thread.start()

    def close(self) -> None:
        """End the connection."""
        self._latest.end()
        self._ended.set()
        self._client.abort()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join(END_S)

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
        with self._sending:
            if not self._client.connected:
                return _UNSENT
            time.sleep(max(0.0, self._free_at - time.monotonic()))
            self._free_at = time.monotonic() + GAP_S
            self._count += 1
            number, future = self._count, Future[Answer]()
            self._asked[number] = future
            request = ProgramCommand(number, now_us() + VALID_US, command, name)
            try:
                self._client.send(to_json(request) + b"\n")
            except OSError:
                self._client.abort()  # a part of the line may be sent: the rest would join the next one
                del self._asked[number]
                return _UNSENT
        try:
            answer = future.result(ANSWER_S)
        except TimeoutError:
            return _unknown("does not answer")
        finally:
            self._asked.pop(number, None)
        # as in one process: the first statuses are there before the answer
        self._latest.wait(lambda status: not self.alive or status.count >= answer.count, FOLLOWS_S)
        return answer

    # From here on: in the thread of the records.

    def _run(self) -> None:
        while not self._ended.is_set():
            why = self._follow()
            if not self._ended.is_set():
                self._lose(why)
            self._ended.wait(AGAIN_S)

    def _follow(self) -> str:
        """Receive records until the connection ends; return why it has ended."""
        try:
            with self._sending:
                self._client.connect()
            while not self._ended.is_set():
                try:
                    line = self._client.receive()
                except BlockingIOError:
                    self._lose("The HAL is silent.")
                else:
                    self._receive(line)
        except (FileNotFoundError, ConnectionRefusedError):
            return f"The HAL does not run, or has no socket ({self._client.path})."
        except ReportedError as error:
            return str(error)
        except OSError as error:
            return f"The HAL cannot be read: {error.strerror or error} ({self._client.path})."
        finally:
            self._disconnect()
        return ""

    def _disconnect(self) -> None:
        with self._sending:
            self._client.close()
            asked, self._asked = self._asked, {}
        for future in asked.values():
            if not future.done():
                future.set_result(_unknown("has gone"))

    def _receive(self, line: bytes) -> None:
        if not line.startswith(self._skipped):
            try:
                self._take(from_json(line))
            except ReportedError:  # who takes the records refuses this one, and says why
                raise
            except Exception as error:  # noqa: BLE001 of another release, or of anything: it ends this connection only
                raise ReportedError(f"A record of the HAL cannot be read: {error}"[:300]) from None
        if self.why and self._published is not None:  # it was silent
            self._publish(self._published)

    def _take(self, message: Any) -> None:
        if message["kind"] == "answer-to":
            if (future := self._asked.get(message["id"])) is not None and not future.done():
                accepted, decided = message["accepted"] is True, message["decided"] is True
                future.set_result(Answer(accepted, str(message["reason"]), decided, int(message["record"])))
        elif message["kind"] in self._wanted:
            self.take(_adapter(message["kind"]).validate_python(message["content"]))

    def take(self, record: object) -> None:
        """Process a record that the HAL has sent; raises ReportedError if it is not followed any more."""
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
            self._publish(self._published)
        elif isinstance(record, FrameTaken):
            self._on_frame(record.frame)
        elif isinstance(record, JudgedReadings):
            self._on_readings(record)
        elif isinstance(record, SensorHealth):
            self.health = record
            self._on_health()

    def _publish(self, status: Status) -> None:
        self.why = ""
        self._latest.publish(status)

    def _lose(self, why: str) -> None:
        self.why = why
        if self._latest.status.alarm("hal.lost"):
            return  # it is said once, with its first reason
        self.health = SensorHealth({}, None)
        self._on_readings(JudgedReadings(now_us(), dict.fromkeys(carrier_of(self._description).channels)))
        alarm = Alarm("hal.lost", values={"why": why}, since=now_us())
        self._latest.publish(replace(unknown_now(self._latest.status), at=now_us(), alarms=(alarm,)))


@cache
def _adapter(kind: str) -> TypeAdapter[Any]:
    return TypeAdapter(STREAMED[kind])


def _unknown(what: str) -> Answer:
    return Answer(False, f"The HAL {what}: it is unknown whether the command was executed.", decided=False)


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
