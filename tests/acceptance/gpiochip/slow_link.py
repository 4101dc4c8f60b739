"""The shipped tool with a frame every 50 ms.

In the guest a call of the kernel costs five times as much as outside: all nodes at 50 frames a second want more than
one slow processor has, and a HAL whose readings are late refuses to grip, rightly.
"""

from __future__ import annotations

import re
from pathlib import Path

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description, load
from end_effector_hal.signals import Kind

FRAME = """\
  period_ms: 50
  frame: {text: {start: "$", checksum: xor8}}

channels:
"""


def with_a_slow_link(tool: Description, file: Path) -> Description:
    """The same tool, written to ``file``: its channels in frames of text that the description declares."""
    channels = "".join(
        f"  {name}: {{text: {{key: {name}, decimals: 2}}, unit: kPa, range: [-110, 2000]}}\n"
        if kind is Kind.PRESSURE
        else f"  {name}: {{text: {{key: {name}}}, on: [1]}}\n"
        for name, kind in carrier_of(tool).channels.items()
    )
    text, replaced = re.subn(r"  codec: .*\n", FRAME + channels, tool.source.read_text())
    assert replaced == 1
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"schema: 2\n{text}")
    return load(file)
