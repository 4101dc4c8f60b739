"""The cards of the actuators, in the order of a grip."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from end_effector_hal.control import Controller, Status
from end_effector_hal.description import Description
from end_effector_hal.kinds import LeakWatch, SwitchMeaning, kind_of, switch_meanings
from end_effector_hal.kinds.stanza import Actuator, Supply
from end_effector_hal.signals import Kind, Value
from end_effector_hal.vocabulary import ACTIVE, PENDING, EndEffectorState, Evidence, display_name

from ._curves import Curve, curves_of

LEAKS_KPA_S = 0.02
"""Slowest fall of a vacuum that is shown as a leak, kPa/s."""


class Cards:
    """The constant content of the cards, and their present values.

    Args:
        carried: channels by name, with their kind.
    """

    def __init__(self, description: Description, carried: dict[str, Kind]) -> None:
        self._description, self._carried = description, carried
        self._ordered = description.ordered
        self._tools = dict(zip(description.part_names, description.per_part, strict=True))
        self._uses = {name: description.uses(name) for name in description.part_names}
        self._curves = curves_of(description, carried)

    @property
    def curves(self) -> list[Curve]:
        """The measured channels of the actuators, in the order of a grip, each channel once."""
        found = {curve.name: curve for curves in self._curves.values() for curve in curves}
        return list(found.values())

    @property
    def switches(self) -> dict[str, SwitchMeaning]:
        """The bit channels of the actuators, in the order of a grip, with the meaning of each."""
        found: dict[str, SwitchMeaning] = {}
        for _, actuator in self._ordered:
            for channel, meaning in switch_meanings(actuator).items():
                if self._carried.get(channel) is Kind.BIT:
                    found.setdefault(channel, meaning)
        return found

    def drawn(self) -> list[dict[str, Any]]:
        """Return the content that never changes."""
        return [self._drawn(name, actuator) for name, actuator in self._ordered]

    def _drawn(self, name: str, actuator: Actuator) -> dict[str, Any]:
        kind = kind_of(actuator)
        return {
            "name": name,
            "label": display_name(name),
            "kind": kind.name,
            "line": actuator.line,
            "states": {int(state): state.label for state in kind.states},
            "margin_from": kind.margin_from,
            "gauges": [curve.drawn() for curve in self._curves[name]],
            "bits": self._bits(actuator),
        }

    def _bits(self, actuator: Actuator) -> list[str]:
        return [
            name for name in kind_of(actuator).channel_names(actuator) if self._carried.get(name) is Kind.BIT
        ]

    def judged(self, status: Status) -> str:
        """Return the name of the part by whose values the tool judges; at rest the default one."""
        return status.part or self._description.part_names[0]

    def now(self, status: Status, controller: Controller | None, gripped: str = "") -> list[dict[str, Any]]:
        """Return the present values; times are instants in µs, so that nothing changes between two events.

        ``gripped``: the part of the last grip, whose attempts are shown; empty: unknown, or it has no name.
        """
        return [self._now(index, status, controller, gripped) for index in range(len(self._ordered))]

    def _now(self, index: int, status: Status, controller: Controller | None, gripped: str) -> dict[str, Any]:
        name, actuator = self._tools[self.judged(status)].ordered[index]
        kind = kind_of(actuator)
        state = status.actuators[index]
        card: dict[str, Any] = {
            "state": kind.states(state).label,
            "phase": "pending" if state == PENDING else "active" if state == ACTIVE else "inactive",
            "output": status.outputs[index],
            "unused": bool(status.part) and not self._uses[status.part][index],
            "evidence": status.evidence[index].name,
            "kept": index in status.kept,
            "blows": index in status.blowing,
            "values": [None] * len(self._curves[name]),
            "margin_kpa": None,
            "bits": [],
            "attempt": None,
            "timer": self._timer(index, actuator, status),
            "hold": None,
        }
        if is_releasing(status, index):
            card["phase"] = "releasing"
        report = next((step for step in status.steps if step.name == name), None)
        tool = self._tools.get(status.part or gripped)
        if report is not None and report.attempts and tool is not None:
            card["attempt"] = {
                "number": report.attempts,
                "of": tool.actuators[name].attempts,
                "seconds": report.seconds,
                "confirmed": report.confirmed,
            }
        if controller is None:
            return card
        readings = controller.senses.now.readings
        # between two records the page knows nothing newer than the last one
        seen_at = controller.at
        card["values"] = self.values(name, {each: readings.get(each, seen_at) for each in readings.carried})
        value = readings.get(actuator.channel, seen_at)
        if self._carried.get(actuator.channel) is Kind.PRESSURE and value is not None:
            supply = self._description.supply
            margin = margin_kpa(actuator, value, supply, readings.get(supply.channel, seen_at))
            card["margin_kpa"] = None if card["unused"] else margin
        card["bits"] = [readings.get(bit, seen_at) for bit in self._bits(actuator)]
        if status.held and not card["unused"]:
            card["hold"] = self._hold(index, controller)
        return card

    @property
    def decimals(self) -> list[list[int]]:
        """The decimals of the gauges of each card."""
        return [[curve.decimals for curve in curves] for curves in self._curves.values()]

    def values(self, name: str, readings: Mapping[str, Value]) -> list[float | None]:
        """Return the values of an actuator's gauges."""
        shown = ((curve, readings.get(curve.channel)) for curve in self._curves[name])
        return [None if value is None else curve.shown(value) for curve, value in shown]

    def _hold(self, index: int, controller: Controller) -> dict[str, Any]:
        watch = controller.hold.watch_over(index)
        hold: dict[str, Any] = {
            "secure": watch.secure if watch else None,
            "leak_kpa_s": None,
            "leaks": False,
            "lost_in_s": None,
        }
        pressed = self._carried.get(self._ordered[index][1].channel) is Kind.PRESSURE
        if not pressed and not hold["secure"]:
            hold["secure"] = None  # without a pressure nobody knows
        elif pressed and isinstance(watch, LeakWatch):
            leak, lost_in_s = watch.leak_kpa_s, watch.lost_in_s
            hold |= {
                "leak_kpa_s": None if leak is None else round(leak, 2),
                "leaks": leak is not None and leak > LEAKS_KPA_S,
                "lost_in_s": None if lost_in_s is None else round(lost_in_s, 1),
            }
        return hold

    def _timer(self, index: int, actuator: Actuator, status: Status) -> dict[str, Any] | None:
        """Return the timer that runs on this card; None if there is none."""
        if status.deadline is None:
            return None
        what, total = "", 0.0
        if status.ee is EndEffectorState.GRIPPING and status.step == index:
            waiting = status.outputs[index]
            what, total = ("time-out", actuator.timeout_s) if waiting else ("next attempt", actuator.reset_s)
        elif status.ee is EndEffectorState.RELEASING and self._releases(index, status):
            what, total = "goes on after", actuator.release_s
        if not what or status.deadline - status.at > (total + 0.05) * 1e6:
            return None
        return {"what": what, "until": status.deadline, "of_s": total}

    def _releases(self, index: int, status: Status) -> bool:
        """Return whether the release waits for this actuator: the newest inactive one not yet confirmed gone."""
        order = [self._description.sequence.index(name) for name in self._description.releasing]
        waits = [i for i in order if is_releasing(status, i)]
        return bool(waits) and waits[-1] == index


def margin_kpa(actuator: Actuator, gauge_pa: float, supply: Supply, supply_pa: float | None) -> float | None:
    """Return the distance of a pressure from the threshold that matters to its kind, kPa; None: no pressure decides.

    Args:
        actuator: the stanza, with the values of the part.
        gauge_pa: its gauge pressure, Pa.
        supply: the stanza of the supply.
        supply_pa: the reading of the supply, gauge Pa; None: the nominal pressure is assumed.
    """
    margin = kind_of(actuator).margin_pa(actuator, gauge_pa, supply.pressure_pa(supply_pa))
    return None if margin != margin else margin / 1000


def is_releasing(status: Status, index: int) -> bool:
    """Return whether an actuator is blowing off, or is deactivated and its evidence is not yet GONE."""
    if index in status.blowing:
        return True
    releasing = status.ee in (EndEffectorState.RELEASING, EndEffectorState.RELEASE_ERROR)
    return releasing and not status.outputs[index] and status.evidence[index] is not Evidence.GONE
