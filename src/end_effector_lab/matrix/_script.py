"""The undisturbed run (rest, grip, hold, drop) and its moments."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from end_effector_hal.control import Answer
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_lab.virtual import VirtualTool, Watch, switchings

REST_US, HOLD_US, LONGEST_US = 1_000_000, 1_000_000, 600_000_000
NEAR_US = 1_000
STAND_BY, GRIPPED = EndEffectorState.STAND_BY, EndEffectorState.GRIPPED
REST, GRIP, HELD, RELEASE = "rest", "grip", "held", "release"
PHASES = (REST, GRIP, HELD, RELEASE)
AT_REST = (STAND_BY, GRIPPED, EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)


@dataclass(frozen=True)
class Moment:
    """A time at which a cell disturbs the tool.

    Attributes:
        name: such as ``grip cylinder on`` or ``held, between``.
        at: time, µs.
        phase: phase of the run at that time, of `PHASES`.
        engaged: actuators whose outputs are active then, in the order of the sequence.
        since: time since the last output moved, µs; default: long.
    """

    name: str
    at: int
    phase: str
    engaged: tuple[str, ...]
    since: int = 10_000_000


def prepared(
    description: Description,
    watch: Watch | None = None,
    on_frame: Callable[[Frame], None] | None = None,
) -> VirtualTool:
    """Return a tool at rest, always in the same state; raises UsageError if it does not come to rest."""
    tool = VirtualTool(description, watch=watch, on_frame=on_frame)
    if not tool.run_until(LONGEST_US, lambda: tool.status.ee == STAND_BY):
        raise UsageError(f"{description.name} does not come to rest: {tool.status.reason}")
    tool.run(REST_US / 1e6)
    return tool


def is_still(description: Description, tool: VirtualTool) -> bool:
    """Return whether all processes run, no command does, and the unlock output is inactive."""
    status, changer = tool.status, description.tool_changer
    unlocked = bool(changer and tool.levels.get(changer.line))
    return len(tool.living) == 2 and status.ee in AT_REST and status.command == Command.NONE and not unlocked


class Script:
    """Gives the commands of the run at their times, until it is stopped.

    Attributes:
        phase: the last phase that began.
        begun: begin of each phase, µs.
        answer: answer to the last command.
        dropped_at: time of the drop, µs; None before it.
    """

    def __init__(self, tool: VirtualTool) -> None:
        self._tool, self._next = tool, tool.at + REST_US
        self.phase, self.answer = REST, Answer(True)
        self.begun = {REST: tool.at}
        self.dropped_at: int | None = None

    def run_until(self, at: int) -> None:
        """Advance time to ``at`` (µs), and give all commands that are due."""
        while True:
            if self.phase in (REST, HELD) and self._next <= self._tool.at:
                self.step()
            elif self._tool.at >= at:
                return
            elif self.phase == GRIP and self._tool.status.ee == GRIPPED:
                self.phase, self._next = HELD, self._tool.at + HOLD_US
                self.begun[HELD] = self._tool.status.at
            else:
                self._advance(at)

    def step(self) -> None:
        """Begin the next phase if it begins with a command."""
        if self.phase == REST:
            self.begun[GRIP] = self._tool.at
            self.phase, self.answer = GRIP, self._tool.command("grip")
        elif self.phase == HELD:
            self.begun[RELEASE] = self.dropped_at = self._tool.at
            self.phase, self.answer = RELEASE, self._tool.command("drop")

    def _advance(self, at: int) -> None:
        if self.phase in (REST, HELD):
            self._tool.run_until(min(at, self._next))
        elif self.phase == GRIP:
            self._tool.run_until(at, lambda: self._tool.status.ee == GRIPPED)
        else:
            self._tool.run_until(at)


def moments(description: Description) -> tuple[Moment, ...]:
    """Return moments at each event of the run, a millisecond before and after it, and between two events.

    Raises:
        UsageError: the run does not succeed without a fault.
    """
    tool = prepared(description)
    script, begun = Script(tool), tool.at
    events: list[tuple[int, str, str]] = [(begun + REST_US // 2, REST, REST)]
    edges = len(tool.edges)
    while script.phase != RELEASE or tool.status.ee != STAND_BY:
        before, state = script.phase, tool.status.ee
        script.run_until(tool.at + NEAR_US)
        for at, name, active in switchings(description, tool.edges[edges:]):
            events.append((at, script.phase, f"{name} {'on' if active else 'off'}"))
        edges = len(tool.edges)
        if tool.status.ee != state and tool.status.ee in (GRIPPED, STAND_BY):
            events.append((tool.status.at, script.phase, tool.status.ee.name))
        if tool.at > LONGEST_US or (before == GRIP and tool.status.ee == STAND_BY):
            raise UsageError(f"{description.name} does not grip without a fault: {tool.status.reason}")
    return tuple(_named(description, events, tool, script.begun))


def _named(
    description: Description,
    events: list[tuple[int, str, str]],
    tool: VirtualTool,
    begun: Mapping[str, int],
) -> Iterator[Moment]:
    switched = list(switchings(description, tool.edges))
    ends = [at for at, _, what in events if what == STAND_BY.name][-1]

    def moment(at: int, name: str) -> Moment:
        active = {name: active for when, name, active in switched if when <= at}
        engaged = tuple(name for name in description.sequence if active.get(name))
        phase = next(phase for phase in reversed(PHASES) if begun[phase] <= at)
        since = at - max((when for when, _, _ in switched if when <= at), default=0)
        return Moment(name, at, phase, engaged, since)

    yield moment(events[0][0], REST)
    different = sorted({at: f"{phase} {what}" for at, phase, what in events[1:]}.items())
    for at, name in different:
        yield moment(at - NEAR_US, f"{name} -1ms")
        if at < ends:
            yield moment(at, name)
            yield moment(at + NEAR_US, f"{name} +1ms")
    for (first, name), (second, _) in pairwise(different):
        if second - first > 4 * NEAR_US:
            yield moment((first + second) // 2, f"{name}, between")
