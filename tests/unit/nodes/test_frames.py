"""A frame is made and judged once for the nodes of a process that work with the same tool."""

from __future__ import annotations

from dataclasses import replace

from end_effector_hal.description import Description
from end_effector_hal.nodes.transport import Frames, SharedFrames, frame_to_message
from end_effector_hal.signals import Frame

FRAME = Frame(20_000, 1, 20, {"bottom": -60_000, "humidity": 5})


def test_all_who_get_a_message_get_the_frame_of_the_link(verdin: Description) -> None:
    frames = Frames(verdin)
    message = frames.message_of(FRAME)
    assert frames.frame_of(message) is FRAME


def test_a_message_from_outside_becomes_one_frame_of_the_channels_that_are_known(verdin: Description) -> None:
    frames, message = Frames(verdin), frame_to_message(FRAME)
    frame = frames.frame_of(message)
    assert dict(frame.values) == {"bottom": -60_000}
    assert frames.frame_of(message) is frame


def test_another_message_is_another_frame_though_it_says_the_same(verdin: Description) -> None:
    frames = Frames(verdin)
    first = frames.message_of(FRAME)
    other = replace(first)
    assert frames.frame_of(other) is not FRAME
    assert frames.frame_of(replace(other, at_us=40_000)).at == 40_000


def test_only_nodes_of_equal_descriptions_share(verdin: Description) -> None:
    shared, other = SharedFrames(), verdin.model_copy(update={"name": "another"})
    assert shared.of(verdin) is shared.of(verdin.model_copy())
    assert shared.of(other) is not shared.of(verdin)
