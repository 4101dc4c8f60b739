"""An attempt that has gripped nothing: executed, recorded, replayed, and a run of the network."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.codecs import load_tool
from end_effector_hal.verification.replay import review
from end_effector_hal.vocabulary import Cause, EndEffectorState
from tests.support.recorded_tool import RecordedTool

TOOL = """
name: jaw_tool
link: {port: /dev/ttyUSB0}
sequence: [jaw]
actuators: {jaw: {kind: gripper, line: JAW, open_bit: cylinder_retracted, closed_bit: cylinder_extended, timeout_s: 2}}
tool_changer: {line: UNLOCK}
supply: {channel: none}
"""


def test_it_is_over_long_before_its_time_out(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(TOOL, encoding="utf-8")
    tool = RecordedTool(tmp_path, "no-part:jaw", description=load_tool(path))
    tool.run(1.5)
    assert tool.command("grip").accepted
    tool.run(5.0)
    times = [at for at, line, _ in tool.edges if line == "JAW"]
    lengths = [end - begin for begin, end in zip(times[::2], times[1::2], strict=True)]
    assert len(lengths) == 3
    assert max(lengths) < 1_000_000
    error = next(status for status in tool.statuses if status.ee is EndEffectorState.GRIP_ERROR)
    assert error.cause is Cause.EMPTY
    assert tool.status.ee is EndEffectorState.STAND_BY
    found = review(tool.trace())
    assert found.ok, found.as_json()
    assert found.replay.inputs > 100
