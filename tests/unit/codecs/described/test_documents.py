"""What is in docs/reference/channels.md, registers.md and on the pages of examples/tools is true."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from end_effector_hal.codecs import codec_of, load_tool, match_codec
from end_effector_hal.description import examine_text
from end_effector_hal.signals import Value
from tests.support.places import DOCS

PAGES = "".join((DOCS / f"reference/{name}.md").read_text("utf-8") for name in ("channels", "registers"))
BLOCKS = re.findall(r"```yaml\n(.*?)```", PAGES, flags=re.DOTALL)
REST = """\
name: tool
sequence: [a]
actuators: {{a: {{kind: vacuum, line: L, channel: {channel}}}}}
supply: {{channel: none}}
"""


@pytest.mark.parametrize("block", BLOCKS)
def test_each_example_is_valid(block: str) -> None:
    (first,) = re.findall(r"^channels:\n  (\w+)", block, flags=re.MULTILINE)
    text = block if "sequence" in block else block + REST.format(channel=first)
    examination = examine_text(text, "tool.yaml")
    assert examination.lines() == []
    assert examination.description is not None
    assert match_codec(examination.description).faults == ()


def test_the_line_of_the_page_says_what_the_page_says() -> None:
    tool = examine_text(BLOCKS[0], "tool.yaml").description
    assert tool is not None
    (frame,) = codec_of(tool).decoder().feed(b"$0,782.5*3A\r\n", 0)
    assert frame.values == {"cup": -78_250, "part": True}


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("diy_text", {"cup": -78_250, "part": True}),
        ("diy_record", {"cup": -78_300, "air": 600_000, "down": True, "up": False}),
    ],
)
def test_the_bytes_of_an_example_are_what_its_page_says(name: str, values: dict[str, Value]) -> None:
    folder = Path("examples/tools") / name
    block = re.findall(
        r"```\n(.*?)\n```", (folder / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL
    )
    data = block[0].encode() + b"\r\n" if name == "diy_text" else bytes.fromhex(block[0])
    (frame,) = codec_of(load_tool(folder / "end_effector.yaml")).decoder().feed(data, 0)
    assert frame.values == values
