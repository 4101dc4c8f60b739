"""Plays one case in virtual time and judges it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState
from end_effector_lab.testbench import TOOL_CHANGER
from end_effector_lab.virtual import VirtualTool, switchings
from timed_automata.execute import Observation

from ._case import (
    ALL,
    ARBITER,
    COMMANDS,
    DISK,
    END,
    HAL,
    KILL,
    NOMINAL,
    POWER,
    SCENARIO,
    START,
    STORES,
    Case,
    CaseEnd,
    Outcome,
    Story,
)
from ._coverage import CoverageMap, Coverer, Monitors, Reached
from ._judge import Judge

REST_S, STILL_US, DARK_S, MARGIN_US = 0.5, 500_000, 1.0, 30_000_000
LONGEST_US = 600_000_000
LONGEST_END_US = 20_000_000
"""Longest time that an arbiter needs to end, µs: its last wills take 10 s, or the time that the description needs."""
ALARMS_US = 15_000_000
"""Longest duration of an alarm that needs no acknowledgement, µs: a reboot of a device is reported for 10 s."""
SOON_S, KNOWN_S, FOLLOWED_S = 0.3, 3.0, 15.0
"""Waits, s: without any fault, if links, filters and faults must react first, and for faults that act slowly."""
STAND_BY, GRIPPED = EndEffectorState.STAND_BY, EndEffectorState.GRIPPED
AT_REST = (STAND_BY, GRIPPED, EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)


def play_case(
    description: Description,
    case: Case,
    known: CoverageMap | None = None,
    *,
    enough: Callable[[Mapping[str, str]], bool] = lambda _: False,
    on_frame: Callable[[Frame], None] | None = None,
) -> Trial:
    """Play a case once and judge it, see `Trial`; ``enough`` returns whether these failures end it early."""
    trial = Trial(description, case, known, on_frame)
    trial.play(enough)
    return trial


def tool_at_rest(tool: VirtualTool) -> VirtualTool:
    """Return the tool after it has come to rest; raises UsageError if it does not."""
    if not tool.run_until(LONGEST_US, lambda: tool.status.ee == STAND_BY):
        raise UsageError(f"{tool.description.name} does not come to rest: {tool.status.reason}")
    tool.run(REST_S)
    return tool


class Mark(NamedTuple):
    """The numbers of edges and statuses at ``at`` µs."""

    at: int
    edges: int
    statuses: int


class Trial:
    """A case that is played in virtual time and judged.

    Args:
        case: what happens to the tool.
        known: everything that can be reached; None: the coverage is not recorded.
        on_frame: see `VirtualTool`.

    Attributes:
        origin: the time at which the case begins, µs.
        marks: the numbers of edges and statuses before each happening.
        outcome, end: outcome and state before the faults are removed; no end: it is not over, or it crashed.
        ended: the numbers of edges and statuses then.

    Raises:
        UsageError: the tool cannot be played in virtual time, or does not come to rest.
    """

    def __init__(
        self,
        description: Description,
        case: Case,
        known: CoverageMap | None,
        on_frame: Callable[[Frame], None] | None,
    ) -> None:
        self._description, self._case = description, case
        self._monitors, self._coverer = Monitors(description), Coverer(known) if known else None
        self.tool = tool_at_rest(
            VirtualTool(description, seed=case.seed, watch=self._watch, on_frame=on_frame)
        )
        self._judge, self._story = Judge(description, self.tool), Story()
        self.origin, self._said = self.tool.at, list[tuple[int, str]]()
        self.marks: list[Mark] = []
        self._gripped = ""  # the part that was asked for last
        self.outcome = Outcome.UNFINISHED
        self.end: CaseEnd | None = None
        self.ended = self._mark()
        self._crash = ""

    def play(self, enough: Callable[[Mapping[str, str]], bool]) -> None:
        """Play the case once; ``enough`` returns whether these failures end it early."""
        try:
            self._happen()
            if enough(self._judge.objections):
                return
            self._settle()
            self._note_end()
            if not enough(self._judge.objections):
                self._use_again()
        except UsageError:
            raise
        except Exception as error:  # noqa: BLE001  a fault of the product, whatever it is, is what is looked for
            self._crash = f"crash: {type(error).__name__}: {error}"

    @property
    def failures(self) -> dict[str, str]:
        """The objections: a sentence by rule."""
        found = {"crash": self._crash} if self._crash else {}
        found |= self._judge.objections
        if said := self._monitors.objections:
            found["monitor"] = f"monitor: {said[0]}"
        return found

    @property
    def lasted_s(self) -> float:
        """Time from the beginning of the case until its faults are removed, s."""
        return (self.ended.at - self.origin) / 1e6

    @property
    def let_go(self) -> bool:
        """Whether a device released a held part because it received nothing, as declared (`on_link_loss`)."""
        return self._judge.let_go

    @property
    def reached(self) -> Reached:
        """The coverage of the executed automata."""
        return self._coverer.reached if self._coverer else Reached()

    @property
    def moments(self) -> tuple[int, ...]:
        """The times at which something moved or changed its state, µs, as targets for mutants."""
        moved = {each.at - self.origin for each in (*self.tool.edges, *_changes_of_state(self.tool.statuses))}
        return tuple(sorted(at for at in moved if at > 0))

    @property
    def grips(self) -> int:
        """The number of successful grips."""
        return sum(status.ee == GRIPPED for status in _changes_of_state(self.tool.statuses))

    def as_json(self) -> dict[str, Any]:
        """Return the content of a report."""
        end = {"end": self.end._asdict()} if self.end else {}
        return end | {
            "failures": self.failures, "seconds": round(self.tool.at / 1e6, 3), "log": list(self.log()),
        }  # fmt: skip

    def refused_since(self, at: int) -> bool:
        """Return whether a command was refused since ``at`` µs and before the faults were removed."""
        return any(at <= each <= self.ended.at for each in self._story.refused)

    def _watch(self) -> Callable[[Observation], None]:
        judged, covered = self._monitors.watch(), self._coverer.watch() if self._coverer else None

        def both(observation: Observation) -> None:
            judged(observation)
            if covered:
                covered(observation)

        return both

    def _mark(self) -> Mark:
        return Mark(self.tool.at, len(self.tool.edges), len(self.tool.statuses))

    def _note_end(self) -> None:
        tool = self.tool
        state = tool.status.ee.name if HAL in tool.living else ""
        every = list(switchings(self._description, tool.edges))
        self.end = CaseEnd.of(
            self._description, state, every, [each for each in every if each.at >= self.origin]
        )
        self.outcome = self._story.outcome(tool.status.ee) if self._is_still() else Outcome.UNFINISHED
        self.ended = self._mark()

    # What happens

    def _happen(self) -> None:
        for each in self._case.happenings:
            self._go(self.origin + each.at)
            self.marks.append(self._mark())
            self._act(each.what)

    def _go(self, at: int) -> None:
        self.tool.run_until(at, self._judge.look)

    def _act(self, what: str) -> None:
        tool, judge = self.tool, self._judge
        verb, _, rest = what.partition(" ")
        self._said.append((tool.at, what))
        if tool.status.ee == GRIPPED:
            self._story.gripped()
        if verb in COMMANDS:
            self._command(verb, rest)
        elif verb == SCENARIO:
            tool.choose(rest)
            judge.suffers(rest)
            if self._coverer:
                self._coverer.suffer(rest)
        elif verb in (KILL, END):
            names = processes(rest)
            if HAL in names:
                judge.hal_dies()
                self._story.hal_dies(held=tool.status.held)
            for name in names:
                (tool.kill if verb == KILL else tool.end)(name)
        elif verb == START:
            for name in reversed(processes(rest)):
                tool.start(name)
        elif verb == DISK:
            store, trouble = rest.split(" ")
            disk = getattr(tool.memories, store)
            disk.full = disk.fails = disk.hangs = False
            if trouble != "well":
                judge.disturbed()
                setattr(disk, trouble, True)
        elif verb == POWER:
            self._lose_power()
        judge.look()

    def _lose_power(self) -> None:
        tool = self.tool
        tool.lose_power()
        self._judge.power_lost()
        self._go(tool.at + round(DARK_S * 1e6))
        for name in reversed(processes(ALL)):
            tool.start(name)

    def _command(self, name: str, part: str = "") -> bool:
        tool, at = self.tool, self.tool.at
        if name == "reset":
            return self._reset()
        self._gripped = part if name == "grip" else self._gripped
        answer = tool.command(name, self._judge.look, part)
        self._said.append((tool.at, f"  {name}: {'accepted' if answer.accepted else answer.reason}"))
        self._judge.commanded(name, answer, at)
        self._story.commanded(name, at, accepted=answer.accepted)
        self._judge.look()
        return answer.accepted

    def _reset(self) -> bool:
        """Reset as the product does: first the tool changer, then the line arbiter."""
        tool = self.tool
        if tool.status.changer_fault and HAL in tool.living:
            answer = tool.command("reset")
            self._judge.commanded("reset", answer, tool.at)
            self._until(lambda: tool.status.changer != ChangerState.LOCKING, 5_000_000)
        answer = tool.reset()
        self._said.append((tool.at, f"  reset: {'accepted' if answer.accepted else answer.reason}"))
        self._judge.commanded("reset", answer, tool.at)
        return answer.accepted

    # What becomes of it

    def _until(self, so: Callable[[], bool], longest_us: int) -> bool:
        return self.tool.run_until(self.tool.at + longest_us, lambda: self._judge.look() or so())

    def _is_still(self) -> bool:
        """Return whether all processes run, no command does, and the unlock output is inactive."""
        tool, changer = self.tool, self._description.tool_changer
        unlocked = bool(changer and tool.levels.get(changer.line))
        return (
            len(tool.living) == 2
            and tool.status.ee in AT_REST
            and tool.status.command == Command.NONE
            and not unlocked
        )

    def _settle(self) -> None:
        """Wait until nothing moves; dead processes stay dead. A held part is followed, as some faults act slowly."""
        tool, durations = self.tool, self._description.durations
        self._until(lambda: not tool.ending, LONGEST_END_US)
        limit = tool.at + (durations.grip_ms + durations.release_ms) * 1000 + MARGIN_US
        begun, acts_slowly = tool.at, tool.bench.scenario.text != NOMINAL
        if len(tool.living) < 2:
            releases = sum(actuator.release_s for actuator in self._description.actuators.values())
            self._go(tool.at + round(releases * 1e6) + 3_000_000)
            self._judge.at_rest(still=True)
            return
        self._go(tool.at + STILL_US)
        while tool.at < limit:
            if not self._until(self._is_still, limit - tool.at):
                break
            before = len(tool.edges), tool.status.ee
            self._go(tool.at + STILL_US)
            if before != (len(tool.edges), tool.status.ee) or not self._is_still():
                continue
            followed = FOLLOWED_S if acts_slowly and tool.status.ee == GRIPPED else KNOWN_S
            if not tool.status.held or tool.at - begun >= round(followed * 1e6):
                break
        self._judge.at_rest(still=self._is_still())

    def _use_again(self) -> None:
        """Remove all faults and check that the tool is usable: a reset, a lock, drops; a grip and a drop."""
        self._said.append((self.tool.at, "everything is put right, and the tool is used again:"))
        disks = [getattr(self.tool.memories, store) for store in STORES]
        well = self.tool.bench.scenario.text == NOMINAL and len(self.tool.living) == 2
        well = well and not any(disk.full or disk.fails or disk.hangs for disk in disks)
        for store in STORES if not well else ():
            self._act(f"{DISK} {store} well")
        if not well:
            self._act(f"{SCENARIO} {NOMINAL}")
        if len(self.tool.living) < 2:
            self._act(f"{START} {ALL}")
        why = self._not_usable(SOON_S if well else KNOWN_S)
        if why:
            status = self.tool.status
            said = (
                f"{status.ee.name}, {status.changer.name}, {status.reason or '; '.join(status.alarm_texts)}"
            )
            self._judge.objections.setdefault("usable", f"usable: {why} ({said})")

    @property
    def _lock_is_never_proven(self) -> bool:
        """Whether only one bit of the tool changer is fitted, so that it is never LOCKED."""
        changer, carried = self._description.tool_changer, carrier_of(self._description).channels
        return changer is not None and (changer.locked_bit in carried) != (changer.unlocked_bit in carried)

    def _not_usable(self, known_s: float) -> str:
        """Return why the tool cannot be used, as a clause; "" if it can. The check waits ``known_s`` after the tool
        has come to rest; by then the program has detected that no fault is left.
        """
        tool, durations = self.tool, self._description.durations
        longest = (durations.grip_ms + durations.release_ms) * 1000 + MARGIN_US
        if not self._until(self._is_still, longest):
            return "it does not come to rest"
        self._go(tool.at + round(known_s * 1e6))
        reset = self._reset()
        self._go(tool.at + 500_000)
        if self._changer_wants_lock() and not self._lock_is_never_proven and not self._locks():
            return "it does not lock"
        for _ in range(2):
            if tool.status.ee == STAND_BY:
                break
            if not self._command("drop"):
                return "a drop is refused"
            self._until(self._is_still, longest)
            self._go(tool.at + 500_000)
        if tool.status.ee != STAND_BY:
            return "a drop does not end in STAND_BY"
        if self._may_be_half_way and self._command("drop"):
            self._until(self._is_still, longest)
            self._go(tool.at + 500_000)
        if not (reset or self._reset()):  # some trouble ends only with the drop
            return "a reset is refused"
        self._go(tool.at + round(SOON_S * 1e6))
        if not self._command("grip", self._gripped):
            return f"a grip is refused: {self._said[-1][1].strip()}"
        if not self._until(lambda: tool.status.ee == GRIPPED, longest):
            return "a grip does not succeed"
        self._go(tool.at + 200_000)
        if not self._command("drop"):
            return "a drop is refused"
        if not self._until(lambda: tool.status.ee == STAND_BY, longest):
            return "a drop does not end in STAND_BY"
        if not self._until(lambda: not tool.status.alarms, ALARMS_US):
            return "nothing is wrong any more, and an alarm stays"
        return ""

    @property
    def _may_be_half_way(self) -> bool:
        """Whether a device moves when it is activated: what stopped it leaves it half-way, and a Drop opens it."""
        return any(each.activation for each in self._description.register_outputs.values())

    def _changer_wants_lock(self) -> bool:
        return bool(self._description.tool_changer) and self.tool.status.changer != ChangerState.LOCKED

    def _locks(self) -> bool:
        """Lock the tool; a lock that is refused while another one runs is repeated."""
        for _ in range(2):
            self._command("lock")
            if self._until(lambda: not self._changer_wants_lock(), 5_000_000):
                self._go(self.tool.at + 500_000)
                return self.tool.bench.devices[TOOL_CHANGER].bits["locked"]
        return False

    def log(self) -> tuple[str, ...]:
        """Return what has happened, for people."""
        tool = self.tool
        lines = [(at, 0, what) for at, what in self._said]
        lines += [(edge.at, 1, f"  {edge.line} {'on' if edge.level else 'off'}") for edge in tool.edges]
        for status in _changes_of_state(tool.statuses):
            lines.append((status.at, 2, f"  {status.ee.name} {status.reason}".rstrip()))
        known: set[str] = set()
        for status in tool.statuses:
            lines += [
                (status.at, 3, f"  alarm: {alarm}") for alarm in status.alarm_texts if alarm not in known
            ]
            known |= set(status.alarm_texts)
        shown = sorted((line for line in lines if line[0] >= self.origin), key=lambda line: line[0])
        return tuple(f"{(at - self.origin) / 1e6:9.3f} {what}" for at, _, what in shown)


def _changes_of_state(statuses: Sequence[Any]) -> list[Any]:
    return [
        status
        for number, status in enumerate(statuses)
        if number == 0 or status.ee != statuses[number - 1].ee
    ]


@contextmanager
def no_log() -> Iterator[None]:
    """Disable logging, since the cases cause deaths on purpose."""
    logging.disable()
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)


def processes(name: str) -> tuple[str, ...]:
    """Return the processes that a word of a case names."""
    return (HAL, ARBITER) if name == ALL else (name,)
