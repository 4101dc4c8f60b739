"""Alarms: conditions that an operator must know. An alarm has an identity; its text comes from one table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from typing import Literal, NamedTuple

from ._tables import display_name
from ._text import LONGEST_SENTENCE, printable

_KEPT = "active outputs stay active, only a Drop releases"
OVER = "Over: "
"""Prefix of the text of an alarm that has ended and waits for an acknowledgement."""
ARBITER_LOST, STOPPED, E_STOPPED = "arbiter.lost", "arbiter.stopped", "arbiter.e_stopped"
WEAK, LEAK, EMPTY = "grip.weak", "grip.leak", "grip.empty"
LATCHED_ERRORS = ("grip.error", "release.error")
UNKNOWN_ALARM = "unknown"
"""Id for a received alarm whose id is not in the table."""
LONGEST_ABOUT, MOST_ALARMS = 200, 256


class AlarmText(NamedTuple):
    """The texts and the severity of an alarm.

    Attributes:
        severity: ``error``: something does not work, or a held part may be at risk; ``warning``: everything works.
        texts: templates; the first one whose values are all present is used. ``who`` is the display name of ``about``.
        over: text once the alarm has ended and is not acknowledged; empty: the same text.
    """

    severity: Literal["error", "warning"]
    texts: tuple[str, ...]
    over: str = ""


def _error(*texts: str, over: str = "") -> AlarmText:
    return AlarmText("error", texts, over)


def _warning(*texts: str, over: str = "") -> AlarmText:
    return AlarmText("warning", texts, over)


ALARMS: Mapping[str, AlarmText] = {
    ARBITER_LOST: _error(
        "The line arbiter is lost: what is held and the outputs are the last known ones, "
        "and are not known now ({why})."
    ),
    "hal.lost": _error(
        "{why} The outputs, and whether a part is held, are as last known; if the HAL has ended, the line arbiter "
        "sets the outputs as the description declares."
    ),
    STOPPED: _error("{interlock}: {why}"),
    E_STOPPED: _error("{interlock}: {why}"),
    "arbiter.fault": _error("{interlock}: {why}", "{text}"),
    "lines.not_adopted": _error("{text}"),
    "lines.not_written": _error("The lines could not be written: {why}"),
    "maintenance.active": _warning("{text}"),
    "link.down": _error("The {sensors}."),
    "link.fault": _warning("{text}"),
    "link.restarted": _warning(
        "The {about} restarted{again}; earlier readings were discarded.",
    ),
    "link.two_senders": _warning(
        "Two senders on one link, or the {about} restarts again and again: its frames are in no order "
        "and prove nothing. Disconnect one of the two, or see to the power of the device."
    ),
    "stamps.refused": _warning("{about} are refused and count for nothing: one is {why}. {doubt}"),
    "channel.doubted": _warning("{text}"),
    "channel.unread": _warning("No valid reading of {about}: {why}.", "No valid reading of {about}."),
    "evidence.settling": _warning("{names}: readings are back; evidence not re-established yet."),
    "evidence.contradicts": _error(
        "The sensors of {who} contradict each other ({seen}): they prove nothing. "
        "Is one broken, or wired wrongly?"
    ),
    "evidence.unread": _error(
        f"No valid reading of {{who}} while it holds a part ({{why}}); {_KEPT}.",
        f"No valid reading of {{who}} while it holds a part; {_KEPT}.",
        over="{who} had no valid reading for a while; it is read again.",
    ),
    "kind.failed": _error("{who} is not {what} reliably: {why}", "{why}"),
    EMPTY: _warning("{who} {empty}."),
    WEAK: _warning(
        "Weak grip: {who} fell to {kpa:.1f} kPa; minimum for a secure grip: {least_kpa:g} kPa.",
        "Weak grip: {who} did not reach {secure_kpa:g} kPa within {within_s:g} s ({kpa:.1f} kPa).",
        over="{who} was not secure for a while; it is again ({kpa:.0f} kPa).",
    ),
    LEAK: _warning(
        "Leak: {who} falls by {falls:.1f} kPa/s from {kpa:.1f} kPa and would be lost (under {lost_kpa:g} kPa) "
        "in {left_s:.0f} s.",
        over="{who} leaked for a while; it is at {kpa:.0f} kPa now.",
    ),
    "supply.low": _warning(
        "Low supply: under {warn_kpa:g} kPa while a part is held ({kpa:.0f} kPa).",
        "Low supply: under {warn_kpa:g} kPa.",
        over="The supply pressure was under {warn_kpa:g} kPa while a part was held.",
    ),
    "grip.error": _error(
        "GRIP_ERROR: {why} Active outputs stay active; only a Drop releases.",
        "GRIP_ERROR: Active outputs stay active; only a Drop releases.",
    ),
    "release.error": _error(
        "RELEASE_ERROR: {why} Remedy it, then Drop again.", "RELEASE_ERROR: Remedy it, then Drop again."
    ),
    "changer.fault": _error(
        "The tool changer is in FAULT: its sensors do not prove where it is. Remedy it, then Lock."
    ),
    "changer.loose": _error(
        f"IL-05: {{why}} while a part is held: do not lift; {_KEPT}.",
        over="The tool was not proven to be locked while a part was held.",
    ),
    "device.error": _error("{channel}: {what}."),
    "device.warning": _warning("{channel}: {what}."),
    "listener.failed": _warning("{text}"),
    "recording.failed": _warning("{text}"),
    UNKNOWN_ALARM: _warning("{text}"),
}
"""The texts of all alarms, by id."""


@dataclass(frozen=True, slots=True)
class Alarm:
    """One alarm; two alarms are the same if ``id`` and ``about`` are equal, whatever their numbers are.

    Attributes:
        id: id in the table `ALARMS`.
        about: the actuator, link, channel or node concerned; empty: the whole tool.
        values: values for the placeholders of its text.
        since: time of its beginning, µs on the monotonic clock; -1: not known, as in a status that no program has
            published.
        over: whether it has ended, and is shown until it is acknowledged.
    """

    id: str
    about: str = ""
    values: Mapping[str, str | int | float] = field(default_factory=dict)
    since: int = -1
    over: bool = False

    def __hash__(self) -> int:
        return hash(self.key)

    @property
    def key(self) -> tuple[str, str]:
        """Identity of the alarm: its id and the thing concerned."""
        return self.id, self.about

    @property
    def name(self) -> str:
        """Identity of the alarm as one word of a message, such as ``over:grip.leak:top_vacuum``."""
        return ("over:" if self.over else "") + self.id + (f":{self.about}" if self.about else "")

    @property
    def severity(self) -> str:
        """Severity of the alarm, ``error`` or ``warning``."""
        return self._kind.severity

    @property
    def text(self) -> str:
        """Text of the alarm as a sentence, without the prefix `OVER`."""
        fields: dict[str, object] = {"about": self.about, "who": display_name(self.about), **self.values}
        over = (self._kind.over,) if self.over and self._kind.over else ()
        for template in ("{text}", *over, *self._kind.texts):
            try:
                return str(template.format_map(fields))
            except (KeyError, ValueError):  # another one fits; of a file or a message perhaps none does
                continue
        return " ".join((self.id, self.about)).rstrip()

    @property
    def _kind(self) -> AlarmText:
        return ALARMS.get(self.id, ALARMS[UNKNOWN_ALARM])

    def as_json(self) -> dict[str, object]:
        """Return the alarm as JSON."""
        names = {"id": self.id, "about": self.about, "severity": self.severity}
        return names | {"text": self.text, "over": self.over}

    def __str__(self) -> str:
        return f"{OVER}{self.text}" if self.over else self.text


Change = Literal["begun", "over", "ended"]


def alarm_changes(before: Iterable[Alarm], now: Iterable[Alarm]) -> Iterator[tuple[Alarm, Change]]:
    """Return the alarms that ended, then those that began, are over or changed their text, compared by identity."""
    old = {each.key: each for each in before}
    new = {each.key: each for each in now}
    yield from ((each, "ended") for key, each in old.items() if key not in new)
    for key, each in new.items():
        if key not in old or (old[key] is not each and str(old[key]) != str(each)):
            yield each, "over" if each.over else "begun"


def distinct(alarms: Iterable[Alarm]) -> tuple[Alarm, ...]:
    """Return every alarm once: the first one with its identity, or the first that is not over."""
    found: dict[tuple[str, str], Alarm] = {}
    for each in alarms:
        known = found.setdefault(each.key, each)
        if known.over and not each.over:
            found[each.key] = each
    return tuple(found.values())


def with_since(alarms: Iterable[Alarm], before: Sequence[Alarm], at: int) -> tuple[Alarm, ...]:
    """Return the alarms with the time of their beginning: as in ``before``, else ``at`` µs."""
    since = {each.key: each.since for each in before}
    return tuple(
        [each if each.since >= 0 else replace(each, since=since.get(each.key, at)) for each in alarms]
    )


def received_alarms(texts: Sequence[str], names: Sequence[str] = ()) -> tuple[Alarm, ...]:
    """Build alarms from the sentences and names of a message; lengths, numbers and ids are bounded."""
    return tuple(
        [
            _received(text or "", name or "")
            for text, name in zip_longest(texts[:MOST_ALARMS], names[: min(len(texts), MOST_ALARMS)])
        ]
    )


def _received(text: str, name: str) -> Alarm:
    over = name.startswith("over:")
    id_, _, about = name.removeprefix("over:").partition(":")
    text = printable(text.removeprefix(OVER) if over else text, LONGEST_SENTENCE)
    if id_ not in ALARMS:
        id_, about = UNKNOWN_ALARM, text
    return Alarm(id_, printable(about, LONGEST_ABOUT), {"text": text}, over=over)
