"""A tool with a device of the library is proven, as any tool is; one of each kind here, the others in CI."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.control import load_automata
from end_effector_hal.description import DeviceLibrary, LibraryDevice
from end_effector_hal.verification.lemmas import prove_tool

HERE = ("robotiq-2f85", "robotiq-epick")
GRIPPERS = [
    pytest.param(each, marks=() if each.name in HERE else pytest.mark.thinned, id=each.name)
    for each in map(DeviceLibrary().get, DeviceLibrary().names())
    if isinstance(each, LibraryDevice) and "kind" in each.about.actuator
]


@pytest.mark.parametrize("device", GRIPPERS)
def test_a_tool_with_it_is_proven(device: LibraryDevice, tmp_path: Path) -> None:
    output = f", output: {next(iter(device.about.outputs))}" if device.about.outputs else ""
    path = tmp_path / "tool.yaml"
    path.write_text(
        "name: tool\nlink: {port: /dev/a}\nsequence: [a]\nsupply: {channel: none}\n"
        f"actuators: {{a: {{device: {device.name}{output}}}}}\n"
    )
    tool = load_tool(path)
    assert prove_tool(tool, load_automata(tool)).holds
