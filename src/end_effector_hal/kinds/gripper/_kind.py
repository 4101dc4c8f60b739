"""The kind of device that is a gripper."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from end_effector_hal.kinds import ChannelKey, DeviceKind, Travel
from end_effector_hal.kinds.stanza import NO_CHANNEL, EvidenceConditions, named
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import TableState

from ._stanza import GripperActuator


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

    def preset(self, part: GripperActuator) -> EvidenceConditions | None:
        """Return the conditions over its switches; open fingers hold nothing, even if a part switch is on."""
        opened, closed, held = named(part.open_bit), named(part.closed_bit), named(part.part_bit)
        ends = [{"on": each} for each in (opened, closed) if each]
        if held:
            grips: dict[str, Any] = {
                "all": [{"on": held}, *({"not": {"on": each}} for each in (opened,) if each)]
            }
        else:
            grips = {"not": {"any": ends}}
        no_part = [{"not": {"on": held}}] if held else []
        conditions: dict[str, Any] = {
            "confirmed": {**grips, "for_ms": part.confirmed_ms if held else part.settle_ms},
            "lost": {"not": grips, "for_ms": part.lost_ms},
            "gone": {**({"on": opened} if opened else no_part[0]), "for_ms": part.gone_ms},
        }
        if closed:
            conditions["empty"] = {"all": [{"on": closed}, *no_part], "for_ms": part.confirmed_ms}
        # the two ends exclude each other; a part that is seen between open fingers is no fault of a sensor
        conditions["fault"] = {"all": ends if len(ends) == 2 else [{"on": held}, {"not": {"on": held}}]}
        return EvidenceConditions.model_validate(conditions)

    def not_fitted(self, part: GripperActuator, carried: Mapping[str, Kind]) -> Iterator[str]:
        """Yield a phrase for each missing switch with what is not detected without it."""
        switches = ((key, getattr(part, key)) for key in ("part_bit", "open_bit", "closed_bit"))
        for key, bit in switches:
            if bit not in carried:
                yield f"{key}: {bit or NO_CHANNEL}: {self._instead(part, key)}"

    def _instead(self, part: GripperActuator, key: str) -> str:
        if key == "part_bit":
            proof = f"fingers between their ends for {part.settle_ms} ms prove a part"
            return f"{proof}: a cylinder that is stuck on its way counts as that"
        if key == "open_bit":
            return f"{part.part_bit} off counts as open: fingers that stay closed are not detected"
        return "that it closed on nothing is not seen: an attempt ends by its time-out"

    def travel(self, part: GripperActuator) -> Travel | None:
        """Return the stroke as a prismatic joint; None: the stanza does not define it."""
        return None if part.stroke_mm is None else Travel("prismatic", part.stroke_mm / 1000)
