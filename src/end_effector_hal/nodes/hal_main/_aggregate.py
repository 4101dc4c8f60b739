"""Build one state of the end-effector from the messages of the nodes: statuses, positions, margins, and the
silence of a node.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from enum import IntEnum
from math import nan

from end_effector_hal.description import Description
from end_effector_hal.kinds import fault_of, kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.nodes.interface import GONE_AFTER_S, GRIP, STARTING_S, TOOL_CHANGE, actuator_joints
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


class Silence:
    """The time of the last report of each node; a node that has never reported is silent. Times in µs, monotonic."""

    def __init__(self, nodes: Iterable[str]) -> None:
        self._reported_us: dict[str, int | None] = dict.fromkeys(nodes)

    def reported(self, node: str, at_us: int) -> None:
        """Note that the node has reported at ``at_us``."""
        self._reported_us[node] = at_us

    def has_reported(self, node: str) -> bool:
        """Return whether the node has ever reported."""
        return self._reported_us[node] is not None

    def silent(self, now_us: int) -> tuple[str, ...]:
        """Return the names of the nodes that have not reported within the last second."""
        limit = GONE_AFTER_S * 1e6
        return tuple(name for name, at in self._reported_us.items() if at is None or now_us - at > limit)


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
    """Combines the latest statuses of both programs.

    While the node Grip is silent, the state is OFF, the evidence UNKNOWN, and lifting is not allowed. Its outputs and
    ``held`` keep their last known values, because the line arbiter holds the part. A silent node causes an alarm; a
    node that has never reported does so only after HALMain itself has run for `STARTING_S`.
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
        """Return the state after a change at ``at_us``, without a number; ``notices`` are alarms of HALMain itself."""
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
        """Return the running command; gripping and the tool changer exclude each other (IL-01, IL-05)."""
        if GRIP not in gone and self.grip.command != Command.NONE:
            return int(self.grip.command)
        return int(Command.NONE if TOOL_CHANGE in gone else self.tool_change.command)


def _name(words: type[IntEnum], value: int) -> str:
    """Return the name of an integer that another node sent; an unknown integer is returned as text."""
    try:
        return words(value).name
    except ValueError:
        return str(value)
