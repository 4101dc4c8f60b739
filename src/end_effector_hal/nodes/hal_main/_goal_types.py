"""How the clients of each action speak: what a goal of it asks for, and what they are told of it."""

from __future__ import annotations

import logging
from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import isnan, nan
from typing import Any

from end_effector_hal.control.goals import Ending, Outcome
from end_effector_hal.description import Description
from end_effector_hal.nodes.interface import (
    COMMAND_ACTIONS,
    GRIP_UPPER,
    GRIPPER_COMMAND,
    PARALLEL_GRIPPER_COMMAND,
    Action,
    CommandAction,
    grip_joint,
    grip_position,
)
from end_effector_hal.nodes.transport import (
    FeedbackMessage,
    GripperMessage,
    JointStateMessage,
    ParallelGripperMessage,
    ResultMessage,
    StateMessage,
)
from end_effector_hal.vocabulary import Command, EndEffectorState, printable

TOLERANCE = 0.01
"""rad; a planner ends its trajectory near the position that it was asked for."""
LONGEST_NAME = 100


class GoalType(ABC):
    """The goals of one action.

    Attributes:
        action: of the table.
        says_why: whether its result has a place for a reason; if not, the log is the only one.
        is_target: whether its goals ask for a position, which may be reached already.
    """

    action: Action
    says_why = True
    is_target = False

    @abstractmethod
    def command(self, request: Any) -> Command | str:
        """What a goal asks for; a text: why it is refused."""

    @abstractmethod
    def feedback(self, state: StateMessage) -> Any:
        """What is told while a goal runs."""

    @abstractmethod
    def result(self, state: StateMessage, ending: Ending, command: Command | None) -> Any:
        """What is told at its end; ``command``: what it asked for, None: that was not understood."""


class CommandGoals(GoalType):
    """Goals without options."""

    def __init__(self, action: CommandAction) -> None:
        self.action, self._command = action, action.command

    def command(self, request: Any) -> Command:
        """The one of the action."""
        return self._command

    def feedback(self, state: StateMessage) -> FeedbackMessage:
        """The step at work."""
        return FeedbackMessage(
            state=state.state,
            state_name=state.state_name,
            actuator=state.actuator,
            attempt=state.attempt if state.state == EndEffectorState.GRIPPING else 0,
            attempts_allowed=state.attempts_allowed,
            time_left_s=state.time_left_s,
        )

    def result(self, state: StateMessage, ending: Ending, command: Command | None) -> ResultMessage:
        """The outcome in words; the steps of a grip."""
        begun = ending.seconds is not None
        return ResultMessage(
            outcome=ending.outcome,
            outcome_name=ending.outcome.name,
            state=state.state,
            state_name=state.state_name,
            reason=ending.reason,
            seconds=ending.seconds or 0.0,
            steps=state.steps if begun and command is Command.GRIP else [],
        )


class _JointGoals(GoalType):
    """Goals that ask for a position of the tool's joint: 0 grips, its upper limit drops, nothing else is known.

    ``reached_goal``: the sensors prove what was asked for. ``stalled``: they prove a grip, so that something is held.
    Neither is ever true of a goal that did not succeed. Efforts and speeds are not ours to choose.
    """

    says_why = False
    is_target = True

    def __init__(self, action: Action, log: logging.Logger) -> None:
        self.action, self._log = action, log
        self._ignored_told = False

    def _of_position(self, position: float, ignored: str, values: Sequence[float]) -> Command | str:
        if abs(position) <= TOLERANCE:
            command = Command.GRIP
        elif abs(position - GRIP_UPPER) <= TOLERANCE:
            command = Command.RELEASE
        else:
            return f"The position {position:g} is none of this tool: 0 grips, {GRIP_UPPER:g} drops."
        if any(values) and not self._ignored_told:
            self._ignored_told = True
            self._log.info("%s: %s ignored: the air decides. Logged once.", self.action.name, ignored)
        return command

    @staticmethod
    def _proof(ending: Ending, command: Command | None) -> tuple[bool, bool]:
        """Stalled, and reached_goal."""
        reached = ending.outcome is Outcome.SUCCEEDED
        return reached and command is Command.GRIP, reached


class GripperGoals(_JointGoals):
    """``control_msgs/GripperCommand``."""

    def command(self, request: Any) -> Command | str:
        """By ``position``."""
        asked = request.command
        return self._of_position(asked.position, "max_effort is", (asked.max_effort,))

    def feedback(self, state: StateMessage) -> GripperMessage:
        """Where the joint stands."""
        return GripperMessage(grip_position(state.evidence))

    def result(self, state: StateMessage, ending: Ending, command: Command | None) -> GripperMessage:
        """Whether it was reached."""
        return GripperMessage(grip_position(state.evidence), nan, *self._proof(ending, command))


class ParallelGripperGoals(_JointGoals):
    """``control_msgs/ParallelGripperCommand``.

    Args:
        action: of the table.
        joint: the one that its goals may name.
        log: is told what is ignored.
    """

    def __init__(self, action: Action, joint: str, log: logging.Logger) -> None:
        super().__init__(action, log)
        self._joint = joint

    def command(self, request: Any) -> Command | str:
        """By the position of the one joint that it names."""
        asked = request.command
        if list(asked.name[:2]) != [self._joint] or len(asked.position) != 1:
            names = printable(", ".join(asked.name[:2]), LONGEST_NAME) or "no joint"
            found = f"{len(asked.name)} names ({names}) and {len(asked.position)} positions"
            return f"The goal has {found}, expected are one position of {self._joint}."
        return self._of_position(
            asked.position[0], "velocity and effort are", (*asked.velocity, *asked.effort)
        )

    def feedback(self, state: StateMessage) -> ParallelGripperMessage:
        """Where the joint stands; without it where that is not known."""
        return ParallelGripperMessage(self._joint_state(state))

    def result(self, state: StateMessage, ending: Ending, command: Command | None) -> ParallelGripperMessage:
        """Whether it was reached."""
        return ParallelGripperMessage(self._joint_state(state), *self._proof(ending, command))

    def _joint_state(self, state: StateMessage) -> JointStateMessage:
        position = grip_position(state.evidence)
        known = {} if isnan(position) else {self._joint: position}
        return JointStateMessage(list(known), list(known.values()))


def goal_types(description: Description, log: logging.Logger) -> tuple[GoalType, ...]:
    """All that HALMain serves, as far as its transport offers it."""
    return (
        *(CommandGoals(action) for action in COMMAND_ACTIONS),
        GripperGoals(GRIPPER_COMMAND, log),
        ParallelGripperGoals(PARALLEL_GRIPPER_COMMAND, grip_joint(description), log),
    )
