"""How long a grip, a release and a cancel may take: as the integrator requires, or what the steps add up to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from end_effector_hal.kinds.stanza import Actuator

from ._stanzas import Bounds


@dataclass(frozen=True, slots=True)
class Durations:
    """What the proof holds the automata to, ms.

    Attributes:
        grip_ms, release_ms, cancel_ms: every grip is over, every release, every unwinding of a cancelled grip.
        computed: keys of `bounds` that are not written, and were computed.
    """

    grip_ms: int
    release_ms: int
    cancel_ms: int
    computed: tuple[str, ...] = ()

    def seconds(self, key: str) -> float:
        """By the key that it has in ``bounds``, such as ``grip_s``."""
        found: int = getattr(self, f"{key.removesuffix('_s')}_ms")
        return found / 1000


def durations(steps: Sequence[Actuator], bounds: Bounds) -> Durations:
    """Those of a tool with these steps (`docs/verification.md`, worst cases).

    A grip takes longest when every attempt but the last of each step times out, is followed by its pause, and the last
    step fails as well; a release, when no feedback goes away in time. Each deadline is late by D. An ending that
    holds, or goes on without a pause, only makes it shorter.
    """
    late = bounds.reaction_ms
    released = sum(_ms(step.release_s) + late for step in steps)
    decided = sum(
        step.attempts * (_ms(step.timeout_s) + late) + (step.attempts - 1) * (_ms(step.reset_s) + late)
        for step in steps
    )
    longest = {"grip_s": decided + released, "release_s": released, "cancel_s": released}
    written = {key: getattr(bounds, key) for key in longest if getattr(bounds, key) is not None}
    grip, release, cancel = (
        _ms(written[key]) if key in written else longest_ms for key, longest_ms in longest.items()
    )
    return Durations(grip, release, cancel, tuple(key for key in longest if key not in written))


def _ms(seconds: float) -> int:
    return round(seconds * 1000)
