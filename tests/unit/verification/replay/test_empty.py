"""An attempt that has gripped nothing: executed, recorded, replayed, and a run of the network."""

from __future__ import annotations

from pathlib import Path

import pytest

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
HEARD_US = 101_000
"""By then the tool changer has heard of the grip: bounds.message_ms, and 1 ms."""


@pytest.mark.parametrize("at_once", [False, True])
def test_it_is_over_when_the_tool_changer_has_heard_of_the_grip(tmp_path: Path, *, at_once: bool) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(TOOL, encoding="utf-8")
    tool = RecordedTool(tmp_path, "no-part:jaw", description=load_tool(path))
    tool.run(1.5)
    if at_once:  # fingers that need no time
        sample = tool.bench.sample

        def fast(at: int) -> dict[str, int | bool | None]:
            closed = tool.levels.get("JAW", False)
            return {**sample(at), "cylinder_extended": closed, "cylinder_retracted": not closed}

        tool.bench.sample = fast  # type: ignore[method-assign]
    assert tool.command("grip").accepted
    tool.run(5.0)
    times = [at for at, line, _ in tool.edges if line == "JAW"]
    lengths = [end - begin for begin, end in zip(times[::2], times[1::2], strict=True)]
    assert len(lengths) == 3
    if at_once:
        assert lengths == [HEARD_US] * 3
    else:
        assert all(HEARD_US < length < 1_000_000 for length in lengths)
    error = next(status for status in tool.statuses if status.ee is EndEffectorState.GRIP_ERROR)
    assert error.cause is Cause.EMPTY
    assert tool.status.ee is EndEffectorState.STAND_BY
    found = review(tool.trace())
    assert found.ok, found.as_json()
    assert found.replay.inputs > 100
