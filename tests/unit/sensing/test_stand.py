"""Where the tool is, by the two bits of its stand, and never by a reading that is not fresh."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.description import ToolChanger, load, profile_path
from end_effector_hal.sensing import ToolPlace, tool_place
from end_effector_hal.sensing._readings import Readings
from end_effector_hal.signals import Frame

CHANGER = ToolChanger(line="SODIMM_206")


@pytest.mark.parametrize(
    ("present", "in_stand", "place"),
    [
        (True, True, ToolPlace.IN_STAND),
        (True, False, ToolPlace.AWAY),
        (False, False, ToolPlace.ABSENT),
        (False, True, ToolPlace.ABSENT),
        (False, None, ToolPlace.ABSENT),
        (True, None, ToolPlace.UNKNOWN),
        (None, True, ToolPlace.UNKNOWN),
        (None, False, ToolPlace.UNKNOWN),
    ],
)
def test_place(present: bool | None, in_stand: bool | None, place: ToolPlace) -> None:
    readings = Readings(load(profile_path()), get_codec("ees1-ascii"))
    assert tool_place(CHANGER, readings.judged(0).values) is ToolPlace.UNKNOWN
    readings.take(Frame(0, 1, None, {"tool_present": present, "in_stand": in_stand}))
    readings.idle()
    assert tool_place(CHANGER, readings.judged(149_999).values) is place
    assert tool_place(CHANGER, readings.judged(150_000).values) is ToolPlace.UNKNOWN


def test_a_codec_that_does_not_carry_them_proves_nothing() -> None:
    readings = Readings(load(profile_path()), get_codec("legacy-nibble"))
    readings.take(Frame(0, None, None, {"locked": True}))
    assert tool_place(CHANGER, readings.judged(0).values) is ToolPlace.UNKNOWN
