"""The device kind ``gripper``, and the keys of its stanza."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from end_effector_hal.kinds import ChannelKey, DeviceKind, Travel
from end_effector_hal.kinds.stanza import (
    NO_CHANNEL,
    Actuator,
    BlowOff,
    EvidenceConditions,
    MaybeMillimetres,
    Name,
    Settling,
    named,
    stanza_fault,
)
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import TableState


class GripperActuator(Actuator):
    """Fingers that an active line closes: pneumatic with a mono-stable valve, or electric with one line.

    A part is proven by its own switch, or by fingers that are neither open nor closed for `settle_ms`. At least
    `part_bit`, or `open_bit` and `closed_bit`, must be named.
    """

    kind: Literal["gripper"] = Field(description="what it is")
    channel: Literal["none"] = Field(default="none", description="a gripper has no pressure sensor")
    open_bit: Name | None = Field(
        default=None, description="end switch: the fingers are open; null or none: no such sensor"
    )
    closed_bit: Name | None = Field(
        default=None,
        description="end switch: the fingers have closed as far as they go, on nothing; null or none: no such sensor",
    )
    part_bit: Name | None = Field(
        default=None,
        description="a part is between the fingers, such as a switch set to its width; null or none: no such sensor",
    )
    blow_off: BlowOff | None = Field(
        default=None, description="air that pushes the part off when it is released; absent: none is fitted"
    )
    confirmed_ms: Settling = Field(
        default=50,
        description="part_bit for this long: confirmed; closed_bit for this long: closed on nothing",
    )
    settle_ms: Settling = Field(
        default=1000,
        description="without part_bit: neither open nor closed for this long, longer than any stroke: a part is held",
    )
    lost_ms: Settling = Field(
        default=40, description="a confirmed part is lost after its condition has not held for this long"
    )
    gone_ms: Settling = Field(
        default=50, description="open_bit for this long, or without it part_bit off: released"
    )
    stroke_mm: MaybeMillimetres = Field(
        default=None,
        description="from open to closed on the part, for joint_states and the URDF; null: no joint",
    )

    @model_validator(mode="after")
    def _something_proves_it(self) -> Self:
        if self.evidence or named(self.part_bit) or (named(self.open_bit) and named(self.closed_bit)):
            return self
        one = named(self.open_bit) or named(self.closed_bit)
        what = f"{one} alone proves no part" if one else "nothing proves that it has gripped"
        raise stanza_fault("EE-225", what, "part_bit, or open_bit and closed_bit, or evidence")


class GripperState(TableState):
    """States of a gripper's fingers."""

    OPEN = 0
    PENDING_CLOSE = 1
    CLOSED = 2


class Gripper(DeviceKind[GripperActuator]):
    """Kind of a gripper: confirmed by a part switch, or by fingers that stay between their end switches."""

    name = "gripper"
    stanza = GripperActuator
    channels = (
        ChannelKey("open_bit", Kind.BIT),
        ChannelKey("closed_bit", Kind.BIT),
        ChannelKey("part_bit", Kind.BIT, confirms=True),
    )
    states = GripperState
    empty = "closed on nothing"
    opposing = "blow_off"

    def preset(self, actuator: GripperActuator) -> EvidenceConditions | None:
        """Return the conditions over its switches; open fingers hold nothing, even if a part switch is on."""
        opened, closed, held = named(actuator.open_bit), named(actuator.closed_bit), named(actuator.part_bit)
        ends = [{"on": each} for each in (opened, closed) if each]
        if held:
            grips: dict[str, Any] = {
                "all": [{"on": held}, *({"not": {"on": each}} for each in (opened,) if each)]
            }
        else:
            grips = {"not": {"any": ends}}
        no_part = [{"not": {"on": held}}] if held else []
        conditions: dict[str, Any] = {
            "confirmed": {**grips, "for_ms": actuator.confirmed_ms if held else actuator.settle_ms},
            "lost": {"not": grips, "for_ms": actuator.lost_ms},
            "gone": {**({"on": opened} if opened else no_part[0]), "for_ms": actuator.gone_ms},
        }
        if closed:
            conditions["empty"] = {"all": [{"on": closed}, *no_part], "for_ms": actuator.confirmed_ms}
        # the two ends exclude each other; a part that is seen between open fingers is no fault of a sensor
        conditions["fault"] = {"all": ends if len(ends) == 2 else [{"on": held}, {"not": {"on": held}}]}
        return EvidenceConditions.model_validate(conditions)

    def not_fitted(self, actuator: GripperActuator, carried: Mapping[str, Kind]) -> Iterator[str]:
        """Yield a phrase for each missing switch with what is not detected without it."""
        switches = ((key, getattr(actuator, key)) for key in ("part_bit", "open_bit", "closed_bit"))
        for key, bit in switches:
            if bit not in carried:
                yield f"{key}: {bit or NO_CHANNEL}: {self._instead(actuator, key)}"

    def _instead(self, actuator: GripperActuator, key: str) -> str:
        if key == "part_bit":
            proof = f"fingers between their ends for {actuator.settle_ms} ms prove a part"
            return f"{proof}: a cylinder that is stuck on its way counts as that"
        if key == "open_bit":
            return f"{actuator.part_bit} off counts as open: fingers that stay closed are not detected"
        return "that it closed on nothing is not seen: an attempt ends by its time-out"

    def travel(self, actuator: GripperActuator) -> Travel | None:
        """Return the stroke as a prismatic joint; None: the stanza does not define it."""
        return None if actuator.stroke_mm is None else Travel("prismatic", actuator.stroke_mm / 1000)
