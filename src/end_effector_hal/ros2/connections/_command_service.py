"""Connections to the service by which a node takes commands."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import ANSWER_US
from end_effector_hal.nodes.interface import Service

CONNECT_S = 0.4
"""Within the time for which a command is valid."""


class RclpyCommandService:
    """A client of the service of another process; the executor of its node takes the answer.

    Args:
        client: of rclpy.
        service: of the table.
    """

    def __init__(self, client: Any, service: Service) -> None:
        self._client, self._server = client, service.server
        if not client.wait_for_service(timeout_sec=CONNECT_S):
            raise ConnectionError(f"The node {self._server} cannot be reached.")

    def call(self, command: int, until_us: int) -> Answer:
        """Have a command begun; raises ConnectionError."""
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
        """Leave the connection: the client stays, for the next one."""


@dataclass(frozen=True, slots=True)
class LocalRequest:
    """``HalCommand_Request`` of a node of this process."""

    command: int
    until_us: int


class LocalService:
    """A node of this process.

    Args:
        handler: gives what answers; None: the node is not up yet.
        service: of the table.
    """

    def __init__(self, handler: Callable[[], Callable[[Any], Answer] | None], service: Service) -> None:
        self._handler, self._server = handler, service.server

    def call(self, command: int, until_us: int) -> Answer:
        """Have a command begun; raises ConnectionError."""
        if (handler := self._handler()) is None:
            raise ConnectionError(f"The node {self._server} is not up yet.")
        return handler(LocalRequest(command, until_us))

    def close(self) -> None:
        """There is nothing to leave."""
