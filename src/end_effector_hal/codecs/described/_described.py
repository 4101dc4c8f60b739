"""From the stanzas of a description to a codec."""

from __future__ import annotations

from typing import TYPE_CHECKING

from end_effector_hal.codecs._codec import Codec
from end_effector_hal.errors import UsageError

if TYPE_CHECKING:
    from end_effector_hal.description import Description


def described_codec(description: Description) -> Codec:
    """The codec that ``link: frame`` and the channels of a description declare.

    Raises:
        UsageError: this format cannot be read yet.
    """
    raise UsageError(
        "a declared frame cannot be read yet.",
        where=description.where("link", "frame"),
        todo="Name a codec: docs/codecs.md lists them.",
    )
