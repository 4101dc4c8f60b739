"""Which time stamps count: not ahead of now, not too old, and not before the last of their source that counted."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.vocabulary import Alarm

SAID_US, LATE_SAID_US = 10_000_000, 1_000_000
"""So long after the last refusal it is told; what came late is told otherwise as well: the readings are stale."""
LATE_US = 60_000_000
"""What is older has not waited so long: its stamp is wrong."""
HIGHEST = 2**63 - 1
_OLD = "too old"


class StampGate:
    """Lets stamps of one kind pass or refuses them; a refusal is counted and told, and moves nothing else.

    Args:
        what: that is stamped, for a sentence; plural.
        old_us: what is so old, or older, is refused; None: age does not matter.
        in_order: whether what is older than the last of its source that passed is refused.
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
        """How many, since the start."""
        self._last: dict[str, int] = {}
        self._until: int | None = None
        self._why, self._said_us = "", 0

    def passes(self, stamp: object, now: int, old_us: int | None = None, source: str = "") -> bool:
        """Whether a stamp counts.

        Args:
            stamp: µs on the monotonic clock, as it came: whatever it is.
            now: µs on the same clock.
            old_us: what is so old is refused; default: of the gate.
            source: whose order it is a part of: others may be later, or have been delivered before.
        """
        why = self._why_not(stamp, now, self._old_us if old_us is None else old_us, source)
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
        """The alarm of what was refused lately."""
        if self.deadline(at) is None:
            return ()
        late = self._said_us == LATE_SAID_US
        doubt = (
            "Did the machine stand still?"
            if late
            else "Is a clock wrong, or does somebody else publish them?"
        )
        return (Alarm("stamps.refused", self._what, {"why": self._why, "doubt": doubt}),)

    def deadline(self, at: int) -> int | None:
        """µs at which the notice ends by itself."""
        return self._until if self._until is not None and self._until > at else None

    def _why_not(self, stamp: object, now: int, old_us: int | None, source: str) -> str:
        if type(stamp) is not int or not 0 <= stamp <= HIGHEST:
            return "stamped with what is no time"
        if stamp > now:
            return "stamped ahead of now"
        if self._in_order and stamp < self._last.get(source, 0):
            return "stamped before the one that came last"
        if old_us is not None and now - stamp >= old_us:
            return _OLD
        return ""
