"""Gives commands to a unit through its service; a node that hangs or has gone gives an answer as well."""

from __future__ import annotations

import queue
import threading
from dataclasses import dataclass
from typing import Any

import rospy

from end_effector_hal.nodes.interface import COMMAND_VALID_S, Service
from end_effector_hal.wires import now_us

from ._known_publishers import nodes_of
from ._types import service_class

VALID_S, ANSWER_S = COMMAND_VALID_S, 4.0
"""How long a command may be begun, counted from when it is asked for and through all attempts to deliver it, and how
long its answer is waited for: longer than an unlock waits for its proof and the unit for its turn, so that nothing is
executed once it was given up."""


@dataclass(frozen=True, slots=True)
class Reply:
    """What came back; ``count``: of the status after the acceptance; ``reached``: it was decided there."""

    accepted: bool
    reason: str
    count: int = 0
    reached: bool = True


_Jobs = queue.SimpleQueue[tuple[int, int, queue.SimpleQueue[Reply]]]


class Commander:
    """A client that keeps its connection. It calls in a thread of its own, for rospy knows no time-out."""

    def __init__(self, service: Service) -> None:
        self._service = service
        self._lock = threading.Lock()
        self._jobs: _Jobs | None = None

    def ask(self, command: int) -> Reply:
        """Give a command of Table II and wait for the decision, at most 4 s."""
        with self._lock:
            if self._jobs is None:
                self._jobs = queue.SimpleQueue()
                threading.Thread(target=self._run, args=(self._jobs,), daemon=True).start()
            replies: queue.SimpleQueue[Reply] = queue.SimpleQueue()
            self._jobs.put((command, now_us() + round(VALID_S * 1e6), replies))
            try:
                return replies.get(timeout=ANSWER_S)
            except queue.Empty:
                # that thread is left behind with its connection; the next call begins anew
                self._jobs = None
                return Reply(False, f"The node {self._service.server} does not answer.", reached=False)

    def _run(self, jobs: _Jobs) -> None:
        proxy = None
        while jobs is self._jobs:
            command, until_us, replies = jobs.get()
            fresh = proxy is None
            proxy, reply = self._call(proxy, command, until_us)
            if proxy is None and not fresh and now_us() < until_us:
                # its node was started again since the last call
                proxy, reply = self._call(None, command, until_us)
            replies.put(reply)

    def _call(self, proxy: Any, command: int, until_us: int) -> tuple[Any, Reply]:
        try:
            if proxy is None:
                proxy = rospy.ServiceProxy(
                    self._service.name, service_class(self._service.type), persistent=True
                )
            answer = proxy(command, until_us)
            answered = str(proxy.transport.header.get("callerid", ""))
            if answered not in nodes_of(self._service.name, (self._service.server,)):
                return self._lost(
                    proxy, f"Another node answers for {self._service.server}: {answered[:80]!a}."
                )
        except (rospy.ServiceException, rospy.ROSException, rospy.exceptions.TransportException, OSError):
            return self._lost(proxy, f"The node {self._service.server} cannot be reached.")
        return proxy, Reply(answer.accepted, answer.reason, answer.count, answer.decided)

    @staticmethod
    def _lost(proxy: Any, why: str) -> tuple[Any, Reply]:
        if proxy is not None:
            proxy.close()
        return None, Reply(False, why, reached=False)
