"""The silence of the node Grip, as the nodes that act on its states observe it."""

from __future__ import annotations

from end_effector_hal.vocabulary import Alarm

from .interface import GONE_AFTER_S, GRIP


class Silence:
    """The time of the last report of Grip; while it has never reported, it is silent. Times in µs, monotonic."""

    def __init__(self) -> None:
        self._reported_us: int | None = None

    def reported(self, at_us: int) -> None:
        """Note that Grip has reported at ``at_us``."""
        self._reported_us = at_us

    @property
    def has_reported(self) -> bool:
        """Whether Grip has ever reported."""
        return self._reported_us is not None

    def lasts(self, now_us: int) -> bool:
        """Return whether Grip has not reported within the last second."""
        return self._reported_us is None or now_us - self._reported_us > GONE_AFTER_S * 1e6

    @property
    def alarm(self) -> Alarm:
        """The alarm about the silence."""
        return Alarm("node.silent" if self.has_reported else "node.awaited", GRIP)
