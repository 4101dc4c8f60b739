"""The open pages: each receives its news; a page that reads too slowly is disconnected and reconnects."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import Any

from pydantic_core import to_json

from end_effector_hal.errors import UsageError
from end_effector_hal.page.view import FaultsView, ToolView
from end_effector_hal.wires import now_us

from ._control import ControlLease, FaultCommands

MOST_PAGES = 12
PERIOD_S = 0.1
MOST_WAITING = 20
"""Largest number of queued messages for one page: two seconds."""


@dataclass(eq=False)
class Visitor:
    """One open page, with the counts of what it has received.

    Attributes:
        id: random id chosen by the page.
        name: name shown to the others.
    """

    id: str
    name: str
    waiting: asyncio.Queue[bytes | None] = field(default_factory=lambda: asyncio.Queue(MOST_WAITING))
    logged: int = 0
    sampled: int = 0
    changed: int = 0
    offered: int = 0


class Hub:
    """Computes the view ten times a second, once for all pages.

    Args:
        control: the lease of the page that commands.
        faults: the view of a testbench.
        fault_commands: holds the armed scenario.
    """

    def __init__(
        self, view: ToolView, control: ControlLease, faults: FaultsView, fault_commands: FaultCommands
    ) -> None:
        self._view, self._control, self._faults, self._fault_commands = view, control, faults, fault_commands
        self._visitors: list[Visitor] = []
        self._numbers: dict[str, int] = {}

    def name_of(self, page: str) -> str:
        """Return ``Page 2``: a page's name, constant while this process runs."""
        if len(self._numbers) > 1000:
            self._numbers.clear()
        return f"Page {self._numbers.setdefault(page, len(self._numbers) + 1)}"

    async def run(self) -> None:
        """Send views until cancelled."""
        while True:
            self._send(now_us())
            await asyncio.sleep(PERIOD_S)

    def enter(self, page: str) -> Visitor:
        """Add a page; raises UsageError if there are too many."""
        if len(self._visitors) >= MOST_PAGES:
            raise UsageError(f"{MOST_PAGES} pages are open already.", todo="Close one.")
        visitor = Visitor(page, self.name_of(page))
        self._visitors.append(visitor)
        return visitor

    async def events(self, visitor: Visitor) -> AsyncIterator[bytes]:
        """Yield the messages for one page, as server-sent events."""
        try:
            yield _event("drawn", {**self._view.drawn(), "page": visitor.id, "page_name": visitor.name})
            while (message := await visitor.waiting.get()) is not None:
                yield message
        finally:
            self._leave(visitor)

    def close(self) -> None:
        """Disconnect all pages."""
        for visitor in list(self._visitors):
            self._leave(visitor)

    def _leave(self, visitor: Visitor) -> None:
        if visitor in self._visitors:
            self._visitors.remove(visitor)
        while not visitor.waiting.empty():
            visitor.waiting.get_nowait()
        visitor.waiting.put_nowait(None)

    def _send(self, at: int) -> None:
        if not self._visitors:
            return
        view = {
            **self._view.now(at),
            "control": self._control.shown(at),
            "pages": len(self._visitors),
            "faults": self._faults.now(at),
            "armed": self._fault_commands.shown(at),
        }
        for visitor in list(self._visitors):
            try:
                visitor.waiting.put_nowait(_event("view", {**view, **self._news(visitor)}))
            except asyncio.QueueFull:
                self._leave(visitor)

    def _news(self, visitor: Visitor) -> dict[str, Any]:
        log, line = self._view.log, self._view.timeline
        news = {"log": log.since(visitor.logged), **line.since(visitor.sampled, visitor.changed)}
        if visitor.offered != self._faults.version:
            visitor.offered, news["offered"] = self._faults.version, self._faults.offered
        visitor.logged, visitor.sampled, visitor.changed = log.newest, line.sampled, line.changed
        return news


def _event(name: str, content: dict[str, Any]) -> bytes:
    return b"event: " + name.encode() + b"\ndata: " + to_json(content) + b"\n\n"
