"""The rules that the line arbiter enforces: plain data, made from the description of the tool."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from end_effector_hal.arbiter.rules._coils import SecondCoil
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import LEASE_US, SETTLE_US


class Exclusion(NamedTuple):
    """Two lines that are never active together, with the interlocks that refuse one line while the other is active."""

    line_a: str
    line_b: str
    id_a: str = "IL-01"
    id_b: str = "IL-05"
    gap_us: int = 0
    """Shortest time between the end of one activation and the start of the other, µs (IL-08)."""


class Role(NamedTuple):
    """The device that a line drives.

    Attributes:
        words: description for messages; different roles have different words.
        stays: whether the device keeps its position without this machine (two coils, an output on a bus).
    """

    words: str
    stays: bool = False


class Partner(NamedTuple):
    """The other line of an exclusion."""

    line: str
    interlock: str
    gap_us: int


class Need(NamedTuple):
    """A predicate that the sensors must prove, and that must be fresh, before a line may be activated.

    Attributes:
        predicate: its name in a message.
        interlock: the interlock that refuses the activation without it.
        means: words for a message: "the tool is locked".
        otherwise: words for the case that it does not hold: "the tool is not proven to be locked".
        latched: reason for a latched refusal: once the predicate did not hold, nothing is activated until a reset
            (IL-13), for example "the emergency stop was opened"; empty: nothing is latched.
    """

    predicate: str
    interlock: str
    means: str
    otherwise: str
    latched: str = ""


@dataclass(frozen=True)
class Policy:
    """The lines of an arbiter and their interlocks.

    Attributes:
        lines: all output lines, claimed together.
        exclusions: pairs such as (unlock, vacuum); an `Exclusion` names its interlocks.
        max_active_us: longest time for which a line may be active; then it is deactivated (IL-03, blow-offs: IL-08).
        min_switch_us: shortest time between two changes of a line; an earlier write waits (IL-10).
        needs: by line, the predicates that the sensors must prove before it is activated (IL-01, IL-05, IL-13).
        fresh_us: how long a proof of the sensors is valid.
        lease_us: a client that does not renew its lease for this time counts as dead.
        longest_last_will_us: latest time after the death for a step of a last will.
        faults: the faults that clients may latch. By name, the client that shows the fault, and whose reset ends it.
        labels: by line, the device that it drives, for messages.
        roles: by line, its role, for the next arbiter, which may be started with another description.
        opposites: by line of an output, its second coil; no client writes these coils.
        release_us: by line of an output on a bus, how long its release takes, µs.
        registers: number of values that make an output grip, by line, where a client may choose them.
        proven: predicates that the arbiter proves from lines that it reads itself; reports of other processes are
            refused.
    """

    lines: Sequence[str]
    exclusions: Sequence[tuple[str, str] | Exclusion] = ()
    max_active_us: Mapping[str, int] = field(default_factory=dict)
    min_switch_us: int = SETTLE_US
    needs: Mapping[str, Sequence[Need]] = field(default_factory=dict)
    fresh_us: int = 150_000
    lease_us: int = LEASE_US
    longest_last_will_us: int = 10_000_000
    faults: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)
    roles: Mapping[str, Role] = field(default_factory=dict)
    opposites: Mapping[str, SecondCoil] = field(default_factory=dict)
    release_us: Mapping[str, int] = field(default_factory=dict)
    registers: Mapping[str, int] = field(default_factory=dict)
    proven: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        used = [line for pair in self.exclusions for line in pair[:2]] + [
            *self.max_active_us,
            *self.needs,
            *self.opposites,
            *self.registers,
        ]
        unknown = sorted(set(used) - set(self.lines))
        wires = [*self.lines, *(each.line for each in self.opposites.values())]
        if unknown or len(set(wires)) < len(wires):
            raise UsageError(
                f"the policy of the line arbiter is wrong: lines {list(self.lines)}, unknown: {unknown}.",
                todo="Name each line once, and in the interlocks only lines that it has.",
            )

    def settle_us(self, line: str) -> int:
        """Return how long a line stays unchanged after a change (IL-10), µs; at least until the end of a pulse's
        pause.
        """
        coil = self.opposites.get(line)
        paused = coil.pulse_us + coil.pause_us if coil and coil.pause_us else 0
        return max(self.min_switch_us, paused)

    def partners(self, line: str) -> list[Partner]:
        """Return the lines that must be inactive before this line may be activated."""
        pairs = [Exclusion(*pair) for pair in self.exclusions]
        return [Partner(p.line_b, p.id_a, p.gap_us) for p in pairs if p.line_a == line] + [
            Partner(p.line_a, p.id_b, p.gap_us) for p in pairs if p.line_b == line
        ]

    def bounded_by(self, line: str) -> str:
        """Return the interlock that ends the activation of a line after its longest time."""
        return "IL-08" if any(partner.interlock == "IL-08" for partner in self.partners(line)) else "IL-03"

    def called(self, line: str) -> str:
        """Return the line with its label, for messages."""
        return f"{line} ({self.labels[line]})" if line in self.labels else line
