"""Who has gone, in virtual time."""

from __future__ import annotations

from end_effector_hal.ros1._presence import Presence


def test_a_node_that_was_never_heard_has_gone() -> None:
    presence = Presence(("Grip", "ToolChange"))
    assert presence.gone(0) == ("Grip", "ToolChange")
    assert not presence.known("Grip")


def test_a_node_has_gone_after_more_than_a_second() -> None:
    presence = Presence(("Grip",))
    presence.heard("Grip", 500_000)
    assert presence.gone(1_500_000) == ()
    assert presence.gone(1_500_001) == ("Grip",)
    assert presence.known("Grip")
    presence.heard("Grip", 1_600_000)
    assert presence.gone(1_700_000) == ()
