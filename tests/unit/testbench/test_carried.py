from __future__ import annotations

from end_effector_hal.codecs import get_codec
from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from end_effector_lab.testbench import Bench, carried


def test_the_default_format_carries_all_of_the_shipped_tool(verdin: Description) -> None:
    codec = get_codec("ees1-ascii")
    values = Bench(verdin).sample(0)
    assert carried(values, codec.channels, verdin) == values
    (frame,) = codec.decoder().feed(codec.encode(Frame(0, 1, 2, values)), at=5)
    assert dict(frame.values) == values


def test_a_pressure_on_a_bit_channel_is_a_switch_at_the_threshold(verdin: Description) -> None:
    channels = get_codec("legacy-nibble").channels
    values = {"bottom": -54_999, "top": -55_000, "cylinder_extended": True, "locked": True, "unlocked": False}
    assert carried(values | {"supply": 600_000, "cylinder": 0}, channels, verdin) == {
        "bottom": False,
        "top": True,
        "cylinder_extended": True,
        "locked": True,
        "unlocked": False,
    }


def test_invalid_stays_invalid(verdin: Description) -> None:
    channels = get_codec("legacy-nibble").channels
    assert carried({"bottom": None}, channels, verdin) == {"bottom": None}


def test_switches_of_a_cylinder_and_of_the_supply(verdin: Description) -> None:
    kind = get_codec("legacy-nibble").channels["bottom"]
    channels = {"cylinder": kind, "supply": kind}
    assert carried({"cylinder": 509_000, "supply": 399_000}, channels, verdin) == {
        "cylinder": False,
        "supply": False,
    }
    assert carried({"cylinder": 511_000, "supply": 401_000}, channels, verdin) == {
        "cylinder": True,
        "supply": True,
    }
