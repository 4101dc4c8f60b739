"""The cells of the matrix, and their possible outcomes.

There is a cell for every fault, at every place, at every moment, with every command.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import count, islice
from math import ceil, gcd, sqrt

from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_lab.testbench import offered_faults, plain_number

from ._script import Moment

GOLDEN = (1 + sqrt(5)) / 2
NO_FAULT, NOTHING, BOTH = "nominal", "none", "kill both"
COMMANDS = (NOTHING, "cancel", "drop", "lock", "unlock", "kill hal", "kill arbiter", BOTH)
"""Commands of the cells. `hal` is the program with the sensor reader; a killed process is restarted a second later."""
AT_ONCE = ", at once"
"""Suffix of a kill: the process is restarted at the same instant."""
WORDS = (*COMMANDS, *(f"{command}{AT_ONCE}" for command in COMMANDS if command.startswith("kill")))
"""Possible texts after the moment in the id of a cell."""


@dataclass(frozen=True)
class Cell:
    """One fault, from one moment on, and a command at the same instant.

    Attributes:
        fault: in the words of the testbench.
        moment: the time of both.
        command: one of `COMMANDS`.
        at_once: whether a killed process is restarted at once, not a second later.
    """

    fault: str
    moment: Moment
    command: str
    at_once: bool = False

    @property
    def id(self) -> str:
        """The name of the cell within the matrix of its tool."""
        return f"{self.fault} @ {self.moment.name} + {self.words}"

    @property
    def words(self) -> str:
        """The command, one of `WORDS`."""
        return f"{self.command}{AT_ONCE if self.at_once else ''}"

    @property
    def name(self) -> str:
        """The name of the fault alone."""
        return self.fault.partition(":")[0]

    @property
    def place(self) -> str:
        """The faulty part; empty: the whole tool."""
        parts = self.fault.split(":")
        return parts[1] if len(parts) > 1 and parts[1][:1].isalpha() else ""

    @property
    def number(self) -> float | None:
        """The number of the fault; None if it has none."""
        return plain_number(self.fault.split(":")[-1])


class Outcome(StrEnum):
    """The state of the tool when all movements have ended."""

    AT_REST = "at rest"
    """At rest: no command was begun."""
    REFUSED = "refused"
    """At rest: the last command was refused with a reason."""
    SUCCESS = "gripped"
    FAILED = "declared failure"
    """At rest: the grip failed and was unwound."""
    CANCELLED = "cancelled"
    RELEASED = "dropped on command"
    UNWOUND = "unwound by the last will"
    HELD = "held with alarm"
    """GRIP_ERROR, latched: every output stays."""
    STILL_THERE = "release error"
    """RELEASE_ERROR, latched: not every actuator is proven to be gone."""
    UNFINISHED = "not at rest in its time"


def faults_of(description: Description) -> tuple[str, ...]:
    """Return every fault that the tool can have, at each of its places, with the numbers of `_numbers`."""
    found: list[str] = []
    for offer in offered_faults(description):
        places = [*([""] if offer.anywhere else []), *offer.places]
        for place in places:
            numbers = _numbers(description, offer.name, place)
            found += [":".join(filter(None, (offer.name, place, number))) for number in numbers]
    return tuple(dict.fromkeys(found))


def cells_of(description: Description, when: Sequence[Moment]) -> Iterator[Cell]:
    """Yield all cells in a fixed order; immediate restarts come last, without another fault."""
    for fault in faults_of(description):
        for moment in when:
            for command in COMMANDS:
                yield Cell(fault, moment, command)
    for moment in when:
        for command in COMMANDS:
            if command.startswith("kill"):
                yield Cell(NO_FAULT, moment, command, at_once=True)


def thinned(cells: Sequence[Cell], every: int) -> list[Cell]:
    """Return one cell of every ``every``, spread evenly over faults, moments and commands, in the order of the matrix.

    A plain stride has factors in common with the number of commands and would meet few of them. The step of the golden
    ratio, coprime to the number of cells, rounded up to whole rows of commands, meets each of them once in as many
    cells as there are commands (Kronecker's sequence).
    """
    total = len(cells) + -len(cells) % (len({cell.command for cell in cells}) or 1)
    step = next(step for step in count(round(total / GOLDEN) or 1) if gcd(step, total) == 1)
    spread = (at for number in range(total) if (at := number * step % total) < len(cells))
    return [cells[at] for at in sorted(islice(spread, ceil(len(cells) / every)))]


def _numbers(description: Description, fault: str, place: str) -> tuple[str, ...]:
    """Return representative numbers: a value on each side of the description's limit."""
    part = description.actuators.get(place)
    match fault:
        case "fails":
            attempts = part.attempts if part else 3
            return (str(attempts - 1), str(attempts)) if attempts > 1 else (str(attempts),)
        case "leak":
            return ("4", "40")
        case "leak-grows":
            return ("2",)
        case "lost-after":
            return ("0.1", "1")
        case "shows":
            limits = kind_of(part).limits(part, description.supply) if part else {}
            there = limits.get("confirmed_kpa", description.supply.nominal_kpa) * 1.2
            below = part is not None and kind_of(part).below_ambient
            return ("0", f"{-min(there, 100.0) if below else there:g}")
        case "frozen-after" | "silent-after" | "babble-after" | "reboot-after":
            return ("0",)
        case "locked-shows" | "unlocked-shows" | "stand-shows":
            return ("0", "1")
        case "supply":
            return ("0", f"{description.supply.refuse_kpa - 50:g}", f"{description.supply.warn_kpa - 20:g}")
        case "noise" | "flips" | "bursts" | "lost-bytes" | "doubled-bytes":
            return ("0.001", "0.2")
        case "late-answers":
            return ("50",)
        case "no-answers" | "twice-answers" | "wrong-answers":
            return ("0.2", "1")
    return ("",)
