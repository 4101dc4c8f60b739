"""Time of the simulated world: whole steps of one millisecond."""

from __future__ import annotations

from abc import ABC, abstractmethod

STEP_US = 1000
STEP_S = STEP_US / 1e6


class Model(ABC):
    """Something physical that goes on in time, in fixed steps from its start.

    The steps lie on one grid whatever the calls are, so a model asked every 7 ms and one asked once a second
    tell the same story.

    Args:
        start: µs, the time of the initial state.
    """

    def __init__(self, start: int = 0) -> None:
        self.now = start

    @property
    @abstractmethod
    def settled(self) -> bool:
        """Whether a step would change nothing, so that any number of them can be left out."""

    @abstractmethod
    def step(self) -> None:
        """Go from ``now`` to one step later; ``now`` itself is moved by the caller."""

    def advance(self, at: int) -> None:
        """Go to the last grid point at or before ``at`` (µs); a time in the past changes nothing."""
        steps = (at - self.now) // STEP_US
        while steps > 0:
            if self.settled:
                self.now += steps * STEP_US
                return
            self.step()
            self.now += STEP_US
            steps -= 1
