"""What the demo plays: what goes wrong at the testbench, what is commanded, and the story to be told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import Command, EndEffectorState


@dataclass(frozen=True)
class Order:
    """One command to the end-effector, then a wait.

    ``wait_s``: seconds before the next order; ``background``: counted from the command, not from its outcome;
    ``arm``: an unlock that is armed first (IL-02).
    """

    command: Command
    wait_s: float = 0.0
    background: bool = False
    arm: bool = False


@dataclass(frozen=True)
class Expected:
    """The story, in the terms of a recording.

    Args:
        states: of the end-effector, from STAND_BY on, without repetitions.
        commands: what the command column shows, without NONE and repetitions.
        attempts: how many each actuator takes; what is missing is never activated.
        timeouts: how many of them time out.
        slow_release: the actuator whose feedback stays for its whole release time.
    """

    states: tuple[EndEffectorState, ...]
    commands: tuple[Command, ...]
    attempts: Mapping[str, int] = field(default_factory=dict)
    timeouts: Mapping[str, int] = field(default_factory=dict)
    slow_release: str | None = None


@dataclass(frozen=True)
class DemoScenario:
    """``bench`` is the scenario as ``eehal testbench`` takes it; ``figure`` that of the paper, if any."""

    name: str
    title: str
    bench: str
    orders: tuple[Order, ...]
    expected: Expected
    figure: str = ""
    rest_s: float = 0.5
    """What the recording shows before the first order."""

    @property
    def script(self) -> str:
        """The orders as the Supervisor takes them."""
        steps = [f"wait {self.rest_s:g}"]
        for order in self.orders:
            steps += ["arm"] if order.arm else []
            steps.append(order.command.name.lower() + (" &" if order.background else ""))
            steps += [f"wait {order.wait_s:g}"] if order.wait_s else []
        return "; ".join([*steps, "quit"])

    def longest_s(self, description: Description) -> float:
        """How long it may take at most: the waits, and the bounds that the description requires."""
        bounds = description.bounds
        waits = self.rest_s + sum(order.wait_s for order in self.orders)
        return waits + bounds.grip_s + bounds.release_s + bounds.cancel_s
