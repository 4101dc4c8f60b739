"""The successive line arbiters of a virtual tool: how each begins, ends or dies, with its masters of the buses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from end_effector_hal.arbiter import PredicatePublisher, arbiter_policy
from end_effector_hal.description import Description
from end_effector_hal.wires.lines import ComposedLines
from end_effector_lab.testbench import SensorBoard

from ._arbiter import Memories, VirtualArbiter, VirtualOutputs

if TYPE_CHECKING:
    from ._bus import VirtualBus


class ArbiterLives:
    """Manages the line arbiters; at most one lives at a time, and the next one reads the records of the previous one.

    Args:
        description: the description of the tool.
        outputs: its lines.
        boards: all units of each commanded bus, by its link; they outlive the arbiter.
        obey: called with the name and level of an output of a bus.
        clock: returns the time, µs.
        reads: whether the arbiter reads inputs of its own.

    Attributes:
        now: the living arbiter; None: there is none.
        begun: number of arbiters started so far.
        memories: the stores that outlive an arbiter.
        masters: the masters of the buses, of the living, starting or ending arbiter.
        publisher: publishes the predicates of its own inputs; None: it reads none.
    """

    def __init__(
        self,
        description: Description,
        outputs: VirtualOutputs,
        boards: Mapping[str, SensorBoard],
        obey: Callable[[str, bool], None],
        clock: Callable[[], int],
        *,
        reads: bool,
    ) -> None:
        self._description, self._outputs, self._obey, self._clock = description, outputs, obey, clock
        self._policy, self._reads, self._boards = arbiter_policy(description), reads, boards
        self.memories = Memories()
        self.now: VirtualArbiter | None = None
        self.begun = 0
        self.masters: list[VirtualBus] = []
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
        """Kill the arbiter, or cancel its start; no request reaches the buses any more."""
        self.now = self.publisher = self._opened = None
        self._starts, self.masters = False, []

    def lose_power(self) -> None:
        """Kill the arbiter and cut the power of its buses; data that was not synced to the disk is lost.

        No output is active any more, except those that their devices keep without power.
        """
        self.kill()
        kept = {each.line for _, each in self._description.ordered if each.on_power_loss in ("hold", "keep")}
        for name, board in self._boards.items():
            board.lose_power(self._clock())
            for output in self._description.buses[name].keys() - kept:
                self._obey(output, False)
        self.memories.lose_power(f"boot {self._clock()}")
        self._outputs.set(dict.fromkeys(self._outputs.levels(), False))

    def heard(self) -> None:
        """Process news from a bus: a living arbiter reacts, a starting one may begin."""
        if self.now is None:
            self._forget_ended()
            if self._starts:
                self._begin()
        elif any(each.news for each in self.masters):
            self.now.step()

    def sender(self, *, own: bool) -> ToArbiter:
        """Return a sender of predicates to the living arbiter; ``own``: they come from its own inputs."""
        return ToArbiter(self, own=own)

    def _begin(self) -> None:
        """Begin as soon as the ports of the buses are free and their devices have reported their state."""
        if self._opened is None:
            if self.masters:
                return
            self._opened = self._open()
        if not all(each.adopted for each in self.masters):
            return
        lines = ComposedLines(self._outputs, self._opened) if self._opened else self._outputs
        self._starts, self._opened = False, None
        self.now = VirtualArbiter(lines, self._policy, self.memories, self._clock)
        self.begun += 1
        if self._reads:
            self.publisher = PredicatePublisher(
                self._description, clock=self._clock, sender=self.sender(own=True)
            )

    def _open(self) -> dict[str, VirtualBus]:
        """Open the ports for a new arbiter; return the bus of each output."""
        if not self._boards:
            return {}
        from ._bus import VirtualBus  # with pymodbus

        found: dict[str, VirtualBus] = {}
        for name, board in self._boards.items():
            master = VirtualBus(self._description, name, board, self._clock)
            self.masters.append(master)
            found |= dict.fromkeys(self._description.buses[name], master)
        return found

    def _close(self, arbiter: VirtualArbiter) -> None:
        arbiter.close()
        self.now = self.publisher = None
        for each in self.masters:
            each.end()
        self._forget_ended()
        if self._starts:
            self._begin()

    def _forget_ended(self) -> None:
        """Remove the masters that have released their port."""
        self.masters = [each for each in self.masters if not each.over]


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
