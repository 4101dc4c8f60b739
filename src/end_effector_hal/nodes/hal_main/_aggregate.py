"""From the messages of the nodes to one state of the end-effector."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from math import nan

from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.nodes.interface import GRIP, STARTING_S, TOOL_CHANGE, actuator_joints
from end_effector_hal.nodes.transport import StateMessage, StatusMessage
from end_effector_hal.vocabulary import (
    Alarm,
    Cause,
    ChangerState,
    Command,
    EndEffectorState,
    Evidence,
    distinct,
    received_alarms,
)

from ._margins import Margins
from ._positions import Positions
from ._silence import Silence

CHANGER, STAND = "tool_changer", "tool_stand"


class Aggregate:
    """Puts the latest statuses of both programs together.

    While the node Grip is silent the state is OFF, the evidence UNKNOWN, and nothing may be lifted. Its outputs and
    ``held`` stay as they were last known: the line arbiter holds what was held. That a node is silent is an
    alarm; that one has never reported, only when HALMain itself has been there for `STARTING_S`.
    """

    def __init__(
        self, description: Description, margins: Margins, positions: Positions, since_us: int
    ) -> None:
        self._since_us = since_us
        self._description, self._margins, self._positions = description, margins, positions
        self._kinds = [part.kind for _, part in description.ordered]
        self._states = [kind_of(part).states for _, part in description.ordered]
        count = len(description.sequence)
        joints = {joint.actuator: joint for joint in actuator_joints(description)}
        self._joints = [joints.get(name) for name in description.sequence]
        nothing = StatusMessage(actuators=[0] * count, outputs=[False] * count, evidence=[0] * count)
        self.grip = self.tool_change = nothing

    def message(
        self, at_us: int, now_us: int, silence: Silence, notices: Sequence[Alarm] = ()
    ) -> StateMessage:
        """The state after a change at ``at_us``, without a number; ``notices`` are alarms of HALMain itself."""
        gone = silence.silent(now_us)
        grip, change, sequence = self.grip, self.tool_change, self._description.sequence
        lost = GRIP in gone
        starting = now_us - self._since_us < STARTING_S * 1e6
        absent = [
            Alarm("node.silent" if silence.has_reported(name) else "node.awaited", name)
            for name in gone
            if silence.has_reported(name) or not starting
        ]
        told = (received_alarms(each.alarms, each.alarm_ids) for each in (grip, change))
        alarms = distinct((*absent, *notices, *(alarm for each in told for alarm in each)))
        deadline = grip.deadline_us
        state, command = EndEffectorState.OFF if lost else grip.state, self._command(gone)
        evidence = [Evidence.UNKNOWN] * len(sequence) if lost else grip.evidence
        changer = ChangerState.UNKNOWN if TOOL_CHANGE in gone else change.tool_changer
        position, stand = self._positions.place(CHANGER, now_us), self._positions.place(STAND, now_us)
        return StateMessage(
            since_us=self._since_us,
            count=0,
            at_us=at_us,
            tool=self._description.name,
            state=state,
            state_name=_name(EndEffectorState, state),
            command=command,
            command_name=_name(Command, command),
            actuator_names=sequence,
            actuator_kinds=self._kinds,
            actuators=grip.actuators,
            actuator_states=[
                _name(states, state) for states, state in zip(self._states, grip.actuators, strict=False)
            ],
            outputs=grip.outputs,
            evidence=evidence,
            evidence_names=[_name(Evidence, each) for each in evidence],
            margins=self._margins.values(grip.stale if grip.link_up and not lost else None),
            margin_units=["Pa"] * len(sequence),
            positions=[joint.position(evidence) if joint else nan for joint in self._joints],
            actuator="" if lost or grip.step < 0 else sequence[grip.step],
            attempt=grip.attempt,
            attempts_allowed=grip.attempts_allowed,
            time_left_s=nan if lost or deadline < 0 else max(0, deadline - now_us) / 1e6,
            steps=grip.steps,
            cause=grip.cause,
            cause_name=_name(Cause, grip.cause),
            cause_actuator=sequence[grip.cause_at] if grip.cause_at >= 0 else "",
            reason=grip.reason,
            held=grip.held,
            lift_allowed=grip.lift_allowed and not lost,
            secure=grip.secure and not lost,
            maintenance=grip.maintenance and not lost,
            tool_changer=changer,
            tool_changer_name=_name(ChangerState, changer),
            unlock_output=change.unlock_output,
            tool_position=position,
            tool_position_name=position.name,
            tool_stand=stand,
            tool_stand_name=stand.name,
            link_up=grip.link_up and not lost,
            stale=grip.stale,
            missed=grip.missed + change.missed,
            worst_late_us=max(grip.worst_late_us, change.worst_late_us),
            alarms=[*map(str, alarms)],
            alarm_ids=[alarm.name for alarm in alarms],
        )  # fmt: skip

    def _command(self, gone: Sequence[str]) -> int:
        """One command runs at a time: gripping and the tool changer exclude each other (IL-01, IL-05)."""
        if GRIP not in gone and self.grip.command != Command.NONE:
            return int(self.grip.command)
        return int(Command.NONE if TOOL_CHANGE in gone else self.tool_change.command)


def _name(words: type[IntEnum], value: int) -> str:
    """The name of an integer that another node sent; one that is none of ours stands for itself."""
    try:
        return words(value).name
    except ValueError:
        return str(value)
