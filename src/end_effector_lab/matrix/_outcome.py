"""What can become of a tool, in one word each."""

from __future__ import annotations

from enum import StrEnum


class Outcome(StrEnum):
    """How the tool stands when nothing moves any more."""

    AT_REST = "at rest"
    """Nothing was begun."""
    REFUSED = "refused"
    """At rest: the last command was refused with a reason."""
    SUCCESS = "gripped"
    FAILED = "declared failure"
    """At rest: the grip was given up and unwound."""
    CANCELLED = "cancelled"
    RELEASED = "dropped on command"
    UNWOUND = "unwound by the last will"
    HELD = "held with alarm"
    """GRIP_ERROR, latched: every output stays."""
    STILL_THERE = "release error"
    """RELEASE_ERROR, latched: that all is gone is not proven."""
    UNFINISHED = "not at rest in its time"
