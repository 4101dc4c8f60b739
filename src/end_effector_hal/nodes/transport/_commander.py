"""Send commands to a program in another node; a node that hangs or is gone leads to an answer as well."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Protocol

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import ANSWER_US
from end_effector_hal.nodes.interface import COMMAND_VALID_S
from end_effector_hal.wires import now_us

VALID_S = COMMAND_VALID_S
"""Time within which a command must begin, s, counted from its request and through all attempts to deliver it: an
abandoned command is never executed.
"""
_Job = tuple[int, int, Callable[[Answer], None]]


class CommandConnection(Protocol):
    """A connection to the service of a node."""

    def call(self, command: int, until_us: int) -> Answer:
        """Request a command, which must begin before ``until_us``; raises ConnectionError if no answer will come."""

    def close(self) -> None:
        """Close the connection."""


class Commander:
    """A client that keeps its connection, and calls in a thread of its own.

    Args:
        server: name of the node.
        connect: opens a connection; raises ConnectionError.
    """

    def __init__(self, server: str, connect: Callable[[], CommandConnection]) -> None:
        self._server, self._connect = server, connect
        self._lock, self._asking = threading.Lock(), threading.Lock()
        self._jobs: queue.SimpleQueue[_Job] | None = None

    def send(self, command: int, on_answer: Callable[[Answer], None]) -> None:
        """Send a command of Table II and return at once; the answer comes in the thread of this client, or never."""
        with self._lock:
            if self._jobs is None:
                self._jobs = queue.SimpleQueue()
                try:
                    threading.Thread(target=self._run, args=(self._jobs,), daemon=True).start()
                except RuntimeError as error:
                    self._jobs = None
                    on_answer(Answer(False, f"The node {self._server} cannot be asked: {error}."))
                    return
            self._jobs.put((command, now_us() + round(VALID_S * 1e6), on_answer))

    def give_up(self) -> None:
        """Abandon an answer that is late: its thread is left behind, and the next call opens a new connection."""
        with self._lock:
            self._jobs = None

    def ask(self, command: int) -> Answer:
        """Send a command of Table II and wait for the decision, at most 4 s."""
        answers: queue.SimpleQueue[Answer] = queue.SimpleQueue()
        with self._asking:
            self.send(command, answers.put)
            try:
                return answers.get(timeout=ANSWER_US / 1e6)
            except queue.Empty:
                self.give_up()
                return Answer(False, f"The node {self._server} does not answer.", decided=False)

    def _run(self, jobs: queue.SimpleQueue[_Job]) -> None:
        connection = None
        while jobs is self._jobs:
            command, until_us, on_answer = jobs.get()
            fresh = connection is None
            connection, answer = self._call(connection, command, until_us)
            if connection is None and not fresh and now_us() < until_us:
                # its node was started again since the last call
                connection, answer = self._call(None, command, until_us)
            on_answer(answer)

    def _call(
        self, connection: CommandConnection | None, command: int, until_us: int
    ) -> tuple[CommandConnection | None, Answer]:
        try:
            connection = connection or self._connect()
            return connection, connection.call(command, until_us)
        except ConnectionError as error:
            if connection is not None:
                connection.close()
            return None, Answer(False, str(error), decided=False)
