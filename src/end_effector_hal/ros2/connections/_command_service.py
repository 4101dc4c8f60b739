"""Connections to the command service of a node."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import ANSWER_US
from end_effector_hal.nodes.interface import Service

CONNECT_S = 0.4
"""Longest wait for a connection, s; shorter than the validity of a command."""


class RclpyCommandService:
    """A client of the service of another process; the executor of its node receives the answer.

    Args:
        client: a client of rclpy.
        service: a service of the interface table.
    """

    def __init__(self, client: Any, service: Service) -> None:
        self._client, self._server = client, service.server
        if not client.wait_for_service(timeout_sec=CONNECT_S):
            raise ConnectionError(f"The node {self._server} cannot be reached.")

    def call(self, command: int, until_us: int) -> Answer:
        """Request a command, which must begin before ``until_us``; raises ConnectionError."""
        request = self._client.srv_type.Request(command=command, until_us=until_us)
        answered = threading.Event()
        future = self._client.call_async(request)
        future.add_done_callback(lambda _future: answered.set())
        if not answered.wait(ANSWER_US / 1e6):
            self._client.remove_pending_request(future)
            raise ConnectionError(f"The node {self._server} does not answer.")
        answer = future.result()
        return Answer(answer.accepted, answer.reason, answer.decided, answer.count)

    def close(self) -> None:
        """Do nothing: the client is kept for the next connection."""


@dataclass(frozen=True, slots=True)
class LocalRequest:
    """The ``HalCommand_Request`` of a node of this process."""

    command: int
    until_us: int


class LocalService:
    """A connection to a node of this process.

    Args:
        handler: returns the handler of the service; None: the node is not up yet.
        service: a service of the interface table.
    """

    def __init__(self, handler: Callable[[], Callable[[Any], Answer] | None], service: Service) -> None:
        self._handler, self._server = handler, service.server

    def call(self, command: int, until_us: int) -> Answer:
        """Request a command, which must begin before ``until_us``; raises ConnectionError."""
        if (handler := self._handler()) is None:
            raise ConnectionError(f"The node {self._server} is not up yet.")
        return handler(LocalRequest(command, until_us))

    def close(self) -> None:
        """Do nothing: there is no connection to close."""
