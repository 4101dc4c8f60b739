"""Plays one case in virtual time and judges it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import ChangerState, EndEffectorState
from end_effector_lab.matrix import is_still
from end_effector_lab.testbench import TOOL_CHANGER
from end_effector_lab.virtual import Monitors, Switching, VirtualTool, switchings
from timed_automata.execute import Observation

from ._case import ALL, ARBITER, COMMANDS, DISK, END, HAL, KILL, POWER, SCENARIO, START, STORES, Case
from ._coverage import CoverageMap, Coverer, Reached
from ._judge import Judge

REST_S, STILL_US, DARK_S, MARGIN_US = 0.5, 500_000, 1.0, 30_000_000
LONGEST_US = 600_000_000
LONGEST_END_US = 20_000_000
"""Longest time that an arbiter needs to end, µs: its last wills take 10 s, or the time that the description needs."""
ALARMS_US = 15_000_000
"""Longest duration of an alarm that needs no acknowledgement, µs: a reboot of a device is reported for 10 s."""
SOON_S, KNOWN_S = 0.3, 3.0
"""Waits before the tool is used again, s: without any fault, and if links, filters and faults must react first."""
STAND_BY, GRIPPED = EndEffectorState.STAND_BY, EndEffectorState.GRIPPED


class CaseEnd(NamedTuple):
    """The state of the tool at the end of a case, before the faults are removed.

    Attributes:
        state: name of the state of the end-effector; empty: its program does not run.
        active: active outputs of the grip.
        moved: the switchings, such as ``cylinder on``.
    """

    state: str
    active: tuple[str, ...]
    moved: tuple[str, ...]

    @classmethod
    def of(
        cls, description: Description, state: str, every: Iterable[Switching], moved: Iterable[Switching]
    ) -> CaseEnd:
        """Return the state from the switchings since the start and since the beginning of the case."""
        active = {each.name: each.active for each in every}
        return cls(
            state,
            tuple(name for name in description.sequence if active.get(name)),
            tuple(map(str, moved)),
        )

    def __str__(self) -> str:
        return f"{self.state or 'not running'}; active: {', '.join(self.active) or 'none'}"


@dataclass(frozen=True)
class PlayedCase:
    """The result of a case.

    Attributes:
        failures: sentence by rule; empty if nothing failed.
        reached: coverage of the executed automata.
        moments: times at which something moved or changed its state, µs, as targets for mutants.
        grips: number of successful grips.
        seconds: virtual time, s.
        end: state of the tool before the faults are removed; None: it crashed.
        log: the events for people, one line each.
    """

    failures: dict[str, str]
    reached: Reached
    moments: tuple[int, ...]
    grips: int
    seconds: float
    end: CaseEnd | None = None
    log: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return the content of a report."""
        end = {"end": self.end._asdict()} if self.end else {}
        return end | {"failures": self.failures, "seconds": round(self.seconds, 3), "log": list(self.log)}


def play_case(
    description: Description,
    case: Case,
    known: CoverageMap,
    *,
    log: bool = False,
    enough: Callable[[Mapping[str, str]], bool] = lambda _: False,
) -> PlayedCase:
    """Play a case and judge it.

    Args:
        description: the description of the tool.
        case: the events.
        known: everything that can be reached.
        log: write the log even if nothing failed.
        enough: returns whether these failures end the case early.

    Raises:
        UsageError: the tool cannot be played in virtual time, or does not come to rest.
    """
    return _CaseRun(description, case, known).played(enough, log=log)


class _CaseRun:
    def __init__(self, description: Description, case: Case, known: CoverageMap) -> None:
        self._description, self._case = description, case
        self._monitors, self._coverer = Monitors(description), Coverer(known)
        self.tool = tool = VirtualTool(description, seed=case.seed, watch=self._watch)
        if not tool.run_until(LONGEST_US, lambda: tool.status.ee == STAND_BY):
            raise UsageError(f"{description.name} does not come to rest: {tool.status.reason}")
        tool.run(REST_S)
        self._judge = Judge(description, tool)
        self._origin, self._said = tool.at, list[tuple[int, str]]()

    def played(self, enough: Callable[[Mapping[str, str]], bool], *, log: bool) -> PlayedCase:
        """Play the case once."""
        crashed: dict[str, str] = {}
        end: CaseEnd | None = None
        try:
            for part in (self._happen, self._settle, self._use_again):
                end = self._end() if part == self._use_again else None
                if enough(self._judge.objections):
                    break
                part()
        except UsageError:
            raise
        except Exception as error:  # noqa: BLE001  a fault of the product, whatever it is, is what is looked for
            crashed["crash"] = f"crash: {type(error).__name__}: {error}"
        failures = crashed | self._judge.objections
        if said := self._monitors.objections:
            failures["monitor"] = f"monitor: {said[0]}"
        tool = self.tool
        moved = {edge.at - self._origin for edge in tool.edges}
        moved |= {status.at - self._origin for status in _changes_of_state(tool.statuses)}
        return PlayedCase(
            failures, self._coverer.reached, tuple(sorted(at for at in moved if at > 0)),
            sum(status.ee == GRIPPED for status in _changes_of_state(tool.statuses)),
            tool.at / 1e6, end, self._log() if log or failures else (),
        )  # fmt: skip

    def _watch(self) -> Callable[[Observation], None]:
        judged, covered = self._monitors.watch(), self._coverer.watch()

        def both(observation: Observation) -> None:
            judged(observation)
            covered(observation)

        return both

    def _end(self) -> CaseEnd:
        tool = self.tool
        state = tool.status.ee.name if HAL in tool.living else ""
        every = list(switchings(self._description, tool.edges))
        return CaseEnd.of(
            self._description, state, every, [each for each in every if each.at >= self._origin]
        )

    # What happens

    def _happen(self) -> None:
        for each in self._case.happenings:
            self._go(self._origin + each.at)
            self._act(each.what)

    def _go(self, at: int) -> None:
        self.tool.run_until(at, self._judge.look)

    def _act(self, what: str) -> None:
        tool, judge = self.tool, self._judge
        verb, _, rest = what.partition(" ")
        self._said.append((tool.at, what))
        if what in COMMANDS:
            self._command(what)
        elif verb == SCENARIO:
            tool.choose(rest)
            judge.suffers(rest)
            self._coverer.suffer(rest)
        elif verb in (KILL, END):
            names = processes(rest)
            if HAL in names:
                judge.hal_dies()
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

    def _command(self, name: str) -> bool:
        tool, at = self.tool, self.tool.at
        if name == "reset":
            return self._reset()
        answer = tool.command(name, self._judge.look)
        self._said.append((tool.at, f"  {name}: {'accepted' if answer.accepted else answer.reason}"))
        self._judge.commanded(name, answer, at)
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
        return is_still(self._description, self.tool)

    def _settle(self) -> None:
        """Wait until nothing moves for a while; dead processes stay dead."""
        tool, durations = self.tool, self._description.durations
        self._until(lambda: not tool.ending, LONGEST_END_US)
        limit = tool.at + (durations.grip_ms + durations.release_ms) * 1000 + MARGIN_US
        if len(tool.living) < 2:
            releases = sum(part.release_s for part in self._description.actuators.values())
            self._go(tool.at + round(releases * 1e6) + 3_000_000)
            self._judge.at_rest(still=True)
            return
        self._go(tool.at + STILL_US)
        while tool.at < limit:
            if not self._until(self._is_still, limit - tool.at):
                break
            before = len(tool.edges), tool.status.ee
            self._go(tool.at + STILL_US)
            if before == (len(tool.edges), tool.status.ee) and self._is_still():
                break
        if tool.status.held:
            self._go(tool.at + round(KNOWN_S * 1e6))
        self._judge.at_rest(still=self._is_still())

    def _use_again(self) -> None:
        """Remove all faults and check that the tool is usable: a reset, a lock, a drop; a grip and a drop."""
        self._said.append((self.tool.at, "everything is put right, and the tool is used again:"))
        disks = [getattr(self.tool.memories, store) for store in STORES]
        well = self.tool.bench.scenario.text == "nominal" and len(self.tool.living) == 2
        well = well and not any(disk.full or disk.fails or disk.hangs for disk in disks)
        for store in STORES if not well else ():
            self._act(f"{DISK} {store} well")
        if not well:
            self._act(f"{SCENARIO} nominal")
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
        if not (reset or self._reset()):  # some trouble ends only with the drop
            return "a reset is refused"
        self._go(tool.at + round(SOON_S * 1e6))
        if not self._command("grip"):
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

    def _log(self) -> tuple[str, ...]:
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
        shown = sorted((line for line in lines if line[0] >= self._origin), key=lambda line: line[0])
        return tuple(f"{(at - self._origin) / 1e6:9.3f} {what}" for at, _, what in shown)


def _changes_of_state(statuses: Sequence[Any]) -> list[Any]:
    return [
        status
        for number, status in enumerate(statuses)
        if number == 0 or status.ee != statuses[number - 1].ee
    ]


def processes(name: str) -> tuple[str, ...]:
    """Return the processes that a word of a case names."""
    return (HAL, ARBITER) if name == ALL else (name,)
