"""A device also sends channels that nothing uses: the testbench sends values that can be, none that is invalid."""

from __future__ import annotations

from end_effector_hal.codecs import codec_of
from end_effector_hal.description import examine_text
from end_effector_hal.signals import Frame
from end_effector_lab.testbench import Bench, SensorBoard
from end_effector_lab.virtual import VirtualTool

TOOL = """\
name: cup
link: {port: /dev/a, frame: {text: {start: "$"}}}
channels:
  cup: {text: {field: 1}, unit: kPa}
  tank: {text: {field: 2}, unit: bar, range: [1, 10], invalid: [-9999]}
  door: {text: {field: 3}, on: [7], invalid: [0]}
  lamp: {digital: {line: X}}
sequence: [cup]
actuators: {cup: {kind: vacuum, line: A, channel: cup}}
supply: {channel: none}
"""


def test_what_nothing_uses_has_a_value_of_its_range() -> None:
    description = examine_text(TOOL, "tool.yaml").description
    assert description
    codec = codec_of(description)
    board = SensorBoard(codec, Bench(description), description, 0)
    (frame,) = codec.decoder().feed(board.frame(20_000).data, 20_000)
    assert (frame.values["tank"], frame.values["door"]) == (100_000, False)


def test_no_frame_has_a_channel_without_a_value_in_virtual_time() -> None:
    description = examine_text(TOOL, "tool.yaml").description
    assert description
    frames: list[Frame] = []
    tool = VirtualTool(description, on_frame=frames.append)
    tool.run(2.0)
    assert {name for frame in frames for name in frame.values} == {"cup", "tank", "door", "lamp"}
    assert not [frame for frame in frames if None in frame.values.values()]
