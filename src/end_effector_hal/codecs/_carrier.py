"""What brings the channels of a tool: the codec of its link, the inputs of its board, or both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from end_effector_hal.codecs._codec import Carrier, Codec, parity_of, resolution_of
from end_effector_hal.codecs._registry import get_codec
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Kind

if TYPE_CHECKING:
    from end_effector_hal.description import Description, Link

INPUTS = "the board"
"""For a sentence: what brings the inputs of the board."""
PERIOD_MS = 20


class FrameSource(NamedTuple):
    """What comes in one frame, and how often; a link and the inputs of a board are two."""

    channels: frozenset[str]
    period_us: int


def sources_of(carrier: Carrier) -> tuple[FrameSource, ...]:
    """Those that a carrier has as ``sources``; a codec is one."""
    found: tuple[FrameSource, ...] = getattr(carrier, "sources", ())
    return found or (FrameSource(frozenset(carrier.channels), carrier.period_us),)


def period_of(carrier: Carrier, channel: str) -> int:
    """µs between two readings of a channel, nominally."""
    found = (source.period_us for source in sources_of(carrier) if channel in source.channels)
    return next(found, carrier.period_us)


@dataclass(frozen=True)
class BoardInputs:
    """What the digital and analog inputs of a board carry."""

    channels: Mapping[str, Kind]
    period_us: int
    resolution_pa: float
    name: str = INPUTS


@dataclass(frozen=True)
class SeveralSources:
    """A link and the inputs of the board together."""

    name: str
    channels: Mapping[str, Kind]
    period_us: int
    resolution_pa: float
    seq_bits: int
    clock_bits: int
    sources: tuple[FrameSource, ...]


def codec_of(description: Description) -> Codec:
    """The codec of a description's link: the one that it names, or the one that it declares with `frame`.

    Raises:
        UsageError: there is no link, or no such codec; with its place there.
    """
    link = description.link
    if link is None:
        raise UsageError(
            f"{description.name} has no sensor link: its channels are inputs of the board.",
            where=description.where(),
            todo="`eehal doctor --only inputs` shows their lines and their levels.",
        )
    if link.frame is not None:
        from .described import described_codec

        return described_codec(description)
    try:
        return get_codec(link.codec)
    except UsageError as error:
        raise type(error)(error.what, where=description.where("link", "codec"), todo=error.todo) from error


def line_of(link: Link | None, codec: Codec) -> tuple[int, str]:
    """Baud rate and parity of a link: those that it gives, or those of its codec."""
    own = codec.baudrate, parity_of(codec)
    return (link.baudrate or own[0], link.parity or own[1]) if link else own


def board_inputs(description: Description) -> BoardInputs | None:
    """What comes from the inputs of the board; None: nothing does."""
    found = {name: each for name, each in description.channels.items() if each.on_board}
    if not found:
        return None
    period_ms = description.inputs.period_ms if description.inputs else PERIOD_MS
    steps = [channel.step_pa for channel in found.values() if channel.kind is Kind.PRESSURE]
    return BoardInputs(
        {name: each.kind for name, each in found.items()}, 1000 * period_ms, max(steps, default=1.0)
    )


def carrier_of(description: Description) -> Carrier:
    """What brings the channels of a description; raises UsageError with its place there."""
    inputs = board_inputs(description)
    if description.link is None and inputs is not None:
        return inputs
    codec = codec_of(description)
    if inputs is None:
        return codec
    channels = dict(codec.channels) | dict(inputs.channels)
    sources = (
        FrameSource(frozenset(codec.channels) - inputs.channels.keys(), codec.period_us),
        FrameSource(frozenset(inputs.channels), inputs.period_us),
    )
    return SeveralSources(
        f"{codec.name} with {INPUTS}",
        channels,
        max(source.period_us for source in sources),
        max(resolution_of(codec), inputs.resolution_pa),
        getattr(codec, "seq_bits", 16),
        getattr(codec, "clock_bits", 32),
        sources,
    )
