"""What the line owner enforces: plain data, given by whoever knows the tool."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from end_effector_hal.errors import UsageError


class Exclusion(NamedTuple):
    """Two lines that are never both active; the interlock that refuses each while the other is active."""

    line_a: str
    line_b: str
    id_a: str = "IL-01"
    id_b: str = "IL-05"


@dataclass(frozen=True)
class Policy:
    """The lines of an owner and the interlocks on them (section 6 of the contract).

    Attributes:
        lines: all output lines, claimed at once.
        exclusions: pairs such as (unlock, vacuum); an `Exclusion` names its interlocks.
        max_active_us: a line that is active for so long is made inactive (IL-03).
        min_switch_us: a line stays as it is for at least so long; a write waits (IL-10).
        lease_us: a client that is not heard of for so long is dead.
        labels: what the lines drive, for the sentences.
    """

    lines: Sequence[str]
    exclusions: Sequence[tuple[str, str] | Exclusion] = ()
    max_active_us: Mapping[str, int] = field(default_factory=dict)
    min_switch_us: int = 50_000
    lease_us: int = 1_000_000
    labels: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        used = [line for pair in self.exclusions for line in pair[:2]] + list(self.max_active_us)
        unknown = sorted(set(used) - set(self.lines))
        if unknown or len(set(self.lines)) < len(self.lines):
            raise UsageError(
                f"the policy of the line owner is wrong: lines {list(self.lines)}, unknown: {unknown}.",
                todo="Name each line once, and in the interlocks only lines that it has.",
            )

    def partners(self, line: str) -> list[tuple[str, str]]:
        """The lines that must be inactive for this one to be activated, each with the interlock's id."""
        pairs = [Exclusion(*pair) for pair in self.exclusions]
        return [(p.line_b, p.id_a) for p in pairs if p.line_a == line] + [
            (p.line_a, p.id_b) for p in pairs if p.line_b == line
        ]

    def called(self, line: str) -> str:
        """The line, for a sentence."""
        return f"{line} ({self.labels[line]})" if line in self.labels else line
