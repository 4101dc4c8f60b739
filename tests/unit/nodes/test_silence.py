"""Whether Grip has gone, in virtual time."""

from __future__ import annotations

from end_effector_hal.nodes._silence import Silence


def test_what_was_never_heard_is_silent() -> None:
    silence = Silence()
    assert silence.lasts(0)
    assert not silence.has_reported
    assert silence.alarm.name == "node.awaited:Grip"


def test_grip_is_silent_after_more_than_a_second() -> None:
    silence = Silence()
    silence.reported(500_000)
    assert not silence.lasts(1_500_000)
    assert silence.lasts(1_500_001)
    assert silence.alarm.name == "node.silent:Grip"
    silence.reported(1_600_000)
    assert not silence.lasts(1_700_000)
