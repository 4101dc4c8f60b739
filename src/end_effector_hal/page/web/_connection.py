"""One connection of a client of the page: who is silent, or does not read, keeps nobody else out."""

from __future__ import annotations

import asyncio
from typing import cast

from uvicorn.protocols.http.h11_impl import H11Protocol

MOST_CONNECTIONS = 64
LOOK_S = 1.0
REQUEST_S = 10.0
"""For a whole request."""
STALL_S = 30.0
"""For a client that takes nothing of its answer; longer, for the kernel takes megabytes at once."""


class BoundedConnection(H11Protocol):
    """The protocol of uvicorn, which has a time-out between two requests and none within one.

    Rule 1: A request that has not come whole in time, from the connection or from the answer before on, ends its
        connection, whatever comes of it piece by piece.
    Rule 2: A client that reads nothing for so long is dropped; one that reads slowly is not.
    Rule 3: Where there are too many, the oldest connection without a request to be answered makes room.
    """

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """A client comes."""
        super().connection_made(transport)
        self._begun = self._moved = self.loop.time()
        self._unsent = 0
        self._timer = self.loop.call_later(LOOK_S, self._look)
        self._make_room()

    def connection_lost(self, exc: Exception | None) -> None:
        """It has gone."""
        self._timer.cancel()
        super().connection_lost(exc)

    def on_response_complete(self) -> None:
        """The next request may come."""
        self._moved = self.loop.time()
        super().on_response_complete()

    def send_400_response(self, msg: str) -> None:
        """What came is no request; in the middle of one its answer has begun, and nothing can be said any more."""
        if self.cycle is None or self.cycle.response_complete:
            super().send_400_response(msg)
            return
        self.cycle.disconnected = True
        self.cycle.message_event.set()
        self.transport.abort()

    @property
    def _answering(self) -> bool:
        cycle = self.cycle
        return cycle is not None and not cycle.more_body and not cycle.response_complete

    def _look(self) -> None:
        now, unsent = self.loop.time(), self.transport.get_write_buffer_size()
        if unsent < self._unsent or (self._answering and not unsent):
            self._moved = now
        self._unsent = unsent
        if now - self._moved > (STALL_S if unsent else REQUEST_S):
            self.transport.abort()
            return
        self._timer = self.loop.call_later(LOOK_S, self._look)

    def _make_room(self) -> None:
        every = [cast(BoundedConnection, each) for each in self.connections]
        there = [each for each in every if not each.transport.is_closing()]
        if len(there) > MOST_CONNECTIONS:
            waiting = [each for each in there if not each._answering and each is not self]
            min(waiting, key=lambda each: each._begun, default=self).transport.abort()
