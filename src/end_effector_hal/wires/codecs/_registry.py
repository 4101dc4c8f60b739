"""Codecs by name: our own, and those that other distributions add by an entry point."""

from __future__ import annotations

import importlib
from difflib import get_close_matches
from typing import TYPE_CHECKING

from end_effector_hal.errors import UsageError
from end_effector_hal.wires.codecs._codec import Codec
from end_effector_hal.wires.codecs._ees1_ascii import Ees1Ascii
from end_effector_hal.wires.codecs._legacy_nibble import LegacyNibble

if TYPE_CHECKING:
    from importlib.metadata import EntryPoints

GROUP = "end_effector_hal.codecs"
_OWN: dict[str, Codec] = {codec.name: codec for codec in (Ees1Ascii(), LegacyNibble())}


def codec_names() -> tuple[str, ...]:
    """All that `get_codec` knows, our own first."""
    return (*_OWN, *sorted(_added().names - set(_OWN)))


def get_codec(name: str) -> Codec:
    """The codec of that name.

    Another distribution adds one by an entry point, a class or an object, in ``end_effector_hal.codecs``.

    Raises:
        UsageError: there is none of that name (did you mean …), or it cannot be loaded.
    """
    if name in _OWN:
        return _OWN[name]
    for entry in _added().select(name=name):
        try:
            loaded = entry.load()
            codec: Codec = loaded() if isinstance(loaded, type) else loaded
        except Exception as error:  # a plug-in may raise anything
            raise UsageError(
                f"the codec {name} cannot be loaded: {type(error).__name__}: {error}",
                where=entry.value,
                todo="Repair or remove the distribution that provides it.",
            ) from error
        return codec
    close = get_close_matches(name, codec_names(), n=1)
    hint = f"Did you mean {close[0]}?" if close else f"There are: {', '.join(codec_names())}."
    raise UsageError(f"there is no codec {name!r}.", todo=hint)


def _added() -> EntryPoints:
    # Imported here: it takes longer than all of the rest, and nobody needs it for our own codecs.
    found: EntryPoints = importlib.import_module("importlib.metadata").entry_points(group=GROUP)
    return found
