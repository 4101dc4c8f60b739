"""A card for each actuator, in the order of a grip."""

from __future__ import annotations

from typing import Any

from end_effector_hal.control import Controller, Status
from end_effector_hal.description import Description
from end_effector_hal.kinds import LeakWatch, SwitchMeaning, kind_of, switch_meanings
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import ACTIVE, PENDING, EndEffectorState, Evidence, display_name

_MARKS = ("gone", "lost_at_once", "lost", "confirmed", "secure")
LEAKS_KPA_S = 0.02
"""A vacuum that falls more slowly is shown as one without a leak."""


class Cards:
    """What of the cards never changes, and what they show now.

    Args:
        description: the tool.
        carried: channels by name, with their kind.
    """

    def __init__(self, description: Description, carried: dict[str, Kind]) -> None:
        self._description, self._carried = description, carried
        self._parts = description.ordered

    @property
    def pressures(self) -> list[tuple[str, str, bool]]:
        """Name, channel and whether it is below ambient, of each actuator that has a pressure."""
        return [
            (name, part.channel, kind_of(part).below_ambient)
            for name, part in self._parts
            if self._carried.get(part.channel) is Kind.PRESSURE
        ]

    @property
    def switches(self) -> dict[str, SwitchMeaning]:
        """Channels of the bits of the actuators, in the order of a grip, with what each proves."""
        found: dict[str, SwitchMeaning] = {}
        for _, part in self._parts:
            for channel, meaning in switch_meanings(part).items():
                if self._carried.get(channel) is Kind.BIT:
                    found.setdefault(channel, meaning)
        return found

    def drawn(self) -> list[dict[str, Any]]:
        """What never changes."""
        return [self._drawn(name, part) for name, part in self._parts]

    def _drawn(self, name: str, part: Actuator) -> dict[str, Any]:
        kind = kind_of(part)
        has_pressure = self._carried.get(part.channel) is Kind.PRESSURE
        marks = self._marks(part) if has_pressure else []
        most = max([mark["at"] for mark in marks], default=1.0)
        return {
            "name": name,
            "label": display_name(name),
            "kind": kind.name,
            "line": part.line,
            "states": {int(state): state.label for state in kind.states},
            "pressure": has_pressure,
            "unit": "kPa below ambient" if kind.below_ambient else "kPa",
            "marks": marks,
            "most": 100.0 if kind.below_ambient and most <= 100 else round(most * 1.4, -1),
            "attempts": part.attempts,
            "bits": self._bits(part),
        }

    def _marks(self, part: Actuator) -> list[dict[str, Any]]:
        limits = kind_of(part).limits(part, self._description.supply)
        marks = []
        for word in _MARKS:
            value = limits.get(f"{word}_kpa", getattr(part, f"{word}_kpa", None))
            if value is not None:
                marks.append({"word": word.replace("_", " "), "at": float(value)})
        return marks

    def _bits(self, part: Actuator) -> list[str]:
        return [name for name in kind_of(part).channel_names(part) if self._carried.get(name) is Kind.BIT]

    def now(self, status: Status, controller: Controller | None) -> list[dict[str, Any]]:
        """What they show; instants are in µs, so that it stays the same until something happens."""
        return [self._now(index, status, controller) for index in range(len(self._parts))]

    def _now(self, index: int, status: Status, controller: Controller | None) -> dict[str, Any]:
        name, part = self._parts[index]
        kind = kind_of(part)
        state = status.actuators[index]
        card: dict[str, Any] = {
            "state": kind.states(state).label,
            "phase": "pending" if state == PENDING else "active" if state == ACTIVE else "inactive",
            "output": status.outputs[index],
            "evidence": status.evidence[index].name,
            "kept": index in status.kept,
            "blows": index in status.blowing,
            "kpa": None,
            "margin_kpa": None,
            "bits": [],
            "attempt": None,
            "timer": self._timer(index, part, status),
            "hold": None,
        }
        if is_releasing(status, index):
            card["phase"] = "releasing"
        report = next((step for step in status.steps if step.name == name), None)
        if report is not None and report.attempts:
            card["attempt"] = {
                "number": report.attempts,
                "of": part.attempts,
                "seconds": report.seconds,
                "confirmed": report.confirmed,
            }
        if controller is None:
            return card
        readings = controller.senses.now.readings
        # between two records the page knows nothing newer than the last one
        seen_at = controller.at
        value = readings.get(part.channel, seen_at)
        if isinstance(value, int) and not isinstance(value, bool):
            card["kpa"] = (-value if kind.below_ambient else value) / 1000
            supply = self._description.supply
            supply_pa = supply.pressure_pa(readings.get(supply.channel, seen_at))
            margin = kind.margin_pa(part, value, supply_pa)
            card["margin_kpa"] = None if margin != margin else margin / 1000
        card["bits"] = [readings.get(bit, seen_at) for bit in self._bits(part)]
        if status.held:
            card["hold"] = self._hold(index, controller)
        return card

    def _hold(self, index: int, controller: Controller) -> dict[str, Any]:
        watch = controller.hold.watch_over(index)
        hold: dict[str, Any] = {
            "secure": watch.secure if watch else None,
            "leak_kpa_s": None,
            "leaks": False,
            "lost_in_s": None,
        }
        pressed = self._carried.get(self._parts[index][1].channel) is Kind.PRESSURE
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

    def _timer(self, index: int, part: Actuator, status: Status) -> dict[str, Any] | None:
        """What runs down on this card."""
        if status.deadline is None:
            return None
        what, total = "", 0.0
        if status.ee is EndEffectorState.GRIPPING and status.step == index:
            waiting = status.outputs[index]
            what, total = ("time-out", part.timeout_s) if waiting else ("next attempt", part.reset_s)
        elif status.ee is EndEffectorState.RELEASING and self._releases(index, status):
            what, total = "goes on after", part.release_s
        if not what or status.deadline - status.at > (total + 0.05) * 1e6:
            return None
        return {"what": what, "until": status.deadline, "of_s": total}

    def _releases(self, index: int, status: Status) -> bool:
        """Whether the unwinding waits for this one: of those that are inactive and not gone yet, the newest."""
        order = [self._description.sequence.index(name) for name in self._description.releasing]
        waits = [i for i in order if is_releasing(status, i)]
        return bool(waits) and waits[-1] == index


def is_releasing(status: Status, index: int) -> bool:
    """Whether an actuator is deactivated, and its feedback is not gone yet, or it is being blown off."""
    if index in status.blowing:
        return True
    releasing = status.ee in (EndEffectorState.RELEASING, EndEffectorState.RELEASE_ERROR)
    return releasing and not status.outputs[index] and status.evidence[index] is not Evidence.GONE
