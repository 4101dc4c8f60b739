"""The successive line arbiters of a virtual tool: how each begins, ends or dies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from end_effector_hal.arbiter import PredicatePublisher, arbiter_policy
from end_effector_hal.description import Description
from end_effector_hal.wires.lines import ComposedLines

from ._arbiter import Memories, VirtualArbiter
from ._buses import VirtualBuses
from ._outputs import VirtualOutputs

if TYPE_CHECKING:
    from ._bus import VirtualBus


class ArbiterLives:
    """Manages the line arbiters; at most one lives at a time, and the next one reads the records of the previous one.

    Args:
        description: the description of the tool.
        outputs: its lines.
        buses: the buses whose master the arbiter is.
        clock: returns the time, µs.
        reads: whether the arbiter reads inputs of its own.

    Attributes:
        now: the living arbiter; None: there is none.
        begun: number of arbiters started so far.
        memories: the stores that outlive an arbiter.
        publisher: publishes the predicates of its own inputs; None: it reads none.
    """

    def __init__(
        self,
        description: Description,
        outputs: VirtualOutputs,
        buses: VirtualBuses,
        clock: Callable[[], int],
        *,
        reads: bool,
    ) -> None:
        self._description, self._outputs, self._buses, self._clock = description, outputs, buses, clock
        self._policy, self._reads = arbiter_policy(description), reads
        self.memories = Memories()
        self.now: VirtualArbiter | None = None
        self.begun = 0
        self.publisher: PredicatePublisher | None = None
        self._starts = False
        self._opened: Mapping[str, VirtualBus] | None = None  # by one that starts

    def start(self) -> None:
        """Start an arbiter if none lives, or after the ending one has ended."""
        if self.now is None or self.now.ends:
            self._starts = True
            if self.now is None:
                self._begin()

    def end(self) -> None:
        """Ask the arbiter to end properly when it has nothing left to wait for; a second call ends it at once."""
        if self.now is None:
            return
        if self.now.ends:
            self._close(self.now)
        else:
            self.now.end()
            self.look()

    def look(self) -> None:
        """Close the arbiter if it was asked to end and is over."""
        if self.now is not None and self.now.is_over:
            self._close(self.now)

    def kill(self) -> None:
        """Kill the arbiter, or cancel its start."""
        self.now = self.publisher = self._opened = None
        self._starts = False
        self._buses.kill()

    def lose_power(self) -> None:
        """Kill the arbiter and cut the power of its buses; data that was not synced to the disk is lost."""
        self.kill()
        self._buses.lose_power()
        self.memories.lose_power(f"boot {self._clock()}")
        self._outputs.set(dict.fromkeys(self._outputs.levels(), False))

    def heard(self) -> None:
        """Process news from a bus: a living arbiter reacts, a starting one may begin."""
        if self.now is None:
            self._buses.forget_ended()
            if self._starts:
                self._begin()
        elif self._buses.news:
            self.now.step()

    def sender(self, *, own: bool) -> ToArbiter:
        """Return a sender of predicates to the living arbiter; ``own``: they come from its own inputs."""
        return ToArbiter(self, own=own)

    def _begin(self) -> None:
        """Begin as soon as the ports of the buses are free and their devices have reported their state."""
        if self._opened is None:
            if self._buses.masters:
                return
            self._opened = self._buses.open()
        if not self._buses.adopted:
            return
        lines = ComposedLines(self._outputs, self._opened) if self._opened else self._outputs
        self._starts, self._opened = False, None
        self.now = VirtualArbiter(lines, self._policy, self.memories, self._clock)
        self.begun += 1
        if self._reads:
            self.publisher = PredicatePublisher(
                self._description, clock=self._clock, sender=self.sender(own=True)
            )

    def _close(self, arbiter: VirtualArbiter) -> None:
        arbiter.close()
        self.now = self.publisher = None
        self._buses.end()
        if self._starts:
            self._begin()


class ToArbiter:
    """Sends predicates to the living arbiter."""

    def __init__(self, lives: ArbiterLives, *, own: bool) -> None:
        self._lives, self._own = lives, own

    def send(self, predicates: Mapping[str, bool], at_us: int) -> bool:
        """Return whether the predicates were delivered."""
        arbiter = self._lives.now
        if arbiter is None:
            return False
        (arbiter.read if self._own else arbiter.told)(predicates, at_us)
        return True

    def close(self) -> None:
        """Do nothing, since nothing is open."""
