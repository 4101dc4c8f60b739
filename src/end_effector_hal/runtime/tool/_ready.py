"""Decide whether a tool is ready: its lines adopted, its sensors read, and no reason to refuse a first grip."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from end_effector_hal.codecs import carrier_of, sources_of
from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import ChangerState, EndEffectorState, Evidence, display_name, distinct
from end_effector_hal.wires.link import LinkHealth, LinkState
from end_effector_hal.wires.sensors import SensorHealth


def is_ready(description: Description, status: Status) -> bool:
    """Return whether the lines are adopted, frames arrive, the sensors allow a grip in STAND_BY, else a Drop, and the
    state of the tool changer is known.

    GONE is proven only a while after the first frame, and again after each silence of the link; until then a grip is
    refused.
    """
    adopted = status.ee != EndEffectorState.OFF
    known = adopted and status.link_up and Evidence.UNKNOWN not in status.evidence
    return known and not _present(description, status) and _changer_ready(description, status)


def _present(description: Description, status: Status) -> list[str]:
    """Return the actuators that are not proven to be gone, if a grip needs that proof (IL-07)."""
    if status.ee != EndEffectorState.STAND_BY or not description.interlocks.il_07:
        return []
    pairs = zip(description.sequence, status.evidence, strict=True)
    return [name for name, level in pairs if level in (Evidence.PARTIAL, Evidence.CONFIRMED)]


def _changer_ready(description: Description, status: Status) -> bool:
    """Return whether the state of the tool changer is known; a changer without sensors counts as ready."""
    return status.changer != ChangerState.UNKNOWN or not changer_is_sensed(description)


def changer_is_sensed(description: Description) -> bool:
    """Return whether the tool has a tool changer whose two sensors are carried by the link."""
    changer, carried = description.tool_changer, carrier_of(description).channels
    return changer is not None and changer.locked_bit in carried and changer.unlocked_bit in carried


def missing(description: Description, status: Status, sensors: SensorHealth) -> Iterator[str]:
    """Yield clauses with the reasons why a tool is not ready."""
    if status.ee == EndEffectorState.OFF:
        yield "its lines are not adopted"
    inputs = sensors.inputs
    if inputs and inputs.error:
        yield f"inputs of the board are not read: {inputs.error.rstrip('.')}"
    if not status.link_up and sensors.links:
        for name in silent_links(description, status, sensors.links) or sensors.links:
            yield _silence(description.link_name(name), sensors.links[name])
    elif not status.link_up:
        yield "the inputs of the board have not been read"
    elif Evidence.UNKNOWN in status.evidence:
        pairs = zip(description.sequence, status.evidence, strict=True)
        unknown = [name for name, level in pairs if level == Evidence.UNKNOWN]
        yield f"its sensors do not show {', '.join(unknown)}"
    elif present := _present(description, status):
        names = ", ".join(map(display_name, present))
        are = "is" if len(present) == 1 else "are"
        yield f"a grip would be refused, since {names} {are} not proven to be gone (IL-07): a Drop releases once more"
    if not _changer_ready(description, status):
        yield "its sensors do not show whether the tool is locked"
    yield from (str(alarm).rstrip(".?") for alarm in distinct(status.alarms) if alarm.id != "link.down")


def silent_links(description: Description, status: Status, names: Collection[str]) -> list[str]:
    """Return the links among ``names`` that deliver no frames now."""
    if status.link_up:
        return []
    sources = sources_of(carrier_of(description))
    lacking = {each.link for each in sources if not each.channels.isdisjoint(status.stale)}
    return [name for name in names if len(names) == 1 or name in lacking]


def _silence(sensors: str, link: LinkHealth) -> str:
    if link.error:
        return f"the sensor link is down: {link.error.rstrip('.')}"
    if link.state is LinkState.UP:
        return f"the {sensors} has fallen silent"
    return f"no frame has come over the {sensors}, {link.bytes} bytes"
