"""Who has gone, in virtual time."""

from __future__ import annotations

from end_effector_hal.nodes.hal_main._aggregate import Silence


def test_a_node_that_was_never_heard_has_gone() -> None:
    silence = Silence(("Grip", "ToolChange"))
    assert silence.silent(0) == ("Grip", "ToolChange")
    assert not silence.has_reported("Grip")


def test_a_node_has_gone_after_more_than_a_second() -> None:
    silence = Silence(("Grip",))
    silence.reported("Grip", 500_000)
    assert silence.silent(1_500_000) == ()
    assert silence.silent(1_500_001) == ("Grip",)
    assert silence.has_reported("Grip")
    silence.reported("Grip", 1_600_000)
    assert silence.silent(1_700_000) == ()
