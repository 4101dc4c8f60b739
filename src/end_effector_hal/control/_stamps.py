"""Which time stamps count: those that are not ahead of now, not too old, and not before the last that counted."""

from __future__ import annotations

from ._time import to_s

SAID_US = 10_000_000
"""So long after the last refusal it is told."""
HIGHEST = 2**63 - 1


class StampGate:
    """Lets stamps of one source pass or refuses them; a refusal is counted and told, and moves nothing else.

    Args:
        what: that is stamped, for a sentence; plural.
        old_us: what is so old, or older, is refused; None: age does not matter.
        in_order: whether what is older than the last that passed is refused.
    """

    def __init__(self, what: str, *, old_us: int | None = None, in_order: bool = False) -> None:
        self._what, self._old_us, self._in_order = what, old_us, in_order
        self.refused = 0
        """How many, since the start."""
        self._last: int | None = None
        self._refused_at: int | None = None
        self._text = ""

    def passes(self, stamp: object, now: int) -> bool:
        """Whether a stamp counts.

        Args:
            stamp: µs on the monotonic clock, as it came: whatever it is.
            now: µs on the same clock.
        """
        why = self._why_not(stamp, now)
        if not why and type(stamp) is int:
            self._last = stamp
            return True
        self.refused += 1
        if not self.notices(now):  # told in the words of its beginning: it does not flicker
            times = f" {self.refused} since the start." if self.refused > 1 else ""
            doubt = "Is a clock wrong, or does somebody else publish them?"
            self._text = f"{self._what} are refused and count for nothing: one is {why}.{times} {doubt}"
        self._refused_at = now
        return False

    def notices(self, at: int) -> tuple[str, ...]:
        """What was refused lately, in words."""
        end = self.deadline(at)
        return (self._text,) if end is not None else ()

    def deadline(self, at: int) -> int | None:
        """µs at which the notice ends by itself."""
        end = None if self._refused_at is None else self._refused_at + SAID_US
        return end if end is not None and end > at else None

    def _why_not(self, stamp: object, now: int) -> str:
        if type(stamp) is not int or not 0 <= stamp <= HIGHEST:
            return "stamped with what is no time"
        if stamp > now:
            return f"stamped {to_s(stamp - now):.3g} s ahead of now"
        if self._in_order and self._last is not None and stamp < self._last:
            return f"stamped {to_s(self._last - stamp):.3g} s before the one that came last"
        if self._old_us is not None and now - stamp >= self._old_us:
            return f"{to_s(now - stamp):.3g} s old"
        return ""
