"""The rules for time stamps: not in the future, not too old, not before the last one of their source."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.vocabulary import Alarm

SAID_US, LATE_SAID_US = 10_000_000, 1_000_000
"""Time for which a refusal is reported, µs.

It is shorter for a message that is only late, because its readings are reported as stale too.
"""
LATE_US = 60_000_000
"""Age from which a stamp counts as wrong rather than late, µs: no message waits so long."""
HIGHEST = 2**63 - 1
_OLD = "too old"


class StampGate:
    """Accepts or refuses the time stamps of one kind of message.

    A refusal is counted and reported, and has no other effect.

    Args:
        what: the stamped things in a sentence, plural.
        old_us: age from which a stamp is refused, µs; None: age does not matter.
        in_order: whether a stamp that is older than the last accepted one of its source is refused.
    """

    MEMORY: ClassVar = {
        "refused": int,
        "_last": dict[str, int],
        "_until": int | None,
        "_why": str,
        "_said_us": int,
    }

    def __init__(self, what: str, *, old_us: int | None = None, in_order: bool = False) -> None:
        self._what, self._old_us, self._in_order = what, old_us, in_order
        self.refused = 0
        """Number of refusals since the start."""
        self._last: dict[str, int] = {}
        self._until: int | None = None
        self._why, self._said_us = "", 0

    def passes(self, stamp: object, now: int, old_us: int | None = None, source: str = "") -> bool:
        """Return whether a stamp is accepted.

        Args:
            stamp: µs on the monotonic clock; as received, so of any type.
            now: µs on the same clock.
            old_us: age from which the stamp is refused, µs; default: that of the gate.
            source: the source whose order counts; stamps of other sources may be later, or may have arrived earlier.
        """
        old_us = self._old_us if old_us is None else old_us
        if type(stamp) is int and self._last.get(source, 0) <= stamp <= now and now - stamp < (old_us or 0):
            self._last[source] = stamp  # as almost always
            return True
        why = self._why_not(stamp, now, old_us, source)
        if not why and type(stamp) is int:
            self._last[source] = stamp
            return True
        self.refused += 1
        late = type(stamp) is int and 0 <= now - stamp < LATE_US and why == _OLD
        said_us = LATE_SAID_US if late else SAID_US
        if (
            not self.notices(now) or said_us > self._said_us
        ):  # the words of its beginning: it does not flicker
            self._why, self._said_us = why, said_us
        self._until = max(self._until or 0, now + said_us)
        return False

    def notices(self, at: int) -> tuple[Alarm, ...]:
        """Return the alarm about recent refusals, if any."""
        if self._until is None or self._until <= at:
            return ()
        late = self._said_us == LATE_SAID_US
        doubt = (
            "Did the machine stand still?"
            if late
            else "Is a clock wrong, or does somebody else publish them?"
        )
        return (Alarm("stamps.refused", self._what, {"why": self._why, "doubt": doubt}),)

    def deadline(self, at: int) -> int | None:
        """Return the time at which the alarm ends by itself, µs; None: there is no alarm."""
        return self._until if self._until is not None and self._until > at else None

    def _why_not(self, stamp: object, now: int, old_us: int | None, source: str) -> str:
        if type(stamp) is not int or not 0 <= stamp <= HIGHEST:
            return "stamped with what is no time"
        if stamp > now:
            return "stamped ahead of now"
        if old_us is not None and now - stamp >= old_us:
            return _OLD  # before order: the oldest possible time may be before that of the frame before
        if self._in_order and stamp < self._last.get(source, 0):
            return "stamped before the one that came last"
        return ""
