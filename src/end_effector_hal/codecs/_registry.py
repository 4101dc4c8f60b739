"""Codecs by name: our own, and those that other distributions add by an entry point."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from end_effector_hal.codecs._codec import Codec
from end_effector_hal.codecs._declared import declared
from end_effector_hal.errors import UsageError
from end_effector_hal.plugins import Plugins

if TYPE_CHECKING:
    from end_effector_hal.description import Description

GROUP = "end_effector_hal.codecs"
OWN = {
    "ees1-ascii": "end_effector_hal.codecs:Ees1Ascii",
    "ees1-cobs": "end_effector_hal.codecs:Ees1Cobs",
    "legacy-nibble": "end_effector_hal.codecs:LegacyNibble",
    "modbus-rtu-epick": "end_effector_hal.codecs.modbus:EPick",
    "modbus-rtu-onrobot-vg": "end_effector_hal.codecs.modbus:OnRobotVG",
    "modbus-rtu-transmitters": "end_effector_hal.codecs.modbus:Transmitters",
}
_PARTS = ("name", "channels", "period_us", "baudrate", "decoder", "encode")


def codec_names() -> tuple[str, ...]:
    """All that `get_codec` knows, our own first."""
    return _CODECS.names


def get_codec(name: str) -> Codec:
    """The codec of that name.

    Another distribution adds one by an entry point, a class or an object, in ``end_effector_hal.codecs``.

    Raises:
        UsageError: there is none of that name (did you mean …), or it cannot be loaded.
    """
    return _CODECS.get(name)


def codec_of(description: Description) -> Codec:
    """The codec that a description names; raises UsageError with its place there."""
    try:
        return get_codec(description.link.codec)
    except UsageError as error:
        raise UsageError(error.what, where=description.where("link", "codec"), todo=error.todo) from error


def _checked(codec: Any) -> Codec:
    if missing := [part for part in _PARTS if not hasattr(codec, part)]:
        raise UsageError(
            f"this is no codec: it has no {', '.join(missing)}.",
            todo="Inherit end_effector_hal.codecs.conformance.CodecConformance in its tests.",
        )
    return declared(codec)


_CODECS: Plugins[Codec] = Plugins(GROUP, "codec", OWN, _checked)
