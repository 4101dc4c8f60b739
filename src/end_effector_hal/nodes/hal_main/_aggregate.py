"""Build one state of the end-effector from the messages of the nodes: the status of the program, positions,
margins, and the silence of Grip.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from enum import IntEnum
from math import nan

from end_effector_hal.description import Description
from end_effector_hal.kinds import fault_of, kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.nodes._silence import Silence
from end_effector_hal.nodes.interface import GONE_AFTER_S, STARTING_S, actuator_joints
from end_effector_hal.nodes.transport import AMBIENT_PA, StateMessage, StatusMessage
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


class Positions:
    """The latest position of each part, UNKNOWN if it is not repeated. Times in µs, monotonic.

    Args:
        places: the enumeration of each part; 0 is UNKNOWN in all of them.
    """

    def __init__(self, places: Mapping[str, type[IntEnum]]) -> None:
        self._places = places
        self._latest: dict[str, tuple[int, int]] = {}

    def store(self, name: str, position: int, at_us: int) -> None:
        """Store a position that was received at ``at_us``."""
        self._latest[name] = (position, at_us)

    def place(self, name: str, now_us: int) -> IntEnum:
        """Return the position of a part; UNKNOWN if it was not received for a second."""
        position, at_us = self._latest.get(name, (0, 0))
        places = {place.value: place for place in self._places[name]}
        return places.get(position if now_us - at_us <= GONE_AFTER_S * 1e6 else 0, places[0])

    def names(self, now_us: int) -> dict[str, str]:
        """Return the names of all positions that were ever received."""
        return {name: self.place(name, now_us).name for name in self._latest}


class Margins:
    """The margin of each actuator in Pa, from the absolute pressures of the channels."""

    def __init__(self, description: Description) -> None:
        self._description = description
        self._supply = description.supply
        self._absolute: dict[str, float] = {}

    def store(self, channel: str, absolute_pa: float) -> None:
        """Store a received reading; NaN: invalid."""
        self._absolute[channel] = absolute_pa

    def values(self, stale: Collection[str] | None) -> list[float]:
        """Return the margins in sequence order, NaN if unknown; ``stale``: stale channels, None: all are stale."""
        return [self._margin(part, stale) for _, part in self._description.ordered]

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """An alarm for each plug-in kind whose margins are unknown because it has failed."""
        kinds = {part.kind: kind_of(part) for _, part in self._description.ordered}
        found = ((name, fault_of(kind)) for name, kind in kinds.items())
        return tuple(Alarm("kind.failed", name, {"why": fault}) for name, fault in found if fault)

    def _margin(self, part: Actuator, stale: Collection[str] | None) -> float:
        supply_pa = self._supply.pressure_pa(self._gauge(self._supply.channel, stale))
        return kind_of(part).margin_pa(part, self._gauge(part.channel, stale), supply_pa)

    def _gauge(self, channel: str, stale: Collection[str] | None) -> float:
        if stale is None or channel in stale:
            return math.nan
        return self._absolute.get(channel, math.nan) - AMBIENT_PA


CHANGER, STAND = "tool_changer", "tool_stand"


class Aggregate:
    """Combines the latest status of the program with all that the other nodes report.

    While the node Grip is silent, the state is OFF, the evidence and the tool changer are UNKNOWN, and lifting is not
    allowed. The outputs and ``held`` keep their last known values, because the line arbiter holds the part. A silent
    Grip causes an alarm; if it has never reported, it does so only after HALMain itself has run for `STARTING_S`.
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
        self.status = StatusMessage(actuators=[0] * count, outputs=[False] * count, evidence=[0] * count)

    def message(
        self, at_us: int, now_us: int, silence: Silence, notices: Sequence[Alarm] = ()
    ) -> StateMessage:
        """Return the state after a change at ``at_us``, without a number; ``notices`` are alarms of HALMain itself."""
        status, sequence = self.status, self._description.sequence
        lost = silence.lasts(now_us)
        starting = not silence.has_reported and now_us - self._since_us < STARTING_S * 1e6
        absent = (silence.alarm,) if lost and not starting else ()
        told = received_alarms(status.alarms, status.alarm_ids)
        alarms = distinct((*absent, *notices, *told))
        deadline = status.deadline_us
        state, command = (EndEffectorState.OFF, Command.NONE) if lost else (status.state, status.command)
        evidence = [Evidence.UNKNOWN] * len(sequence) if lost else status.evidence
        changer = ChangerState.UNKNOWN if lost else status.tool_changer
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
            actuators=status.actuators,
            actuator_states=[
                _name(states, state) for states, state in zip(self._states, status.actuators, strict=False)
            ],
            outputs=status.outputs,
            evidence=evidence,
            evidence_names=[_name(Evidence, each) for each in evidence],
            margins=self._margins.values(status.stale if status.link_up and not lost else None),
            margin_units=["Pa"] * len(sequence),
            positions=[joint.position(evidence) if joint else nan for joint in self._joints],
            actuator="" if lost or status.step < 0 else sequence[status.step],
            attempt=status.attempt,
            attempts_allowed=status.attempts_allowed,
            time_left_s=nan if lost or deadline < 0 else max(0, deadline - now_us) / 1e6,
            steps=status.steps,
            cause=status.cause,
            cause_name=_name(Cause, status.cause),
            cause_actuator=sequence[status.cause_at] if status.cause_at >= 0 else "",
            reason=status.reason,
            held=status.held,
            lift_allowed=status.lift_allowed and not lost,
            secure=status.secure and not lost,
            maintenance=status.maintenance and not lost,
            tool_changer=changer,
            tool_changer_name=_name(ChangerState, changer),
            unlock_output=status.unlock_output,
            tool_position=position,
            tool_position_name=position.name,
            tool_stand=stand,
            tool_stand_name=stand.name,
            link_up=status.link_up and not lost,
            stale=status.stale,
            missed=status.missed,
            worst_late_us=status.worst_late_us,
            alarms=[*map(str, alarms)],
            alarm_ids=[alarm.name for alarm in alarms],
        )  # fmt: skip


def _name(words: type[IntEnum], value: int) -> str:
    """Return the name of an integer that another node sent; an unknown integer is returned as text."""
    try:
        return words(value).name
    except ValueError:
        return str(value)
