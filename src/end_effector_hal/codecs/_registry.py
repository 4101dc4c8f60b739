"""Codecs by name: our own, and those that other distributions add by an entry point."""

from __future__ import annotations

import importlib
from difflib import get_close_matches
from functools import cache
from typing import TYPE_CHECKING

from end_effector_hal._extras import missing_extra
from end_effector_hal.codecs._codec import Codec
from end_effector_hal.codecs._declared import declared
from end_effector_hal.codecs._named import named
from end_effector_hal.errors import UsageError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoints

    from end_effector_hal.description import Description

GROUP = "end_effector_hal.codecs"
# The entry points of this distribution, as pyproject.toml has them too: known without reading any metadata, which
# takes longer than all of the rest; each is imported when it is wanted.
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
    return (*OWN, *sorted(_added().names - set(OWN)))


def get_codec(name: str) -> Codec:
    """The codec of that name.

    Another distribution adds one by an entry point, a class or an object, in ``end_effector_hal.codecs``.

    Raises:
        UsageError: there is none of that name (did you mean …), or it cannot be loaded.
    """
    if name in OWN:
        return _own(name)
    for entry in _added().select(name=name):
        try:
            loaded = entry.load()
            codec: Codec = loaded() if isinstance(loaded, type) else loaded
            missing = [part for part in _PARTS if not hasattr(codec, part)]
            codec = codec if missing else declared(codec)
        except UsageError as error:
            raise UsageError(f"the codec {name}: {error.what}", where=entry.value, todo=error.todo) from error
        except (Exception, SystemExit, GeneratorExit) as error:  # a plug-in may raise anything
            if isinstance(error, ModuleNotFoundError) and (
                missing_package := missing_extra(f"The codec {name} needs", error)
            ):
                raise missing_package from None
            raise UsageError(
                f"the codec {name} cannot be loaded: {named(error)}",
                where=entry.value,
                todo="Repair or remove the distribution that provides it.",
            ) from error
        if missing:
            raise UsageError(
                f"the codec {name} is none: it has no {', '.join(missing)}.",
                where=entry.value,
                todo="Inherit end_effector_hal.codecs.conformance.CodecConformance in its tests.",
            )
        return codec
    close = get_close_matches(name, codec_names(), n=1)
    hint = f"Did you mean {close[0]}?" if close else f"There are: {', '.join(codec_names())}."
    raise UsageError(f"there is no codec {name!r}.", todo=hint)


def codec_of(description: Description) -> Codec:
    """The codec that a description names; raises UsageError with its place there."""
    try:
        return get_codec(description.link.codec)
    except UsageError as error:
        raise UsageError(error.what, where=description.where("link", "codec"), todo=error.todo) from error


@cache
def _own(name: str) -> Codec:
    module, _, attribute = OWN[name].partition(":")
    try:
        codec: Codec = getattr(importlib.import_module(module), attribute)()
    except ModuleNotFoundError as error:
        raise missing_extra(f"The codec {name} needs", error) or error from None
    return codec


def _added() -> EntryPoints:
    found: EntryPoints = importlib.import_module("importlib.metadata").entry_points(group=GROUP)
    return found
