"""Deliver messages between the nodes of one process directly, in the thread of the publisher.

There is no middleware between a sensor frame and the automata, and no other process can send a frame in its place.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Collection
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.nodes.interface import Service, Topic

Handler = Callable[[Any], Answer]


class LocalBus:
    """Topics and services within one process; thread-safe.

    Args:
        nodes: names of the nodes that run here.
        log: logs the exceptions of callbacks.
    """

    def __init__(self, nodes: frozenset[str], log: logging.Logger) -> None:
        self._nodes, self._log = nodes, log
        self._lock = threading.Lock()
        self._callbacks: dict[str, tuple[Callable[[Any], None], ...]] = {}
        self._last: dict[str, Any] = {}
        self._handlers: dict[str, Handler] = {}

    def carries(self, topic: Topic) -> bool:
        """Return whether all accepted messages of a topic are published in this process."""
        return not topic.public and self._nodes.issuperset(topic.publishers)

    def runs(self, nodes: Collection[str]) -> bool:
        """Return whether all these nodes run here."""
        return self._nodes.issuperset(nodes)

    def subscribe(self, topic: Topic, callback: Callable[[Any], None]) -> None:
        """Call ``callback`` for every message of a topic; for a latched topic also at once with the last message."""
        with self._lock:
            self._callbacks[topic.name] = (*self._callbacks.get(topic.name, ()), callback)
            last = self._last.get(topic.name)
        if last is not None:
            self._call(callback, last)

    def deliver(self, topic: Topic, message: Any) -> None:
        """Pass a message to every subscriber."""
        if topic.latched:
            with self._lock:
                self._last[topic.name] = message
        for callback in self._callbacks.get(topic.name, ()):
            self._call(callback, message)

    def serves(self, service: Service) -> bool:
        """Return whether the server of a service runs here."""
        return service.server in self._nodes

    def serve(self, service: Service, handler: Handler) -> None:
        """Answer the calls of a service from this process."""
        self._handlers[service.name] = handler

    def handler(self, service: Service) -> Handler | None:
        """Return the handler of a service; None: its node is not up yet."""
        return self._handlers.get(service.name)

    def _call(self, callback: Callable[[Any], None], message: Any) -> None:
        try:
            callback(message)
        except Exception:  # noqa: BLE001 a callback may raise anything
            self._log.exception("a callback of a topic failed")
