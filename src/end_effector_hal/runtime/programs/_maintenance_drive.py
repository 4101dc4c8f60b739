"""Drive one actuator in maintenance, and wait for the proof of its sensor (IL-12)."""

from __future__ import annotations

from end_effector_hal.control import Answer
from end_effector_hal.description import Description
from end_effector_hal.errors import ArbiterError, LineRefusedError, WireError
from end_effector_hal.runtime.outputs import Maintenance
from end_effector_hal.vocabulary import Evidence, display_name

from ._adoption import Adoption
from ._latest_status import LatestStatus


def drive(adoption: Adoption, maintenance: Maintenance, line: str, at: int, *, active: bool) -> Answer:
    """Write a line at ``at`` µs, under the lease; return whether that succeeded."""
    if refused := adoption.controller.refuse_maintenance(active=active):
        return Answer(False, refused)
    try:
        outputs = adoption.outputs
        will = outputs.mapping.maintenance_will(adoption.controller.status(), line, active=active)
        outputs.drive(line, active, will)
    except WireError as error:
        if active and not isinstance(error, LineRefusedError):
            # perhaps it was executed: then the lease ends it
            maintenance.drove(line, active, at)
        return Answer(False, str(error), decided=not isinstance(error, ArbiterError))
    maintenance.drove(line, active, at)
    return Answer(True)


def proof(
    latest: LatestStatus, description: Description, name: str, timeout_s: float | None, *, active: bool
) -> Answer:
    """Wait until the sensors prove the wanted level. The default time limit is the actuator's ``timeout_s`` or
    ``release_s``.
    """
    actuator, index = description.actuators[name], description.sequence.index(name)
    limit_s = timeout_s or (actuator.timeout_s if active else actuator.release_s)
    wanted = Evidence.CONFIRMED if active else Evidence.GONE
    if latest.wait(lambda status: status.evidence[index] == wanted, limit_s):
        proven = "active" if active else "inactive"
        return Answer(True, f"{display_name(name)} is {proven}, proven by its sensor.")
    shown = latest.status.evidence[index].name
    left = f" It stays active for {description.maintenance.lease_s:g} s at most." if active else ""
    what = f"its line is written, but its sensor does not prove it within {limit_s:g} s (it says {shown})"
    return Answer(False, f"{display_name(name)}: {what}.{left}")
