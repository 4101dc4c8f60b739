"""What must hold whatever the link does; each violation is a sentence with its time."""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_hal.control import Answer, Status
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState, Evidence
from end_effector_lab.testbench import Bench
from tests.acceptance.link_campaign.faults import LinkFault
from tests.acceptance.link_campaign.oracle import Oracle

STALE_US = 150_000
SAMPLES_US = 80_000
"""A threshold takes three samples, and the one in which it changed."""
FROZEN_US = 2_000_000


class Judge:
    """Watches one tool.

    Promised for exchanged sensors: GRIPPED is true all the same. A single step may be taken for another.
    Promised for frozen ones: they are believed for two seconds at most.
    A machine that stands still moves neither the devices nor what is said of them: that time is not counted.

    Args:
        description: the tool.
        bench: the devices that it has.
        late_us: how late a status may be told.
    """

    def __init__(self, description: Description, bench: Bench, *, late_us: int = 0) -> None:
        self.violations: list[str] = []
        self.false_confirmations = 0
        self.confirmations = 0
        self.oracle = Oracle(description, bench, FROZEN_US + STALE_US + SAMPLES_US + late_us)
        self._late_us = late_us
        self._names = description.sequence
        self._gripping = {actuator.line for _, actuator in description.ordered}
        self._held = False
        self._last: Status | None = None
        self._swapped_until = 0
        self._frozen_until: dict[str, int] = {}
        self._awaiting = False
        self._false: frozenset[str] = frozenset()

    def fault(self, fault: LinkFault, at: int) -> None:
        """A fault begins."""
        end = at + round(fault.seconds * 1e6)
        if fault.kind == "swapped channels":
            self._swapped_until = max(self._swapped_until, end)
        if fault.kind == "frozen sensor":
            self._frozen_until[fault.who] = end

    def asked(self, name: str) -> tuple[bool, bool]:
        """A command is given: from here on it counts as accepted, for it has its effect before it is answered."""
        before = (self._held, self._awaiting)
        if name == "drop":
            self._held = self._awaiting = False
        if name == "grip":
            self._awaiting = True
        return before

    def answered(self, name: str, answer: Answer, before: tuple[bool, bool], at: int) -> None:
        """It was answered; if it was refused it had no effect."""
        if not answer.accepted:
            self._held, self._awaiting = before
            if not answer.reason:
                self._say(at, f"{name} was refused without a reason")

    def edge(self, line: str, level: bool, at: int) -> None:
        """A line was written."""
        if self._held and not level and line in self._gripping:
            self._say(at, f"{line} went inactive while a part was held")

    def status(self, status: Status) -> None:
        """A status of the program."""
        last, self._last = self._last, status
        before = last.evidence if last else (0,) * len(self._names)
        for was, level in zip(before, status.evidence, strict=True):
            self.confirmations += level == Evidence.CONFIRMED != was
        self.claims(status.at)
        if status.ee == EndEffectorState.GRIPPED and (last is None or last.ee != status.ee):
            self._held, self._awaiting = True, False
            self._confirmed(status.at, self._names, "GRIPPED, and not everything is there")
        if last and last.ee == EndEffectorState.RELEASING and status.ee == EndEffectorState.STAND_BY:
            there = [n for n in self._names if not self.oracle.gone((n,), self._since(n, status.at))]
            if there:
                told = f"evidence {status.evidence}, last look {self.oracle.newest / 1e6:.3f} s"
                self._say(status.at, f"STAND_BY, and {', '.join(there)} not gone: {told}")
            if self._awaiting and not status.reason:
                self._say(status.at, "a grip has failed without a reason")
            self._awaiting = False
        self._explained(status)

    def claims(self, at: int) -> None:
        """What is said to be confirmed at ``at`` µs, newly or still, is there: never the last value."""
        if self._last is None or at <= self._swapped_until + STALE_US:
            return
        for name, level in zip(self._names, self._last.evidence, strict=True):
            false = level == Evidence.CONFIRMED and not self.oracle.confirmed((name,), self._since(name, at))
            if false and name not in self._false:
                self.false_confirmations += 1
                self._say(at, f"{name} is said to be confirmed, and is not")
            self._false = self._false | {name} if false else self._false - {name}

    def _explained(self, status: Status) -> None:
        state = EndEffectorState(status.ee)
        passing = state is EndEffectorState.GRIP_ERROR and status.command == Command.RELEASE
        if state in (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR) and not status.reason:
            self._say(status.at, f"{state.name} without a reason")
        latched = state in (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR) and not passing
        unknown = Evidence.UNKNOWN in status.evidence and state is not EndEffectorState.OFF
        if (latched or unknown) and not status.alarm_texts:
            self._say(status.at, f"{state.name}, evidence {status.evidence}, and no alarm")
        if status.lift_allowed and status.evidence != (Evidence.CONFIRMED,) * len(self._names):
            self._say(status.at, "lifting is allowed without evidence")
        if status.changer == ChangerState.FAULT and not (status.alarm_texts or status.changer_reason):
            self._say(status.at, "the tool changer is in FAULT and nobody says why")

    def _since(self, name: str, at: int) -> int:
        frozen = at <= self._frozen_until.get(name, -1) + STALE_US
        still_us = self.oracle.stood_still_us(at, self._late_us) if self._late_us else 0
        return at - STALE_US - SAMPLES_US - self._late_us - still_us - (FROZEN_US if frozen else 0)

    def _confirmed(self, at: int, names: tuple[str, ...], what: str) -> None:
        if not all(self.oracle.confirmed((name,), self._since(name, at)) for name in names):
            self.false_confirmations += 1
            self._say(at, what)

    def _say(self, at: int, what: str) -> None:
        self.violations.append(f"{at / 1e6:.3f} s: {what}")


def undetected(
    sent: Mapping[int, Mapping[str, object]], seq: int | None, values: Mapping[str, object]
) -> bool:
    """Whether a frame was delivered that nobody sent."""
    return seq is None or sent.get(seq) != values
