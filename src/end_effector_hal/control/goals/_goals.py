"""The goals of a tool: decided one after the other, begun by a program, and followed to their end. Sans-IO.

Rule 1. Goals are decided in the order of their arrival. A goal that waits for its decision delays only the answers to
the goals behind it.

Rule 2. One goal runs at a time. A second one is refused with a reason; it never ends the first.

Rule 3. Only the automata accept or refuse a goal. A program that does not answer in time may have begun
the goal: the outcome is UNREACHABLE, also for each goal that waited meanwhile. The same holds
while the line arbiter is lost: no goal is begun then.

Rule 4. An accepted goal follows the statuses of the program after the acceptance. It is over when the program no
longer executes a command; it has succeeded only if that status proves it.

Rule 5. If the program has gone, was restarted, or can no longer be observed because this process ends, the end of its
goal is not known: UNREACHABLE.

Rule 6. A goal that is cancelled before its decision is not begun (NOT_EXECUTED). A cancel during the decision is
passed on after the acceptance. Of running goals, a grip is cancelled if its program accepts that; a release and a tool
change are completed.

Rule 7. Every goal gets exactly one ending, with a reason unless it has succeeded; no goal is begun after
`Goals.close`.

Rule 8. A program refuses a goal for a position that is reached already. If the newest status proves the position with
all evidence that counts while no command is executed, that goal has succeeded.
"""

from __future__ import annotations

from typing import Generic

from end_effector_hal.vocabulary import Cause, ChangerState, Command, EndEffectorState, Evidence

from .._status import Answer, Status
from ._goal import Effect, Ending, GoalEffect, GoalT, Outcome, Phase

_WANTED_STATES = {Command.GRIP: EndEffectorState.GRIPPED, Command.RELEASE: EndEffectorState.STAND_BY}
_LOST = "The line arbiter is lost: the outputs are not known."
_WANTED_POSITIONS = {Command.LOCK: ChangerState.LOCKED, Command.UNLOCK: ChangerState.UNLOCKED}
_WANTED_EVIDENCE = {Command.GRIP: Evidence.CONFIRMED, Command.RELEASE: Evidence.GONE}


def is_over(status: Status) -> bool:
    """Return whether a program that had accepted a command no longer executes it."""
    return status.command == Command.NONE


def is_reached(command: Command, status: Status) -> bool:
    """Return whether the sensors prove the result of a grip or a release, and no command is executed.

    A grip is proven by the actuators that grip the part, whose outputs are active; a release by all.
    """
    counts = status.outputs if command is Command.GRIP else (True,) * len(status.evidence)
    proofs = {level for level, active in zip(status.evidence, counts, strict=True) if active}
    return proofs == {_WANTED_EVIDENCE[command]} and is_over(status) and status.ee == _WANTED_STATES[command]


def judge(command: Command, status: Status) -> tuple[Outcome, str]:
    """Return the outcome of a finished command and the reason as a sentence; the sensors decide it.

    While the line arbiter is lost, only what the sensors prove is known.
    """
    if command in _WANTED_POSITIONS:
        reached, position = status.changer, _WANTED_POSITIONS[command]
        if reached is position:
            return Outcome.SUCCEEDED, ""
        if status.arbiter_lost:
            return Outcome.UNREACHABLE, status.changer_reason or _LOST
        why = f"The tool changer is {reached.name}: its sensors do not prove {position.name}."
        return Outcome.FAILED, f"{why} {status.changer_reason}".rstrip()
    if status.ee == _WANTED_STATES[command]:
        return Outcome.SUCCEEDED, ""
    if status.arbiter_lost and status.ee != EndEffectorState.STAND_BY:
        return Outcome.UNREACHABLE, status.reason or _LOST
    cancelled = command is Command.GRIP and status.cause == Cause.CANCELLED
    reason = status.reason or f"The end-effector is {status.ee.name}."
    return (Outcome.CANCELLED if cancelled else Outcome.FAILED), reason


ANSWER_US = 4_000_000
"""Longest wait for a program's answer, µs; longer than an unlock's proof and a program's turn take."""
REACHED = "It was reached already: nothing was commanded."
NOT_BEGUN = "The goal was cancelled before it was begun: it was not executed."
_UNKNOWN = "it is unknown whether the command was executed. Read the state before the next one."


class Goals(Generic[GoalT]):
    """Applies the rules of this module. Each method returns the actions for the caller, in order.

    Times are µs on the monotonic clock.

    Args:
        program: the name of the program at the beginning of a sentence.
    """

    def __init__(self, program: str) -> None:
        self._program = program
        self._undecided: list[GoalT] = []
        self._running: GoalT | None = None
        self._newest: Status | None = None
        self._closing = ""

    @property
    def open(self) -> tuple[GoalT, ...]:
        """The goals without an ending."""
        return (*self._undecided, *((self._running,) if self._running else ()))

    def begin(self, goal: GoalT, at: int) -> list[GoalEffect[GoalT]]:
        """Add a goal that arrived."""
        goal.came_us = at
        if self._closing:
            return [self._end(goal, Outcome.REJECTED, self._closing, at)]
        self._undecided.append(goal)
        return self._decide(at)

    def answer(self, goal: GoalT, answer: Answer, at: int) -> list[GoalEffect[GoalT]]:
        """Process the answer of a goal's program."""
        if goal.phase is not Phase.ASKED:
            return []  # it was given up
        self._undecided.remove(goal)
        if not answer.accepted:
            newest = self._newest
            meant = goal.command is not Command.GRIP or (newest and goal.part in ("", newest.part))
            if answer.decided and goal.is_target and newest and meant and is_reached(goal.command, newest):
                return [self._end(goal, Outcome.SUCCEEDED, REACHED, at), *self._decide(at)]
            outcome = Outcome.REJECTED if answer.decided else Outcome.UNREACHABLE
            return [*self._refuse(goal, outcome, answer.reason, at), *self._decide(at)]
        goal.phase, goal.count, self._running = Phase.RUNNING, answer.count, goal
        effects = [(Effect.REPORT_BEGIN, goal), *self._follow(at)]
        return [*effects, *(self.cancel(goal) if goal.cancelled else []), *self._decide(at)]

    def cancel(self, goal: GoalT) -> list[GoalEffect[GoalT]]:
        """Cancel a goal on request of its client."""
        goal.cancelled = True
        return [(Effect.CANCEL, goal)] if goal is self._running and goal.command is Command.GRIP else []

    def see(self, status: Status, at: int) -> list[GoalEffect[GoalT]]:
        """Process a new status at the time ``at``, µs."""
        self._newest = status
        return self._follow(at)

    def tick(self, at: int, *, gone: bool = False) -> list[GoalEffect[GoalT]]:
        """Process the passing of time; ``gone``: the program no longer runs."""
        effects: list[GoalEffect[GoalT]] = []
        for goal in self._undecided[:1]:
            if goal.phase is Phase.ASKED and at - goal.asked_us > ANSWER_US:
                silence = f"{self._program} does not answer."
                effects.append((Effect.GIVE_UP, goal))
                effects += self.answer(goal, Answer(False, silence, decided=False), at)
        if (running := self._running) is None:
            return effects
        if not gone:
            return [*effects, (Effect.REPORT_PROGRESS, running)]
        why = f"{self._program} has gone: {_UNKNOWN}"
        return [*effects, self._end(running, Outcome.UNREACHABLE, why, at)]

    def close(self, who: str, todo: str, at: int) -> list[GoalEffect[GoalT]]:
        """End every goal, because this process ends.

        Args:
            who: this process in a sentence.
            todo: a hint for the client of a running goal.
            at: the time now, µs.
        """
        self._closing = f"{who} is ending: the goal was not begun."
        undecided, self._undecided = self._undecided, []
        effects: list[GoalEffect[GoalT]] = []
        for goal in undecided:
            if goal.phase is Phase.ASKED:
                answer = f"{self._program} has not answered yet: whether the goal was begun is unknown."
                effects.append(self._end(goal, Outcome.UNREACHABLE, f"{who} is ending. {answer}", at))
            else:
                effects.append(self._end(goal, Outcome.REJECTED, self._closing, at))
        if (running := self._running) is not None:
            why = f"{who} is ending while {running.name} was at work, and does not see its end. {todo}"
            effects.append(self._end(running, Outcome.UNREACHABLE, why, at))
        return effects

    def _decide(self, at: int) -> list[GoalEffect[GoalT]]:
        """Decide about the waiting goals until a program must be asked."""
        effects: list[GoalEffect[GoalT]] = []
        while self._undecided and self._undecided[0].phase is Phase.WAITING:
            goal, running = self._undecided[0], self._running
            if goal.cancelled:
                ending = Outcome.NOT_EXECUTED, NOT_BEGUN
            elif running is not None:
                todo = "Cancel it, or wait" if running.command is Command.GRIP else "Wait"
                why = f"{running.name} is still running: one goal at a time. {todo} for its end."
                ending = Outcome.REJECTED, why
            else:
                goal.phase, goal.asked_us = Phase.ASKED, at
                if self._newest:
                    goal.session = self._newest.begun
                return [*effects, (Effect.ASK, goal)]
            self._undecided.remove(goal)
            effects.append(self._end(goal, *ending, at))
        return effects

    def _refuse(self, goal: GoalT, outcome: Outcome, reason: str, at: int) -> list[GoalEffect[GoalT]]:
        alike = [goal]
        if outcome is Outcome.UNREACHABLE:
            alike += [each for each in self._undecided if each is not goal and not each.cancelled]
            self._undecided = [each for each in self._undecided if each not in alike]
        return [self._end(each, outcome, reason, at) for each in alike]

    def _follow(self, at: int) -> list[GoalEffect[GoalT]]:
        running, status = self._running, self._newest
        if running is None or status is None:
            return []
        if running.session not in (0, status.begun):
            why = f"{self._program} was started again: {_UNKNOWN}"
            return [self._end(running, Outcome.UNREACHABLE, why, at)]
        if status.count < running.count:
            return []
        ends = [self._end(running, *judge(running.command, status), at)] if is_over(status) else []
        return [(Effect.REPORT_PROGRESS, running), *ends]

    def _end(self, goal: GoalT, outcome: Outcome, reason: str, at: int) -> GoalEffect[GoalT]:
        seconds = (at - goal.came_us) / 1e6 if goal.phase is Phase.RUNNING else None
        goal.phase, goal.ending = Phase.ENDED, Ending(outcome, reason, seconds)
        if goal is self._running:
            self._running = None
        return Effect.REPORT_END, goal
