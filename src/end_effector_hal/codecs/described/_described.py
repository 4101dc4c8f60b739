"""Makes a codec from the stanzas of a description."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from end_effector_hal._extras import missing_extra
from end_effector_hal.codecs.described._asked import AskedLines
from end_effector_hal.codecs.described._codec import DescribedCodec, SerialLine
from end_effector_hal.codecs.described._json import DescribedJson
from end_effector_hal.codecs.described._record import DescribedRecord
from end_effector_hal.codecs.described._text import DescribedText
from end_effector_hal.description import has_line

if TYPE_CHECKING:
    from end_effector_hal.description import Channel, Link

BAUDRATE, MODBUS_BAUDRATE = 115_200, 9_600


def described_codec(link: Link, over: Mapping[str, Channel]) -> DescribedCodec:
    """Return the codec that the ``frame`` of a link declares, with the channels of that link.

    Raises:
        MissingExtraError: Modbus needs a package that is not installed.
    """
    assert link.frame is not None
    frame = link.frame
    channels = {name: each for name, each in over.items() if each.source == frame.format}
    usual = BAUDRATE if frame.modbus is None else MODBUS_BAUDRATE
    line = SerialLine(
        (link.baudrate or usual) if has_line(link.port) else 0,
        link.parity or "N",
        link.period_ms and 1000 * link.period_ms,
        link.stopbits or 1,
    )
    asked = frame.text or frame.json_
    if asked is not None:
        lines = DescribedText(frame.text, channels, line) if frame.text else DescribedJson(channels, line)
        return lines if asked.ask is None else AskedLines(lines, asked.ask, line)
    if frame.modbus is not None:
        try:
            from end_effector_hal.codecs.described._modbus import DescribedModbus
        except ModuleNotFoundError as error:
            raise missing_extra("a Modbus frame needs", error) or error from None
        return DescribedModbus(frame.modbus, channels, line)
    assert frame.record is not None
    return DescribedRecord(frame.record, channels, line)
