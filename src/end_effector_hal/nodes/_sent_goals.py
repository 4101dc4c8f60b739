"""Send goals to the four actions, and describe in words how each ended."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial

from end_effector_hal.control.goals import Outcome
from end_effector_hal.errors import RosError
from end_effector_hal.vocabulary import Command, EndEffectorState

from .interface import COMMAND_ACTIONS, GIVE_UP_S, PATIENCE_S
from .transport import FeedbackMessage, GoalMessage, NodeTransport, ResultMessage, StepMessage

_SILENT_S = 2.0
"""Silence of HALMain after which a message says that the goal waits for it, s; HALMain publishes its state 10 times a
second.
"""

_OUTCOMES = {each.value: each.name for each in Outcome}
_NOT_BEGUN = (Outcome.REJECTED, Outcome.NOT_EXECUTED)


class SentGoal:
    """A goal that was sent; ``succeeded`` is None until it has ended.

    Attributes:
        name: name of its command, and of the part that a grip is for.
        session: the start of HALMain (µs, its clock) when the goal was sent; None: it was unknown.
    """

    def __init__(self, name: str, session: int | None) -> None:
        self.name, self.session = name, session
        self.succeeded: bool | None = None
        self.ended = threading.Event()
        self.sent_at = time.monotonic()
        self._shown: tuple[int, str, int] | None = None

    def fed(self, feedback: FeedbackMessage) -> str:
        """Return the news of a feedback in words; empty: there are none."""
        shown = (feedback.state, feedback.actuator, feedback.attempt)
        if shown == self._shown:
            return ""
        self._shown = shown
        step = f", {feedback.actuator}" if feedback.actuator else ""
        attempt = (
            f", attempt {feedback.attempt} of {feedback.attempts_allowed}" if feedback.attempt > 1 else ""
        )
        return f"{self.name}: {EndEffectorState(feedback.state).name}{step}{attempt}"

    def end(self, result: ResultMessage, succeeded: bool) -> str:
        """Store the result, and return it in words."""
        outcome = _OUTCOMES.get(result.outcome, "FAILED")
        self.succeeded = succeeded and outcome == "SUCCEEDED"
        if result.outcome in _NOT_BEGUN or (result.outcome == Outcome.UNREACHABLE and not result.seconds):
            return f"{self.name}: {outcome}. {result.reason}".rstrip()
        state = EndEffectorState(result.state).name
        steps = "; ".join(_step(step) for step in result.steps if step.attempts)
        reason = f" {result.reason}" if result.reason and not self.succeeded else ""
        tail = reason + (f" [{steps}]" if steps else "")
        return f"{self.name}: {outcome} after {result.seconds:.2f} s, the end-effector is {state}.{tail}"

    def lose(self, why: str) -> str:
        """Abandon the goal, and return a sentence about it."""
        self.succeeded = False
        return f"{self.name}: UNREACHABLE. {why}: what became of it is unknown, see EndEffectorState."


class GoalClients:
    """Clients of all actions.

    Args:
        node: the transport that creates the clients.
        say: called with each sentence about a goal, also in threads of the node.
    """

    def __init__(self, node: NodeTransport, say: Callable[[str], None]) -> None:
        self._node, self._say = node, say
        self._clients = {action.command: node.action_client(action) for action in COMMAND_ACTIONS}
        self._sent: list[SentGoal] = []
        self._lock = threading.Lock()
        self._seen: tuple[int | None, float] = (None, 0.0)

    def seen(self, session: int) -> None:
        """Note that HALMain has published its state; ``session`` is its start."""
        self._seen = session, time.monotonic()

    @property
    def any_failed(self) -> bool:
        """Whether any goal has ended without success."""
        return any(goal.succeeded is False for goal in self._sent)

    def wait_for_servers(self) -> None:
        """Wait until every action server is available, with a message; raises RosError after 30 s."""
        if self._up(1.0):
            return
        self._say(f"waiting for the actions {', '.join(action.name for action in COMMAND_ACTIONS)} …")
        if not self._up(GIVE_UP_S - 1.0) and not self._node.ending:
            raise RosError(
                f"The actions of HALMain did not come up within {GIVE_UP_S:g} s.",
                todo="Are the nodes running, in this namespace?",
            )

    def send(self, command: Command, part: str = "") -> SentGoal:
        """Send a goal; its progress and its end are reported with `say`. ``part``: what is to be gripped."""
        goal = SentGoal(f"{command.name.lower()} {part}".rstrip(), self._seen[0])
        self._sent.append(goal)
        self._clients[command].send(GoalMessage(part), partial(self._fed, goal), partial(self._ended, goal))
        return goal

    def wait(self, goal: SentGoal) -> None:
        """Wait until a goal has ended, or until HALMain is gone, hangs, or was restarted."""
        said = False
        while not goal.ended.wait(0.1) and not self._node.ending:
            session, at = self._seen
            silent_s = time.monotonic() - max(at, goal.sent_at)
            if silent_s > PATIENCE_S:
                self._lose(goal, f"HALMain was silent for {PATIENCE_S:g} s")
            elif silent_s > _SILENT_S:
                if not said:
                    self._say(f"{goal.name}: HALMain is silent; waiting for it, {PATIENCE_S:g} s at most …")
                said = True
            elif at > goal.sent_at:
                said, goal.session = False, session if goal.session is None else goal.session
                if session != goal.session:
                    self._lose(goal, "HALMain was restarted and has lost this goal")

    def cancel(self) -> bool:
        """Cancel every running goal of any client; return whether a goal of this client is running."""
        for client in self._clients.values():
            client.cancel_all()
        return any(not goal.ended.is_set() for goal in self._sent)

    def wait_for_all(self) -> None:
        """Wait until no goal of this client is running."""
        for goal in self._sent:
            self.wait(goal)

    def _fed(self, goal: SentGoal, feedback: FeedbackMessage) -> None:
        if text := goal.fed(feedback):
            self._say(text)

    def _ended(self, goal: SentGoal, result: ResultMessage | None, succeeded: bool) -> None:
        if result is None:
            self._lose(goal, "HALMain was restarted and has lost this goal")
        else:
            self._end(goal, lambda: goal.end(result, succeeded))

    def _lose(self, goal: SentGoal, why: str) -> None:
        self._end(goal, lambda: goal.lose(why))

    def _end(self, goal: SentGoal, words: Callable[[], str]) -> None:
        with self._lock:
            if not goal.ended.is_set():
                self._say(words())
                goal.ended.set()  # only after the report: a waiting thread continues at once, perhaps to its end

    def _up(self, timeout_s: float) -> bool:
        end = time.monotonic() + timeout_s
        while not all(client.is_ready() for client in self._clients.values()):
            if time.monotonic() > end or self._node.ending:
                return False
            time.sleep(0.05)
        return True


def _step(step: StepMessage) -> str:
    attempts = f", attempt {step.attempts}" if step.attempts > 1 else ""
    return f"{step.actuator} {step.seconds:.2f} s{attempts}{'' if step.confirmed else ', not confirmed'}"
