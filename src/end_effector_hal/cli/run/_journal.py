"""Lines with fields in the journal of systemd: `journalctl EEHAL_TOOL=my_tool EEHAL_EVENT=TimedOut` finds them."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Mapping
from contextlib import suppress

from end_effector_hal.control import FAILURES, EventKind, ToolEvent
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import Alarm, Cause, ChangerState, EndEffectorState

SOCKET = "/run/systemd/journal/socket"
LONGEST = 4096
"""Longest value of a field, bytes."""
_ERROR, _WARNING, _INFO = "3", "4", "6"
"""Priorities of syslog."""


class SystemdJournal:
    """Sends records to journald in its native protocol, a datagram for each. It never waits: a record that journald
    does not accept at once is lost, and the next one that it accepts is preceded by the number of lost ones.

    Args:
        tool: the name of the tool, which is EEHAL_TOOL.
        address: the socket of journald.
    """

    def __init__(self, tool: str, address: str = SOCKET) -> None:
        self._common = {"SYSLOG_IDENTIFIER": "eehal", "EEHAL_TOOL": tool}
        self._address, self._lost = address, 0

    def send(self, message: str, fields: Mapping[str, str], *, error: bool = False) -> None:
        """Send a line; ``fields`` may have a PRIORITY of its own."""
        if self._lost:
            lost = f"{self._lost} lines were lost: the journal did not accept them."
            if self._sent({"MESSAGE": lost, "PRIORITY": _WARNING}):
                self._lost = 0
        if not self._sent({"MESSAGE": message, "PRIORITY": _ERROR if error else _INFO, **fields}):
            self._lost += 1

    def _sent(self, fields: Mapping[str, str]) -> bool:
        """Return whether journald has the record; with the length of each value, none can be taken for a field."""
        record = bytearray()
        for name, value in {**self._common, **fields}.items():
            data = value.encode(errors="replace")[:LONGEST]
            record += b"%s\n%s%s\n" % (name.encode(), len(data).to_bytes(8, "little"), data)
        with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as journald:
            journald.setblocking(False)
            journald.sendto(record, self._address)
            return True
        return False


def journal_of(tool: str) -> SystemdJournal | None:
    """Return the journal for a tool if systemd has connected stdout to it; None: the lines belong on stdout."""
    with suppress(OSError, ValueError):
        found = os.fstat(sys.stdout.fileno())
        if os.environ.get("JOURNAL_STREAM") == f"{found.st_dev}:{found.st_ino}":
            return SystemdJournal(tool)
    return None


def event_fields(description: Description, event: ToolEvent) -> dict[str, str]:
    """Return the fields of an event: its kind such as ``TimedOut``, and what is known of it."""
    kind = event.kind
    fields = {"EEHAL_EVENT": kind.name.title().replace("_", "")}
    if event.actuator >= 0:
        fields["EEHAL_ACTUATOR"] = description.ordered[event.actuator][0]
    if event.attempt:
        fields["EEHAL_ATTEMPT"] = str(event.attempt)
    if event.new >= 0:
        states = ChangerState if kind is EventKind.CHANGER_CHANGED else EndEffectorState
        fields["EEHAL_STATE"] = states(event.new).name
    if event.cause is not Cause.NONE:
        fields["EEHAL_CAUSE"] = event.cause.name
    if kind in FAILURES or event.cause is not Cause.NONE:
        fields["PRIORITY"] = _WARNING
    return fields


def alarm_fields(alarm: Alarm, *, over: bool) -> dict[str, str]:
    """Return the fields of an alarm that begins or ends."""
    worse = _INFO if over else _ERROR if alarm.severity == "error" else _WARNING
    event = "AlarmOver" if over else "AlarmBegan"
    return {"EEHAL_EVENT": event, "EEHAL_ALARM": alarm.id, "EEHAL_ABOUT": alarm.about, "PRIORITY": worse}
