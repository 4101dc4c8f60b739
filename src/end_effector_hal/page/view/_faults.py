"""The testbench as the page shows it: its presence, the active faults, and the available faults."""

from __future__ import annotations

from typing import Any

from pydantic_core import to_jsonable_python

from end_effector_hal.description import Description, content_hash
from end_effector_hal.errors import ReportedError
from end_effector_hal.faults import FaultOffer, TestbenchHeader

from ._log import EventLog

SILENT_US = 1_000_000
"""Time after which a testbench counts as silent, µs; with the page's period, the page shows it within 1.2 s."""


class FaultsView:
    """The state of a testbench; does no I/O, times in µs. Without a testbench it shows nothing.

    Args:
        description: the tool; the testbench must simulate the same one.
        log: receives changes.

    Attributes:
        there: whether a testbench is connected.
        version: counter that is increased when the offered faults change.
    """

    def __init__(self, description: Description, log: EventLog) -> None:
        self._hash, self._log = content_hash(description), log
        self.there, self.version = False, 0
        self._scenario = self._why = ""
        self._faults: tuple[FaultOffer, ...] = ()
        self._heard_at = 0

    def begin(self, header: TestbenchHeader, now: int) -> None:
        """Process the header of a testbench; raises ReportedError if it simulates another tool."""
        if header.hash != self._hash:
            what = f"The testbench simulates another description ({header.tool}, {header.hash})"
            todo = "Start the testbench, or the page, with the description of the other."
            raise ReportedError(f"{what} than that of this page ({self._hash}).", todo=todo)
        self._faults, self._heard_at, self._scenario, self._why = header.faults, now, "", ""
        self.version += 1
        what = "A testbench is at the other end of the wires: nothing real moves."
        played = [f"{each[:1].upper()}{each[1:]}." for each in header.units]
        self._log.add(now, "page", " ".join([what, *played]))

    def scenario(self, text: str, now: int) -> None:
        """Set the active faults; this message is also a sign of life."""
        self.there, self._heard_at = bool(self._faults), now
        if text != self._scenario:
            self._scenario = text
            self._log.add(now, "page", f"The testbench plays: {text}.")

    def lose(self, why: str, now: int) -> None:
        """Mark the testbench as gone, or as absent (``why`` is empty)."""
        if self.there or (why and why != self._why):
            self._log.add(now, "page", why or "The testbench has gone.")
        self.there, self._why, self._faults = False, why, ()

    @property
    def offered(self) -> list[Any]:
        """The faults that the tool can have."""
        found: list[Any] = to_jsonable_python(self._faults)
        return found

    def now(self, at: int) -> dict[str, Any] | None:
        """Return the live view; None if there is no testbench."""
        if not self.there:
            return None
        return {"scenario": self._scenario, "silent": at - self._heard_at > SILENT_US}
