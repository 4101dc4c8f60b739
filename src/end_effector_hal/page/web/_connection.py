"""One connection of a client; a client that is silent or does not read blocks no others."""

from __future__ import annotations

import asyncio
from typing import cast

from uvicorn.protocols.http.h11_impl import H11Protocol

MOST_CONNECTIONS = 64
LOOK_S = 1.0
REQUEST_S = 10.0
"""Time limit for a whole request."""
STALL_S = 30.0
"""Time limit for a client that reads nothing of its answer; longer, since the kernel buffers megabytes at once."""


class BoundedConnection(H11Protocol):
    """Extends uvicorn's protocol, which has a time-out between two requests but none within a request.

    Rule 1: A request must be complete in time, counted from the connection or from the answer before; otherwise its
        connection is closed, even if it arrives piece by piece.
    Rule 2: A client that reads nothing for that time is disconnected; a slow reader is not.
    Rule 3: If there are too many connections, the oldest one without a request being answered is closed.
    """

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Handle a new client."""
        super().connection_made(transport)
        self._begun = self._moved = self.loop.time()
        self._unsent = 0
        self._timer = self.loop.call_later(LOOK_S, self._look)
        self._make_room()

    def connection_lost(self, exc: Exception | None) -> None:
        """Handle the end of the connection."""
        self._timer.cancel()
        super().connection_lost(exc)

    def on_response_complete(self) -> None:
        """Prepare for the next request."""
        self._moved = self.loop.time()
        super().on_response_complete()

    def send_400_response(self, msg: str) -> None:
        """Refuse malformed data; close the connection if an answer has already begun."""
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
