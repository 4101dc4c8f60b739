"""A codec from the stanzas that a user writes."""

from __future__ import annotations

from end_effector_hal.codecs import codec_of
from end_effector_hal.codecs.described._codec import DescribedCodec
from end_effector_hal.description import Description, examine_text

TOOL = """\
name: tool
link:
  port: /dev/ttyUSB0
{link}
channels:
{channels}
sequence: [cups]
actuators:
  cups: {{kind: vacuum, line: GPIO5, channel: {first}}}
supply: {{channel: none}}
"""


def tool(frame: str, *channels: str, link: str = "") -> Description:
    """A tool with this frame, these channels (the first for the actuator) and more keys of its link."""
    lines = [f"frame: {frame}", *link.splitlines()]
    text = TOOL.format(
        link="\n".join(f"  {each}" for each in lines),
        channels="\n".join(f"  {each}" for each in channels),
        first=channels[0].partition(":")[0],
    )
    examination = examine_text(text, "tool.yaml")
    assert examination.description is not None, examination.lines()
    return examination.description


def declared(frame: str, *channels: str, link: str = "") -> DescribedCodec:
    """The codec of its link."""
    codec = codec_of(tool(frame, *channels, link=link))
    assert isinstance(codec, DescribedCodec)
    return codec
