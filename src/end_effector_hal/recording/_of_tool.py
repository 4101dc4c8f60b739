"""The facts about a tool that its recording contains, and the channels that are recorded."""

from __future__ import annotations

from typing import Any

from end_effector_hal._extras import DISTRIBUTION, version_of
from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description, content_hash, used_channels
from end_effector_hal.kinds import kind_of, switch_meanings
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.recording._run import RunInfo
from end_effector_hal.signals import Kind


def run_info(
    description: Description, *, scenario: str = "", seed: int | None = None, ros: int = 0
) -> RunInfo:
    """Return the facts about a tool for its recording.

    ``ros`` is the ROS generation that carries the tool's states; 0: no ROS.
    """
    return RunInfo(
        scenario=scenario,
        description=description.name,
        hash=content_hash(description),
        version=product_version(),
        ros=bool(ros),
        ros_generation=ros or None,
        actuators={name: actuator.kind for name, actuator in description.ordered},
        limits={name: _limits(description, actuator) for name, actuator in description.ordered},
        parts={
            part: {name: _limits(tool, actuator) for name, actuator in tool.ordered}
            for part, tool in zip(description.parts, description.per_part, strict=False)
        },
        switches=_switches(description),
        e_stop=_e_stop(description),
        simulated=description.lines.backend == "virtual",
        seed=seed,
    )


def pressure_channels(description: Description) -> tuple[str, ...]:
    """Return the pressure channels that the link carries: those of the actuators in sequence order, then the supply.

    After them come the quantities, such as a distance, that the evidence of an actuator uses.
    """
    carried = carrier_of(description).channels
    wanted = [*(actuator.channel for _, actuator in description.ordered), description.supply.channel]
    pressures = [name for name in dict.fromkeys(wanted) if carried.get(name) is Kind.PRESSURE]
    quantities = [name for name in used_channels(description) if carried.get(name) is Kind.QUANTITY]
    return (*pressures, *quantities)


def switch_channels(description: Description) -> tuple[str, ...]:
    """Return the used switch channels of the link: of the actuators in sequence order, then of other devices."""
    carried = carrier_of(description).channels
    return tuple(name for name in used_channels(description) if carried.get(name) is Kind.BIT)


def _switches(description: Description) -> dict[str, dict[str, Any]]:
    """Return the switches that prove something about an actuator, with the actuator and their meanings."""
    fitted, found = switch_channels(description), dict[str, dict[str, Any]]()
    for name, actuator in description.ordered:
        for channel, meaning in switch_meanings(actuator).items():
            if channel in fitted:
                found.setdefault(channel, {"actuator": name, "on": meaning.on, "off": meaning.off})
    return found


def _e_stop(description: Description) -> str:
    """Return the channel of the e-stop's input; empty: there is no input, or the link does not carry it."""
    stop = description.e_stop
    return stop.channel if stop and stop.channel in switch_channels(description) else ""


def _limits(description: Description, actuator: Actuator) -> dict[str, Any]:
    measured = _measured(actuator)
    return {
        "channel": actuator.channel,
        "kind": actuator.kind,
        "attempts": actuator.attempts,
        **kind_of(actuator).limits(actuator, description.supply),
        **({"measured": measured} if measured else {}),
    }


_SIGNS = {"below": "<", "above": ">"}
_WITHIN = ("≥", "≤")
_NOT = {"<": "≥", ">": "≤", "≥": "<", "≤": ">"}


def _measured(actuator: Actuator) -> list[dict[str, Any]]:
    """Return the thresholds of an actuator's conditions on quantities other than pressures, such as a distance."""
    found = []
    for leaf in actuator.evidence.leaves if actuator.evidence else ():
        for index, (key, at) in enumerate(leaf.thresholds):
            if key.endswith("_kpa"):
                continue
            sign = _SIGNS.get(key, _WITHIN[min(index, 1)])
            sign = _NOT[sign] if leaf.path.count("not") % 2 else sign
            found.append({"channel": leaf.channel, "proves": str(leaf.path[0]), "sign": sign, "at": at})
    return found


def product_version() -> str:
    """Return the version of the installed distribution; empty if it is not installed."""
    return version_of(DISTRIBUTION)
