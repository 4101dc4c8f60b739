"""Gives commands to a unit through its service; a node that hangs or has gone gives an answer as well."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any

import rospy

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import ANSWER_US
from end_effector_hal.nodes.interface import COMMAND_VALID_S, Service
from end_effector_hal.wires import now_us

from ._known_publishers import nodes_of
from ._types import service_class

VALID_S = COMMAND_VALID_S
"""How long a command may be begun, counted from when it is asked for and through all attempts to deliver it: nothing
is executed once it was given up."""
_Job = tuple[int, int, Callable[[Answer], None]]


class Commander:
    """A client that keeps its connection. It calls in a thread of its own, for rospy knows no time-out."""

    def __init__(self, service: Service) -> None:
        self._service = service
        self._lock, self._asking = threading.Lock(), threading.Lock()
        self._jobs: queue.SimpleQueue[_Job] | None = None

    def send(self, command: int, on_answer: Callable[[Answer], None]) -> None:
        """Give a command of Table II; returns at once. The answer comes in the thread of this client, or never."""
        with self._lock:
            if self._jobs is None:
                self._jobs = queue.SimpleQueue()
                threading.Thread(target=self._run, args=(self._jobs,), daemon=True).start()
            self._jobs.put((command, now_us() + round(VALID_S * 1e6), on_answer))

    def give_up(self) -> None:
        """The answer has not come in time: its thread is left behind, and the next call gets a new connection."""
        with self._lock:
            self._jobs = None

    def ask(self, command: int) -> Answer:
        """Give a command of Table II and wait for the decision, at most 4 s."""
        answers: queue.SimpleQueue[Answer] = queue.SimpleQueue()
        with self._asking:
            self.send(command, answers.put)
            try:
                return answers.get(timeout=ANSWER_US / 1e6)
            except queue.Empty:
                self.give_up()
                return Answer(False, f"The node {self._service.server} does not answer.", decided=False)

    def _run(self, jobs: queue.SimpleQueue[_Job]) -> None:
        proxy = None
        while jobs is self._jobs:
            command, until_us, on_answer = jobs.get()
            fresh = proxy is None
            proxy, answer = self._call(proxy, command, until_us)
            if proxy is None and not fresh and now_us() < until_us:
                # its node was started again since the last call
                proxy, answer = self._call(None, command, until_us)
            on_answer(answer)

    def _call(self, proxy: Any, command: int, until_us: int) -> tuple[Any, Answer]:
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
        return proxy, Answer(answer.accepted, answer.reason, answer.decided, answer.count)

    @staticmethod
    def _lost(proxy: Any, why: str) -> tuple[Any, Answer]:
        if proxy is not None:
            proxy.close()
        return None, Answer(False, why, decided=False)
