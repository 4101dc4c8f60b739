"""What a held part does without power, or when its device hears nothing, is told by the check."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import match_codec
from end_effector_hal.description import examine_text

REGISTER = "modbus: {{unit: 9, address: 0, command_on: [1], command_off: [0]{}}}"
SILENT, POWER = (
    "a held part falls when the bus or the line arbiter is silent",
    "a held part falls without power",
)
NOBODY = "the description does not say whether"


@pytest.mark.parametrize(
    ("output", "told"),
    [
        ("line: A", []),
        ("line: A, on_power_loss: hold", []),
        ("line: A, on_power_loss: release", [f"cup: {POWER} (on_power_loss: release)"]),
        ("line: A, on_power_loss: undefined", [f"cup: {NOBODY} {POWER} (on_power_loss: undefined)"]),
        (
            REGISTER.format(""),
            [
                f"cup: {NOBODY} {SILENT} (on_link_loss: undefined)",
                f"cup: {NOBODY} {POWER} (on_power_loss: undefined)",
            ],
        ),
        (REGISTER.format(", on_link_loss: hold") + ", on_power_loss: keep", []),
        (
            REGISTER.format(", on_link_loss: release, keep_alive_ms: 9000") + ", on_power_loss: release",
            [f"cup: {SILENT} for 9000 ms (on_link_loss: release)", f"cup: {POWER} (on_power_loss: release)"],
        ),
    ],
)
def test_what_falls_is_told(output: str, told: list[str]) -> None:
    examination = examine_text(
        "name: tool\nlink: {port: x, frame: {modbus: {}}}\nchannels: {p: {modbus: {unit: 9, address: 7}, unit: kPa}}\n"
        f"sequence: [cup]\nactuators: {{cup: {{kind: vacuum, channel: p, {output}}}}}\nsupply: {{channel: none}}\n",
        "tool.yaml",
    )
    assert examination.description is not None, examination.lines()
    assert [each for each in match_codec(examination.description).slow if "_loss" in each] == told
