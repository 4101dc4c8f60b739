"""A copy of the HAL's controller, which receives the same inputs and so reaches the same state."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from end_effector_hal.control import Controller, Status, unknown_now
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.runtime.boundary import INPUTS, STATE, Header, Published, feed
from end_effector_hal.runtime.stream import MAINTENANCE_WORDS, PUBLISHED
from timed_automata import Network


class Replica:
    """Follows the HAL by its records; it decides nothing and queries the same automata.

    Args:
        network: its automata.
        content: the hash of the description, as in headers.

    Attributes:
        connected: whether its stream is connected.
        why: why nothing is shown of it, a sentence; empty if it is shown.
        heard_at: time of the last sign of life, µs.
    """

    def __init__(self, description: Description, network: Network, content: str) -> None:
        self._description, self._network, self._content = description, network, content
        self.connected, self.why, self.heard_at = False, "Nothing was received from the HAL yet.", 0
        self.controller: Controller | None = None
        self.published: Published | None = None

    @property
    def status(self) -> Status | None:
        """The published status, or what is still known of it after a loss; None before the first."""
        return self.published.status if self.published else None

    def take(self, kind: str, record: Any) -> None:
        """Process one record.

        Raises:
            ReportedError: the record does not fit the ones before it, and a new state is needed.
        """
        if kind == "header":
            self._begin(record)
        elif kind == STATE:
            self.controller = self._new()
            self.controller.resume(record)
        elif kind == "start":
            self.controller = self._new()
            feed(self.controller, kind, record)
        elif kind in INPUTS and self.controller is not None:
            feed(self.controller, kind, record)
        elif kind == PUBLISHED:
            self.published = record

    def lose(self, why: str) -> None:
        """Mark the stream as lost."""
        self.connected, self.why = False, why
        if self.published is not None:
            self.published = replace(self.published, status=unknown_now(self.published.status))

    def refusal(self, word: str, part: str = "") -> str:
        """Return why the HAL would refuse a command now; empty if it would accept it; ``part``: what to grip."""
        if not self.connected:
            return self.why
        if self.published is None or self.controller is None:
            return "The HAL has not sent its state yet."
        if refused := self.published.refused.get(word):
            return refused
        if word in MAINTENANCE_WORDS:
            return self.controller.refuse_maintenance(active=word == "activate")
        return self.controller.refusal(word, part)

    def _begin(self, header: Header) -> None:
        if header.hash != self._content:
            what = f"The HAL runs another description ({header.source}, {header.hash})"
            raise ReportedError(
                f"{what} than this page ({self._content}).", todo=f"Start: eehal page {header.source}"
            )
        self.connected, self.why, self.controller, self.published = True, "", None, None

    def _new(self) -> Controller:
        return Controller(self._description, self._network)
