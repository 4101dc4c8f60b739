"""A link and the inputs of the board together: two sources, one stream of frames."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.description import Description, examine_text
from end_effector_hal.errors import LineBusyError
from end_effector_hal.signals import Frame
from end_effector_hal.wires import Claim
from end_effector_hal.wires.lines import VirtualChip, VirtualPins
from end_effector_hal.wires.link import LinkHealth, LinkState, PtyPair
from end_effector_hal.wires.sensors import SensorReader
from tests.support.patience import wait_until

TOOL = """
schema: 2
name: both
lines: {{backend: virtual, path: {folder}/chip}}
link: {{port: {folder}/uart, codec: ees1-ascii}}
inputs: {{period_ms: 5}}
channels:
  switch: {{digital: {{line: A}}}}
sequence: [one, two]
actuators:
  one: {{kind: vacuum, line: OUT1, channel: switch}}
  two: {{kind: vacuum, line: OUT2, channel: bottom}}
"""
CODEC = get_codec("ees1-ascii")


@pytest.fixture
def tool(tmp_path: Path) -> Iterator[tuple[Description, PtyPair]]:
    description = examine_text(TOOL.format(folder=tmp_path), tmp_path / "tool.yaml").description
    assert description
    VirtualChip.create(tmp_path / "chip", ["A", "OUT1", "OUT2"])
    pair = PtyPair(str(tmp_path / "uart"))
    yield description, pair
    pair.close()


def test_frames_of_both_come_in_the_order_of_their_stamps(
    tool: tuple[Description, PtyPair], tmp_path: Path
) -> None:
    description, pair = tool
    frames: list[Frame] = []
    told: list[object] = []
    reader = SensorReader(description, frames.append, lambda source, health: told.append(health))
    reader.start()
    pins = VirtualPins(tmp_path / "chip")
    try:
        for seq in range(20):
            pins.drive({"A": seq % 2 == 0})
            pair.write(CODEC.encode(Frame(0, seq, 20 * seq, {"bottom": -1000 * seq})))
            wait_until("it", lambda seq=seq: any(each.seq == seq for each in frames))  # type: ignore[misc]
        wait_until("edges", lambda: (health := reader.health.inputs) and health.edges >= 20)
    finally:
        reader.close()
        pins.close()
    stamps = [frame.at for frame in frames]
    assert stamps == sorted(stamps)
    assert {("switch" in frame.values, "bottom" in frame.values) for frame in frames} == {
        (True, False),
        (False, True),
    }
    assert reader.health.links[""].frames == 20
    assert [each.state for each in told if isinstance(each, LinkHealth)] == [LinkState.SILENT, LinkState.UP]


def test_a_busy_input_line_gives_the_link_back(tool: tuple[Description, PtyPair], tmp_path: Path) -> None:
    description, _ = tool
    claim = Claim(tmp_path / "chip.inputs.lock", "an input line of the virtual chip")
    reader = SensorReader(description, lambda frame: None)
    with pytest.raises(LineBusyError):
        reader.start()
    claim.release()
    again = SensorReader(description, lambda frame: None)
    again.start()  # the port is free
    again.close()
