"""Send each message in the thread that publishes it, as long as the subscriber keeps up.

rospy passes each message to a separate thread for each subscriber: with three of them, all must get the interpreter
before a frame has left, in any order with the next steps of the publisher. rospy's queue and thread are still used for
a slow subscriber.
"""

from __future__ import annotations

import socket
from typing import Any

import rospy.topics
from rospy.impl.tcpros_pubsub import QueuedConnection


class DirectConnection(QueuedConnection):  # type: ignore[misc]
    """The connection to one subscriber; it never waits, and drops the oldest message when its queue is full."""

    def __init__(self, connection: Any, queue_size: int) -> None:
        self._cut = b""
        self._busy = False
        self._queue: list[bytes]
        self._error: Exception | None
        super().__init__(connection, queue_size)

    def write_data(self, data: bytes) -> bool:
        """Send the data, or leave it to the thread; raises the error that occurred in the thread before."""
        with self._lock:
            if self._error:
                error, self._error = self._error, None
                raise error
            if not self._queue and not self._busy:
                sent = self._sent(data)
                if sent == len(data):
                    return True
                if sent:
                    # the rest of a message is never dropped
                    self._cut, self._busy = data[sent:], True
                    self._cond_data_available.notify()
                    return True
            if self._queue_size > 0 and len(self._queue) == self._queue_size:
                del self._queue[0]
            self._queue.append(data)
            self._cond_data_available.notify()
        return True

    def _sent(self, data: bytes) -> int:
        """Return the number of bytes that were sent; the thread handles the errors of a connection."""
        transport = self._connection
        if not transport.socket or transport.done:
            return 0
        try:
            sent: int = transport.socket.send(data, socket.MSG_DONTWAIT)
        except OSError:
            return 0
        transport.stat_bytes += sent
        transport.stat_num_msg += sent == len(data)
        return sent

    def _run(self) -> None:
        while not self._connection.done:
            with self._lock:
                self._busy = bool(self._cut)
                while not (self._queue or self._cut or self._connection.done):
                    self._cond_data_available.wait()
                waiting = [self._cut, *self._queue] if self._cut else self._queue
                self._queue, self._cut, self._busy = [], b"", True
            for data in waiting:
                try:
                    self._connection.write_data(data)
                except Exception as error:  # noqa: BLE001 the next call that publishes raises it, as in rospy
                    with self._lock:
                        self._error = error


def send_directly() -> None:
    """Make every publisher of this process use this connection from now on."""
    rospy.topics.QueuedConnection = DirectConnection
