"""Plays one cell in virtual time and determines its outcome."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import asdict, dataclass, field
from typing import Any

from pydantic import ConfigDict

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.virtual import Monitors, switchings

from ._cells import BOTH, NOTHING, Cell, Outcome
from ._expected import LYING, expected, is_loose, lets_go
from ._script import GRIP, RELEASE, REST, Script, is_still, prepared

DEAD_US, STILL_US, FOLLOWED_US = 1_000_000, 500_000, 15_000_000
MARGIN_US = 30_000_000
GRIP_AFTER_S = 0.7
"""Time of the grip after a fault at rest, s: two contradicting sensors are a fault after 0.5 s (IL-04)."""


@dataclass(frozen=True)
class Played:
    """A cell with its result.

    Attributes:
        id, fault, moment, phase, command: the cell.
        outcome, expected: the outcome, and the allowed ones.
        explained: whether outcome and alarm are as expected, without objections.
        dropped: whether an output of a held part became inactive without a drop.
        let_go: the same, because its device receives nothing, as its description declares (`on_link_loss`).
        seconds: time from the fault to the last change of a line or state.
        told, told_after: the first alarm or reason after the fault, and its delay in s.
        lines: every later change of a line: seconds, line, level.
        objections: sentences of the monitor and of the judge.
    """

    __pydantic_config__ = ConfigDict(extra="forbid", allow_inf_nan=False)

    id: str
    fault: str
    moment: str
    phase: str
    command: str
    outcome: str
    expected: tuple[str, ...]
    why: str
    explained: bool
    dropped: bool
    seconds: float
    told: str = ""
    told_after: float | None = None
    lines: tuple[tuple[float, str, bool], ...] = ()
    objections: tuple[str, ...] = field(default=())
    let_go: bool = False

    def as_json(self) -> dict[str, Any]:
        """Return the result in the form of the file."""
        return asdict(self)


def play(description: Description, cell: Cell) -> Played:
    """Play a cell and judge it."""
    return CellRun(Undisturbed(description), cell).played()


def outcome_of(
    cell: Cell, state: EndEffectorState, phase: str, answered: Collection[tuple[str, bool]]
) -> Outcome:
    """Return the outcome of a cell that has come to rest.

    Args:
        cell: the played cell.
        state: final state of the tool.
        phase: the last phase that began, of `PHASES`.
        answered: the commands since the fault, and whether they were accepted.
    """
    match state:
        case EndEffectorState.GRIPPED:
            return Outcome.SUCCESS
        case EndEffectorState.GRIP_ERROR:
            return Outcome.HELD
        case EndEffectorState.RELEASE_ERROR:
            return Outcome.STILL_THERE
    if cell.command in ("kill hal", BOTH) and cell.moment.phase != REST:
        return Outcome.UNWOUND
    if ("cancel", True) in answered:
        return Outcome.CANCELLED
    if phase == RELEASE or ("drop", True) in answered:
        return Outcome.RELEASED
    if phase == GRIP and ("grip", False) not in answered:
        return Outcome.FAILED
    refused = any(not accepted for _, accepted in answered)
    return Outcome.REFUSED if refused else Outcome.AT_REST


class Undisturbed:
    """The run before a cell disturbs it; it is the same for all cells of one moment."""

    def __init__(self, description: Description, on_frame: Callable[[Frame], None] | None = None) -> None:
        self.description, self.monitors = description, Monitors(description)
        self.tool = prepared(description, self.monitors.watch, on_frame)
        self.script = Script(self.tool)


class CellRun:
    """A cell that continues an undisturbed run and consumes it; ``tool`` keeps the events for a figure.

    Args:
        undisturbed: a run up to the moment of the cell at most.
        cell: the disturbance.
    """

    def __init__(self, undisturbed: Undisturbed, cell: Cell) -> None:
        self._description, self._cell = undisturbed.description, cell
        self._monitors, self._script = undisturbed.monitors, undisturbed.script
        self._answered: list[tuple[str, bool]] = []
        self._let_go_at: int | None = None
        self.tool = undisturbed.tool

    def played(self) -> Played:
        """Play the cell once."""
        cell, tool, script = self._cell, self.tool, self._script
        script.run_until(cell.moment.at)
        self._let_go_at = script.dropped_at
        marks = len(tool.edges), len(tool.statuses)
        if cell.name != "nominal":
            tool.choose(cell.fault)
        self._act(script)
        self._settle()
        outcome = self._outcome(script)
        return self._judged(outcome, marks)

    def _act(self, script: Script) -> None:
        cell, tool = self._cell, self.tool
        if cell.command.startswith("kill"):
            names = ("hal", "arbiter") if cell.command == BOTH else (cell.command.removeprefix("kill "),)
            for name in names:
                tool.kill(name)
            if not cell.at_once:
                tool.run(DEAD_US / 1e6)
            for name in reversed(names):
                tool.start(name)
        elif cell.command != NOTHING:
            at = tool.at
            accepted = tool.command(cell.command).accepted
            self._answered.append((cell.command, accepted))
            if cell.command == "drop" and accepted:
                self._let_go_at = at
        elif cell.moment.phase == REST:
            tool.run(GRIP_AFTER_S)
            script.step()
            self._answered.append(("grip", script.answer.accepted))

    def _settle(self) -> None:
        """Wait until nothing moves; follow a held part for a while, because some faults act slowly."""
        tool, longest = self.tool, self._description.durations
        limit = tool.at + (longest.grip_ms + longest.release_ms) * 1000 + MARGIN_US
        follow_until = tool.at + FOLLOWED_US
        tool.run_until(tool.at + STILL_US)
        while tool.at < limit:
            if not tool.run_until(limit, self._is_still):
                return
            before = len(tool.edges), tool.status.ee
            tool.run(STILL_US / 1e6)
            holds = tool.status.ee == EndEffectorState.GRIPPED and self._cell.name != "nominal"
            if before != (len(tool.edges), tool.status.ee) or not self._is_still():
                continue
            if not holds or tool.at >= follow_until:
                return

    def _is_still(self) -> bool:
        return is_still(self._description, self.tool)

    def _outcome(self, script: Script) -> Outcome:
        if not self._is_still():
            return Outcome.UNFINISHED
        return outcome_of(self._cell, self.tool.status.ee, script.phase, self._answered)

    def _judged(self, outcome: Outcome, marks: tuple[int, int]) -> Played:
        cell, tool = self._cell, self.tool
        edges = tool.edges[marks[0] :]
        want = expected(self._description, cell)
        told, told_after = self._told(marks)
        objections = [f"monitor: {what}" for what in self._monitors.objections]
        if outcome not in want.outcomes:
            objections.append(f"expected: {', '.join(sorted(want.outcomes))}")
        if want.alarm and not told:
            objections.append("no alarm and no reason was reported")
        objections += self._false_success()
        lost = self._lost()
        let_go = lost and lets_go(self._description, cell)
        dropped = lost and not let_go
        if dropped:
            objections.append("an output of a held part went inactive without a drop")
        last = max([edge.at for edge in edges], default=cell.moment.at)
        return Played(
            cell.id, cell.fault, cell.moment.name, cell.moment.phase, cell.words,
            outcome.value, tuple(sorted(each.value for each in want.outcomes)), want.why,
            not objections, dropped, round((last - cell.moment.at) / 1e6, 3), told, told_after,
            tuple((round((e.at - cell.moment.at) / 1e6, 6), e.line, e.level) for e in edges), tuple(objections), let_go,
        )  # fmt: skip

    def _told(self, marks: tuple[int, int]) -> tuple[str, float | None]:
        """Return the first new alarm or reason after the fault; for a command, its refusal."""
        tool, cell = self.tool, self._cell
        before = tool.statuses[marks[1] - 1 : marks[1]]
        known = {text for status in before for text in _texts(status)}
        for status in tool.statuses[marks[1] :]:
            for text in _texts(status):
                if text and text not in known:
                    return text, round((status.at - cell.moment.at) / 1e6, 3)
        refused = any(not accepted for _, accepted in self._answered)
        return ("The command was refused.", 0.0) if refused else ("", None)

    def _false_success(self) -> list[str]:
        """Return objections to a reported grip that is not real; none if a fault falsifies its sensors."""
        tool = self.tool
        if (
            self._cell.name in LYING
            or tool.status.ee != EndEffectorState.GRIPPED
            or not tool.status.lift_allowed
        ):
            return []
        if is_loose(self._description, self._cell):
            return ["lifting is allowed, and the tool is not locked"]
        missing = [name for name in self._description.sequence if not tool.bench.devices[name].grips]
        return [f"lifting is allowed, and {', '.join(missing)} does not grip"] if missing else []

    def _lost(self) -> bool:
        """Return whether an output was released between GRIPPED and a drop although no ending declares it."""
        tool = self.tool
        held = [status.at for status in tool.statuses if status.ee == EndEffectorState.GRIPPED]
        if not held:
            return False
        until = self._let_go_at if self._let_go_at is not None else tool.at + 1
        declared = self._cell.command.startswith("kill") and any(
            self._description.endings_of(name).held.process_death == "release"
            for name in self._description.sequence
        )
        switched = switchings(self._description, tool.edges)
        lost = [each for each in switched if not each.active and held[0] < each.at < until]
        return bool(lost) and not declared


def _texts(status: Status) -> tuple[str, ...]:
    return (*status.alarm_texts, status.reason, status.changer_reason)
