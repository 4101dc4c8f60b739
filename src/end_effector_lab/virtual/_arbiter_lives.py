"""The successive line arbiters of a virtual tool, how each begins, ends or dies, and the commanded buses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from end_effector_hal.arbiter import PredicatePublisher, arbiter_policy
from end_effector_hal.description import Description
from end_effector_hal.wires.lines import ComposedLines
from end_effector_lab.testbench import Bench, Models, SensorBoard

from ._arbiter import Memories, VirtualArbiter
from ._outputs import VirtualOutputs

if TYPE_CHECKING:
    from ._bus import VirtualBus


class VirtualBuses:
    """All commanded buses of a tool.

    Args:
        description: the description of the tool.
        bench: provides the measured values.
        obey: called with the name and level of a commanded output.
        clock: returns the time, µs.
        active: outputs that are active at the start.
        models: units that have a model.
    """

    def __init__(
        self,
        description: Description,
        bench: Bench,
        obey: Callable[[str, bool], None],
        clock: Callable[[], int],
        active: Mapping[str, bool],
        models: Models,
    ) -> None:
        self._description, self._clock, self._obey = description, clock, obey
        self.devices = {
            name: SensorBoard.on_bus(description, name, bench, 0, obey, models) for name in description.buses
        }
        """All units of each bus, by their links; they outlive the arbiter."""
        for each in self.devices.values():
            each.begin(active, clock())
        self.masters: list[VirtualBus] = []
        """Bus masters of the living, starting or ending arbiter."""

    def open(self) -> dict[str, VirtualBus]:
        """Open the ports for a new arbiter; return the bus of each output."""
        if not self.devices:
            return {}
        from ._bus import VirtualBus  # with pymodbus

        found: dict[str, VirtualBus] = {}
        for name, devices in self.devices.items():
            master = VirtualBus(self._description, name, devices, self._clock)
            self.masters.append(master)
            found |= dict.fromkeys(self._description.buses[name], master)
        return found

    @property
    def adopted(self) -> bool:
        """Whether an arbiter no longer waits for the devices' reports."""
        return all(each.adopted for each in self.masters)

    @property
    def news(self) -> bool:
        """Whether a device has changed since the last query."""
        return any(each.news for each in self.masters)

    def end(self) -> None:
        """Begin the proper end of the arbiter."""
        for each in self.masters:
            each.end()
        self.forget_ended()

    def forget_ended(self) -> None:
        """Remove the masters that have released their port."""
        self.masters = [each for each in self.masters if not each.over]

    def kill(self) -> None:
        """Remove all masters, since the arbiter dies; no request reaches the devices any more."""
        self.masters = []

    def lose_power(self) -> None:
        """Cut the power of the devices as well: no output is active any more but those that keep without power."""
        self.kill()
        kept = {each.line for _, each in self._description.ordered if each.on_power_loss in ("hold", "keep")}
        for name, board in self.devices.items():
            board.lose_power(self._clock())
            for output in self._description.buses[name].keys() - kept:
                self._obey(output, False)


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
