"""The grid of cases: every fault, at every place, at every moment of a grip and a drop, with every command."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, islice, pairwise
from math import ceil, gcd, sqrt

from end_effector_hal.description import Description, network_address
from end_effector_hal.errors import UsageError
from end_effector_hal.faults import FaultOffer
from end_effector_hal.kinds import kind_of
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.testbench import offered_faults
from end_effector_lab.virtual import VirtualTool, switchings

from ._case import ALL, KILL, NOMINAL, SCENARIO, START, Case, Happening
from ._effects import GRIP, HELD, RELEASE, REST
from ._play import LONGEST_US, STAND_BY, tool_at_rest

GOLDEN = (1 + sqrt(5)) / 2
NOTHING, BOTH = "none", "kill both"
COMMANDS = (NOTHING, "cancel", "drop", "lock", "unlock", "kill hal", "kill arbiter", BOTH)
"""Commands of the cells. `hal` is the program with the sensor reader; a killed process is restarted a second later."""
AT_ONCE = ", at once"
"""Suffix of a kill: the process is restarted at the same instant."""
GRIP_US, HOLD_US, DEAD_US, NEAR_US = 1_500_000, 1_000_000, 1_000_000, 1_000
GRIP_AFTER_US = 700_000
"""Time of the grip after a fault at rest, µs: two contradicting sensors are a fault after 0.5 s (IL-04)."""
GRIPPED = EndEffectorState.GRIPPED


_USUAL = {"seconds": ("0",), "bit": ("0", "1"), "rate": ("0.2", "1")}
"""Numbers of a fault by their name."""


@dataclass(frozen=True)
class Moment:
    """A time at which a cell disturbs the run without a fault: a grip, a hold and a drop.

    Attributes:
        name: such as ``grip cylinder on`` or ``held, between``.
        at: time after the tool has come to rest, µs.
        phase: phase of the run at that time, of `PHASES`.
        engaged: actuators whose outputs are active then, in the order of the sequence.
        before: the commands of the run until then.
        part: the part that the run grips; empty: the tool names none.
    """

    name: str
    at: int
    phase: str
    engaged: tuple[str, ...]
    before: tuple[Happening, ...] = ()
    part: str = ""


def grip_of(part: str) -> str:
    """Return the command that grips a part."""
    return f"grip {part}".strip()


@dataclass(frozen=True)
class Cell:
    """One fault, from one moment on, and a command at the same instant.

    Attributes:
        fault: in the words of the testbench.
        moment: the time of both.
        at_once: whether a killed process is restarted at once, not a second later.
    """

    fault: str
    moment: Moment
    command: str
    at_once: bool = False

    @property
    def id(self) -> str:
        """The name of the cell within the grid of its tool."""
        return f"{self.fault} @ {self.moment.name} + {self.words}"

    @property
    def words(self) -> str:
        """The command, with its suffix."""
        return f"{self.command}{AT_ONCE if self.at_once else ''}"

    @property
    def name(self) -> str:
        """The name of the fault alone."""
        return self.fault.partition(":")[0]

    @property
    def case(self) -> Case:
        """The happenings of the cell: the commands of the run, the fault, and what follows it."""
        at = self.moment.at
        happenings = [*self.moment.before, Happening(at, f"{SCENARIO} {self.fault}")]
        if self.command.startswith(KILL):
            name = ALL if self.command == BOTH else self.command.removeprefix(f"{KILL} ")
            again = at if self.at_once else at + DEAD_US
            happenings += [Happening(at, f"{KILL} {name}"), Happening(again, f"{START} {name}")]
        elif self.command != NOTHING:
            happenings.append(Happening(at, self.command))
        elif self.moment.phase == REST:
            happenings.append(Happening(at + GRIP_AFTER_US, grip_of(self.moment.part)))
        return Case(0, tuple(happenings))


def faults_of(description: Description) -> tuple[str, ...]:
    """Return every fault that the tool can have, at each of its places, with the numbers of `_numbers`."""
    found: list[str] = []
    for offer in offered_faults(description):
        places = [*([""] if offer.anywhere else []), *offer.places]
        for place in places:
            numbers = _numbers(description, offer, place)
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
            if command.startswith(KILL):
                yield Cell(NOMINAL, moment, command, at_once=True)


def thinned(cells: Sequence[Cell], every: int) -> list[Cell]:
    """Return one cell of every ``every``, spread evenly over faults, moments and commands, in the order of the grid.

    A plain stride has factors in common with the number of commands and would meet few of them. The step of the golden
    ratio, coprime to the number of cells, rounded up to whole rows of commands, meets each of them once in as many
    cells as there are commands (Kronecker's sequence).
    """
    total = len(cells) + -len(cells) % (len({cell.command for cell in cells}) or 1)
    step = next(step for step in count(round(total / GOLDEN) or 1) if gcd(step, total) == 1)
    spread = (at for number in range(total) if (at := number * step % total) < len(cells))
    return [cells[at] for at in sorted(islice(spread, ceil(len(cells) / every)))]


def _numbers(description: Description, offer: FaultOffer, place: str) -> tuple[str, ...]:
    """Return representative numbers: values on both sides of the description's limit."""
    actuator, supply = description.actuators.get(place), description.supply
    match offer.name:
        case "fails":
            attempts = actuator.attempts if actuator else 3
            return (str(attempts - 1), str(attempts)) if attempts > 1 else (str(attempts),)
        case "leak":
            return ("4", "40")
        case "leak-grows":
            return ("2",)
        case "lost-after":
            return ("0.1", "1")
        case "shows":
            limits = kind_of(actuator).limits(actuator, supply) if actuator else {}
            there = limits.get("confirmed_kpa", supply.nominal_kpa) * 1.2
            below = actuator is not None and kind_of(actuator).below_ambient
            return ("0", f"{-min(there, 100.0) if below else there:g}")
        case "other-device-after":
            return ()  # it acknowledges releases in the place of the device: no rule can hold
        case "supply":
            return ("0", f"{supply.refuse_kpa - 50:g}", f"{supply.warn_kpa - 20:g}")
        case "noise" | "flips" | "bursts" | "lost-bytes" | "doubled-bytes":
            return ("0.001", "0.2")
        case "late-answers":
            slow = any(network_address(link.port) for link in description.links.values())
            return ("50", "500", "5000") if slow else ("50",)
    return _USUAL.get(offer.number.name if offer.number else "", ("",))


def moments(description: Description) -> tuple[Moment, ...]:
    """Return moments at each event of the run without a fault, a millisecond before and after it, and between two.

    A tool that names parts has a run for each; the names of its moments begin with the part.

    Raises:
        UsageError: the run does not succeed without a fault.
    """
    return tuple(moment for part in description.part_names for moment in _moments(description, part))


def _moments(description: Description, part: str) -> tuple[Moment, ...]:
    tool = tool_at_rest(VirtualTool(description))
    origin, before = tool.at, list[Happening]()
    events: list[tuple[int, str]] = []

    def play(command: str, phase: str, over: EndEffectorState) -> None:
        """Give a command, and note what happens until the tool is in the state ``over``."""
        edges, (name, _, of) = len(tool.edges), command.partition(" ")
        before.append(Happening(tool.at - origin, command))
        tool.command(name, part=of)
        if not tool.run_until(tool.at + LONGEST_US, lambda: tool.status.ee == over):
            raise UsageError(f"{description.name} does not {command} without a fault: {tool.status.reason}")
        moved = switchings(description, tool.edges[edges:])
        events.extend((each.at - origin, f"{phase} {each}") for each in moved)
        whole_ms = -(-(tool.at - origin) // NEAR_US) * NEAR_US
        events.append((whole_ms, f"{phase} {over.name}"))

    tool.run_until(origin + GRIP_US)
    play(grip_of(part), GRIP, GRIPPED)
    held_at = tool.at - origin
    tool.run(HOLD_US / 1e6)
    play("drop", RELEASE, STAND_BY)
    switched = [each._replace(at=each.at - origin) for each in switchings(description, tool.edges)]

    def moment(name: str, at: int) -> Moment:
        active = {each.name: each.active for each in switched if each.at <= at}
        engaged = tuple(name for name in description.sequence if active.get(name))
        given = tuple(each for each in before if each.at <= at)
        phase = (REST, HELD if at >= held_at else GRIP, RELEASE)[len(given)]
        called = f"{part}: {name}" if part else name
        return Moment(called, at, phase, engaged, given, part)

    return tuple(moment(*each) for each in _near(events))


def _near(events: Sequence[tuple[int, str]]) -> Iterator[tuple[str, int]]:
    """Yield the names and times of the moments near the events; nothing is done after the last one."""
    yield REST, GRIP_US - HOLD_US // 2
    different = sorted(dict(events).items())
    for at, name in different:
        yield f"{name} -1ms", at - NEAR_US
        if at < different[-1][0]:
            yield name, at
            yield f"{name} +1ms", at + NEAR_US
    for (first, name), (second, _) in pairwise(different):
        if second - first > 4 * NEAR_US:
            yield f"{name}, between", (first + second) // 2
