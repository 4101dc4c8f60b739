"""The state of the contract's interlocks, IL-01 to IL-13, and the reason of each."""

from __future__ import annotations

from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import Controller, Status
from end_effector_hal.description import Description
from end_effector_hal.sensing import E_STOP_CLOSED, LOCKED, NOTHING_GRIPPED, predicates_fitted
from end_effector_hal.vocabulary import E_STOPPED, STOPPED, EndEffectorState

RULES = {
    "IL-01": "Unlock only when nothing is gripped or held",
    "IL-02": "Unlock only in the stand, or armed",
    "IL-03": "The unlock output ends by itself",
    "IL-04": "Locked is proven by both bits",
    "IL-05": "No gripping and no lift unless the tool is locked and present",
    "IL-06": "No new grip under the least supply pressure",
    "IL-07": "No grip with feedback present or invalid",
    "IL-08": "Never suction and blow-off together",
    "IL-09": "Only a Drop releases a held part",
    "IL-10": "A valve is on or off for 50 ms at least",
    "IL-11": "Nothing is activated by itself after a start or a fault",
    "IL-12": "Single outputs in maintenance only",
    "IL-13": "No activation while the e-stop is open, or a stop is latched",
}
_BLOCKS = {"IL-01": "unlock", "IL-02": "unlock", "IL-05": "grip", "IL-06": "grip", "IL-07": "grip"}
_AT_REST = (EndEffectorState.STAND_BY, EndEffectorState.OFF)
_CHANGER = "There is no tool changer."
FULFILLED, BLOCKING, NOT_FITTED, OFF, NOT_ASKED = "fulfilled", "blocking", "not fitted", "off", "not asked"
NOT_KNOWN = "not known"


class InterlockTable:
    """Combines the description's setting of each interlock with the present state of the HAL."""

    def __init__(self, description: Description) -> None:
        self._description = description
        self._fitted = predicates_fitted(description, carrier_of(description))
        carried = carrier_of(description).channels
        self._supply = description.supply.channel in carried
        self._static = self._by_description()

    def now(self, status: Status | None, controller: Controller | None) -> list[dict[str, str]]:
        """Return the rows of all interlocks, in order."""
        said: dict[str, str] | None = None
        if status is not None and controller is not None:
            said = {**controller.blocking, **self._by_status(status, controller)}
        gripping = status is not None and status.ee not in _AT_REST
        return [self._row(name, said, gripping=gripping) for name in RULES]

    def e_stop(self, status: Status, controller: Controller | None) -> dict[str, str] | None:
        """Return the e-stop's state and a sentence; None if it has no input and no stop is latched."""
        e_stop, latched = self._description.e_stop, bool(status.alarm(STOPPED, E_STOPPED))
        closed: object = e_stop is None
        if e_stop is None and not latched:
            return None
        if e_stop is not None and controller is not None:
            closed = controller.senses.now.readings.get(e_stop.channel, controller.at)
        word = ("STOPPED" if latched else "CLOSED") if closed else "OPEN" if closed is False else "NOT KNOWN"
        why = "nothing is activated until the faults are reset" if latched else "nothing is activated now"
        return {"word": word, "why": "" if word == "CLOSED" else why}

    def _row(self, name: str, said: dict[str, str] | None, *, gripping: bool) -> dict[str, str]:
        row = {"id": name, "rule": RULES[name], "blocks": _BLOCKS.get(name, "")}
        if name == "IL-07" and gripping and name not in self._static:
            return {**row, "state": NOT_ASKED, "why": "asked when a grip begins"}
        if name in self._static and not (
            name == "IL-13" and said and name in said
        ):  # a stop needs no e-stop input
            state, why = self._static[name]
            return {**row, "state": state, "why": why}
        if said is None:
            return {**row, "state": NOT_KNOWN, "why": "the HAL has not reported it yet"}
        why = said.get(name, "").removeprefix(f"{name}: ")
        return {**row, "state": BLOCKING if why else FULFILLED, "why": why}

    def _by_description(self) -> dict[str, tuple[str, str]]:
        tool, found = self._description, dict[str, tuple[str, str]]()
        changer = tool.tool_changer
        for name, on in tool.interlocks.model_dump(by_alias=True).items():
            if not on:
                found[name] = OFF, "switched off in the description"
        if changer is None:
            found |= dict.fromkeys(("IL-01", "IL-02", "IL-03", "IL-04", "IL-05"), (NOT_FITTED, _CHANGER))
        else:
            if changer.latching:
                found["IL-03"] = NOT_FITTED, "the tool changer is declared latching"
            if LOCKED not in self._fitted:
                why = f"no sensor {changer.locked_bit} and {changer.unlocked_bit}"
                found |= {"IL-04": (NOT_FITTED, why), "IL-05": (NOT_FITTED, why)}
            if NOTHING_GRIPPED not in self._fitted:
                found["IL-01"] = NOT_FITTED, "no sensor shows what is gripped"
        if not self._supply and "IL-06" not in found:
            found["IL-06"] = NOT_FITTED, "no sensor shows the supply pressure"
        if not tool.blow_off_lines:
            found["IL-08"] = NOT_FITTED, "there is no blow-off"
        if E_STOP_CLOSED not in self._fitted:
            found["IL-13"] = NOT_FITTED, "there is no e-stop input"
        return found

    def _by_status(self, status: Status, controller: Controller) -> dict[str, str]:
        said: dict[str, str] = {}
        for alarm in status.alarms:
            name = str(alarm.values.get("interlock"))
            if name in RULES and not alarm.over:
                said[name] = alarm.text
        if status.changer_fault and status.changer_reason.startswith("IL-04"):
            said["IL-04"] = status.changer_reason
        if status.maintenance:
            said["IL-12"] = "Maintenance is on: no grip until it ends."
        e_stop = self._description.e_stop
        if e_stop is not None and "IL-13" not in said:
            closed = controller.senses.now.readings.get(e_stop.channel, controller.at)
            if not closed:
                said["IL-13"] = (
                    f"the e-stop is {'open' if closed is False else 'not known'} ({e_stop.channel})"
                )
        return said
