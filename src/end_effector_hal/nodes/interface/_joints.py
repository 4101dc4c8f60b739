"""The joints of a tool, as ``joint_states``, MoveIt and the URDF name them, and their positions.

``<tool>_joint`` represents the whole tool: 0 gripped, `GRIP_UPPER` released. It moves nothing: a tool of vacuum cups
has no opening in metres. ``<tool>_<actuator>_joint`` is the part that an actuator moves, if its description states how
far.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import nan

from end_effector_hal.description import Description
from end_effector_hal.kinds import Travel, kind_of
from end_effector_hal.vocabulary import Evidence

GRIP_UPPER = 1.0
"""Upper limit of the tool's joint, rad; the lower limit is 0."""


@dataclass(frozen=True, slots=True)
class ToolJoint:
    """The joint that one actuator moves.

    Attributes:
        name: name on the ROS graph.
        actuator: name of the actuator in the description.
        index: index of the actuator in the sequence.
        travel: its type and upper limit.
    """

    name: str
    actuator: str
    index: int
    travel: Travel

    def position(self, evidence: Sequence[int]) -> float:
        """Return the position that the evidence of all actuators proves, m or rad; NaN: none is proven."""
        ends: dict[int, float] = {Evidence.GONE: 0.0, Evidence.CONFIRMED: self.travel.upper}
        return ends.get(evidence[self.index], nan)


def grip_joint(description: Description) -> str:
    """Return the name of the joint that represents the whole tool."""
    return f"{description.name}_joint"


def grip_position(evidence: Sequence[int], uses: Sequence[bool]) -> float:
    """Return the position of that joint; NaN: none is proven.

    Args:
        evidence: of all actuators. If all of them are gone, the position is `GRIP_UPPER`.
        uses: whether each actuator grips the part. If those that do are confirmed, the position is 0.
    """
    if all(level == Evidence.CONFIRMED for level, used in zip(evidence, uses, strict=True) if used):
        return 0.0
    return GRIP_UPPER if set(evidence) == {Evidence.GONE} else nan


def actuator_joints(description: Description) -> tuple[ToolJoint, ...]:
    """Return the joints of the actuators in the order of a grip."""
    return tuple(_joints(description))


def _joints(description: Description) -> Iterator[ToolJoint]:
    for index, (name, actuator) in enumerate(description.ordered):
        if travel := kind_of(actuator).travel(actuator):
            yield ToolJoint(f"{description.name}_{name}_joint", name, index, travel)
