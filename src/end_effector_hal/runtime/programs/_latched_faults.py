"""The faults that the line arbiter has latched, as alarms and as reasons to activate nothing."""

from __future__ import annotations

import re
from collections.abc import Mapping

from end_effector_hal.sensing import E_STOP_CLOSED
from end_effector_hal.vocabulary import E_STOPPED, STOPPED, Alarm

UNTIL_RESET = "Nothing is activated until it is closed and the faults are reset."
_IDS = {"stop": STOPPED, E_STOP_CLOSED: E_STOPPED}
"""Alarm ids by the name of the fault; all other faults use ``arbiter.fault``."""


class LatchedFaults:
    """The latched faults.

    Attributes:
        alarms: one for each fault.
        stopped: the fault of a stop, a sentence (IL-13); empty: there is none.
        refuses: why nothing is activated, a sentence: a stop, or an e-stop and what to do; empty: nothing prevents it.
    """

    def __init__(self, faults: Mapping[str, str]) -> None:
        self.alarms = tuple(_latched_alarm(name, text) for name, text in faults.items())
        texts = {fault.id: fault.text for fault in self.alarms}
        self.stopped = texts.get(STOPPED, "")
        self.refuses = self.stopped or (f"{texts[E_STOPPED]} {UNTIL_RESET}" if E_STOPPED in texts else "")


def _latched_alarm(name: str, text: str) -> Alarm:
    """Return an alarm from a sentence; one about an interlock begins with its id."""
    found = re.fullmatch(r"(IL-\d\d): (.*)", text)
    values = {"interlock": found[1], "why": found[2]} if found else {"text": text}
    return Alarm(_IDS[name], "", values) if name in _IDS else Alarm("arbiter.fault", name, values)
