"""Whether what was driven by hand is proven by its sensor (IL-12)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from end_effector_hal.control import Answer, Evidence
from end_effector_hal.description import Description
from end_effector_hal.trace import display_name

if TYPE_CHECKING:
    from ._unit import Unit


def proof(
    unit: Unit, description: Description, name: str, *, active: bool, timeout_s: float | None = None
) -> Answer:
    """Wait for it, by default as long as the actuator has in a grip or a release."""
    actuator, index = description.actuators[name], description.sequence.index(name)
    limit_s = timeout_s or (actuator.timeout_s if active else actuator.release_s)
    wanted = Evidence.CONFIRMED if active else Evidence.GONE
    if unit.wait(lambda status: status.evidence[index] == wanted, limit_s):
        proven = "active" if active else "inactive"
        return Answer(True, f"{display_name(name)} is {proven}, proven by its sensor.")
    shown = Evidence(unit.status.evidence[index]).name
    left = f" It stays active for {description.maintenance.lease_s:g} s at most." if active else ""
    what = f"its line is written, but its sensor does not prove it within {limit_s:g} s (it says {shown})"
    return Answer(False, f"{display_name(name)}: {what}.{left}")
