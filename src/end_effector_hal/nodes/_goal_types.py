"""The goals of each action: which command a goal requests, and its feedback and result messages."""

from __future__ import annotations

import logging
from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import isnan, nan
from typing import Any

from end_effector_hal.control.goals import Ending, Outcome
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import LONGEST_NAME, Command, EndEffectorState, printable

from .interface import (
    COMMAND_ACTIONS,
    GRIP_UPPER,
    GRIPPER_COMMAND,
    PARALLEL_GRIPPER_COMMAND,
    Action,
    CommandAction,
    grip_joint,
    grip_position,
)
from .transport import (
    FeedbackMessage,
    GripperMessage,
    JointStateMessage,
    ParallelGripperMessage,
    ResultMessage,
    StateMessage,
)

TOLERANCE = 0.01
"""Allowed deviation of a requested position, rad; a planner ends its trajectory near that position, not
exactly at it.
"""


class GoalType(ABC):
    """The goals of one action.

    Attributes:
        action: the action of the interface table.
        says_why: whether its result has a field for a reason; if not, only the log contains it.
        is_target: whether its goals request a position, which may be reached already.
    """

    action: Action
    says_why = True
    is_target = False

    @abstractmethod
    def command(self, request: Any) -> Command | str:
        """Return the command that a goal requests; a text: why it is refused."""

    def part(self, request: Any) -> str:
        """Return the name of the part that a goal is for; empty: the default one."""
        del request
        return ""

    @abstractmethod
    def feedback(self, state: StateMessage) -> Any:
        """Return the feedback of a running goal."""

    @abstractmethod
    def result(self, state: StateMessage, ending: Ending, command: Command | None) -> Any:
        """Return the result at the end; ``command`` is the requested one, None: the request was not understood."""


class CommandGoals(GoalType):
    """Goals of the four actions; a grip may name a part."""

    def __init__(self, action: CommandAction) -> None:
        self.action, self._command = action, action.command

    def command(self, request: Any) -> Command | str:
        """Return the command of the action."""
        if request.part and self._command is not Command.GRIP:
            return f"Only a grip is for a part: {self.action.name} needs an empty `part`."
        return self._command

    def part(self, request: Any) -> str:
        """Return the name of the part, bounded; the HAL refuses a name that no part has."""
        return printable(request.part, LONGEST_NAME)

    def feedback(self, state: StateMessage) -> FeedbackMessage:
        """Return the current step."""
        return FeedbackMessage(
            state=state.state,
            state_name=state.state_name,
            actuator=state.actuator,
            attempt=state.attempt if state.state == EndEffectorState.GRIPPING else 0,
            attempts_allowed=state.attempts_allowed,
            time_left_s=state.time_left_s,
        )

    def result(self, state: StateMessage, ending: Ending, command: Command | None) -> ResultMessage:
        """Return the outcome in words; for a grip also its steps."""
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
    """Goals for a position of the tool's joint: 0 grips the default part, its upper limit drops, others are refused.

    ``reached_goal``: the sensors prove the requested position. ``stalled``: they prove a grip, so that something is
    held. Neither is ever true for a goal that did not succeed. Efforts and speeds are ignored.
    """

    says_why = False
    is_target = True

    def __init__(self, action: Action, description: Description, log: logging.Logger) -> None:
        self.action, self._description, self._log = action, description, log
        self._ignored_told = False

    def part(self, request: Any) -> str:
        """Return the default part: what else is held is not what this goal asks for."""
        del request
        return self._description.part_names[0]

    def _of_position(self, position: float, ignored: str, values: Sequence[float]) -> Command | str:
        if abs(position) <= TOLERANCE:
            command = Command.GRIP
        elif abs(position - GRIP_UPPER) <= TOLERANCE:
            command = Command.RELEASE
        else:
            return f"The position {position:g} is not valid for this tool: 0 grips, {GRIP_UPPER:g} drops."
        if any(values) and not self._ignored_told:
            self._ignored_told = True
            self._log.info(
                "%s: %s ignored: the air sets force and speed. Logged once.", self.action.name, ignored
            )
        return command

    def _position(self, state: StateMessage) -> float:
        return grip_position(state.evidence, self._description.uses(state.part))

    @staticmethod
    def _proof(ending: Ending, command: Command | None) -> tuple[bool, bool]:
        """Return the values of ``stalled`` and ``reached_goal``."""
        reached = ending.outcome is Outcome.SUCCEEDED
        return reached and command is Command.GRIP, reached


class GripperGoals(_JointGoals):
    """Goals of ``control_msgs/GripperCommand``."""

    def command(self, request: Any) -> Command | str:
        """Return the command for ``position``."""
        asked = request.command
        return self._of_position(asked.position, "max_effort is", (asked.max_effort,))

    def feedback(self, state: StateMessage) -> GripperMessage:
        """Return the position of the joint."""
        return GripperMessage(self._position(state))

    def result(self, state: StateMessage, ending: Ending, command: Command | None) -> GripperMessage:
        """Return the position of the joint, and whether it was reached."""
        return GripperMessage(self._position(state), nan, *self._proof(ending, command))


class ParallelGripperGoals(_JointGoals):
    """Goals of ``control_msgs/ParallelGripperCommand``.

    Args:
        action: the action of the interface table.
        description: the tool; its goals may name the joint that represents the whole tool.
        log: logs which values are ignored.
    """

    def __init__(self, action: Action, description: Description, log: logging.Logger) -> None:
        super().__init__(action, description, log)
        self._joint = grip_joint(description)

    def command(self, request: Any) -> Command | str:
        """Return the command for the position of the one joint that the goal names."""
        asked = request.command
        if list(asked.name[:2]) != [self._joint] or len(asked.position) != 1:
            names = printable(", ".join(asked.name[:2]), LONGEST_NAME) or "no joint"
            found = f"{len(asked.name)} names ({names}) and {len(asked.position)} positions"
            return f"The goal has {found}, expected are one position of {self._joint}."
        return self._of_position(
            asked.position[0], "velocity and effort are", (*asked.velocity, *asked.effort)
        )

    def feedback(self, state: StateMessage) -> ParallelGripperMessage:
        """Return the position of the joint; the joint is left out if its position is unknown."""
        return ParallelGripperMessage(self._joint_state(state))

    def result(self, state: StateMessage, ending: Ending, command: Command | None) -> ParallelGripperMessage:
        """Return the position of the joint, and whether it was reached."""
        return ParallelGripperMessage(self._joint_state(state), *self._proof(ending, command))

    def _joint_state(self, state: StateMessage) -> JointStateMessage:
        position = self._position(state)
        known = {} if isnan(position) else {self._joint: position}
        return JointStateMessage(list(known), list(known.values()))


def goal_types(description: Description, log: logging.Logger) -> tuple[GoalType, ...]:
    """Return the goals of all actions that HALMain serves if its transport offers them."""
    return (
        *(CommandGoals(action) for action in COMMAND_ACTIONS),
        GripperGoals(GRIPPER_COMMAND, description, log),
        ParallelGripperGoals(PARALLEL_GRIPPER_COMMAND, description, log),
    )
