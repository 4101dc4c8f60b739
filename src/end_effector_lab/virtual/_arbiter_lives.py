"""One line arbiter of a virtual tool after the other: how each begins, ends or dies."""

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
    """At most one lives at a time; the next one finds what the one before has left.

    Args:
        description: of the tool.
        outputs: its lines.
        buses: whose master the arbiter is.
        clock: µs.
        reads: whether it reads inputs of its own.

    Attributes:
        now: the one that lives; None: there is none.
        begun: how many have begun so far.
        memories: what outlives an arbiter.
        publisher: of what its own inputs prove; None: it reads none.
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
        """Start one where none lives, or once the one that ends has ended."""
        if self.now is None or self.now.ends:
            self._starts = True
            if self.now is None:
                self._begin()

    def end(self) -> None:
        """Ask it to end in good order: once it waits for nothing any more; asked once more, at once."""
        if self.now is None:
            return
        if self.now.ends:
            self._close(self.now)
        else:
            self.now.end()
            self.look()

    def look(self) -> None:
        """Whether one that was asked to end is over now."""
        if self.now is not None and self.now.is_over:
            self._close(self.now)

    def kill(self) -> None:
        """It dies now, or ceases to start."""
        self.now = self.publisher = self._opened = None
        self._starts = False
        self._buses.kill()

    def lose_power(self) -> None:
        """As `kill`; so do the devices on the buses, and what the disk has not taken is lost."""
        self.kill()
        self._buses.lose_power()
        self.memories.lose_power(f"boot {self._clock()}")
        self._outputs.set(dict.fromkeys(self._outputs.levels(), False))

    def heard(self) -> None:
        """The master of a bus has heard something: one that lives does what follows, one that starts may begin."""
        if self.now is None:
            self._buses.forget_ended()
            if self._starts:
                self._begin()
        elif self._buses.news:
            self.now.step()

    def sender(self, *, own: bool) -> ToArbiter:
        """Takes what is proven to the one that lives; ``own``: by its own inputs."""
        return ToArbiter(self, own=own)

    def _begin(self) -> None:
        """As soon as the ports of its buses are free, and what hangs on them has reported how it stands."""
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
    """Takes what is proven to the arbiter that lives."""

    def __init__(self, lives: ArbiterLives, *, own: bool) -> None:
        self._lives, self._own = lives, own

    def send(self, predicates: Mapping[str, bool], at_us: int) -> bool:
        """Whether it got there."""
        arbiter = self._lives.now
        if arbiter is None:
            return False
        (arbiter.read if self._own else arbiter.told)(predicates, at_us)
        return True

    def close(self) -> None:
        """Nothing is open."""
