"""What brings the channels of a tool: the codecs of its links, the inputs of its board, or both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from end_effector_hal.codecs._codec import Carrier, Codec, parity_of, resolution_of, sequence_bits
from end_effector_hal.codecs._registry import get_codec
from end_effector_hal.codecs._renamed import renamed
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Kind

if TYPE_CHECKING:
    from end_effector_hal.description import Description, Link

SEVERAL = "the wiring"
"""For a sentence: what brings the channels of several links, or of links and inputs of the board."""
INPUTS = "the board"
"""For a sentence: what brings the inputs of the board."""
PERIOD_MS = 20


class FrameSource(NamedTuple):
    """What comes in one frame, and how often; a link and the inputs of a board are two.

    ``link``: its name under `links`; None: the inputs of the board, or the only one.
    """

    channels: frozenset[str]
    period_us: int
    link: str | None = None
    sequence: tuple[int, int] = (16, 32)
    """Bits of its sequence number, and of its clock."""


def sources_of(carrier: Carrier) -> tuple[FrameSource, ...]:
    """Those that a carrier has as ``sources``; a codec is one."""
    found: tuple[FrameSource, ...] = getattr(carrier, "sources", ())
    return found or (
        FrameSource(frozenset(carrier.channels), carrier.period_us, None, sequence_bits(carrier)),
    )


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
    """Links and the inputs of the board together."""

    name: str
    channels: Mapping[str, Kind]
    period_us: int
    resolution_pa: float
    seq_bits: int
    clock_bits: int
    sources: tuple[FrameSource, ...]


def codec_of(description: Description, name: str | None = None) -> Codec:
    """The codec of a link: the one that it names, or the one that it declares with `frame`.

    Its channels have the names that the description gives them. A codec that is named brings those that have none
    there under its own, unless there are several links.

    Args:
        description: the tool.
        name: of the link; None: the first one.

    Raises:
        UsageError: there is no link, no such codec, or it has no such channel; with its place there.
    """
    links = description.links
    if not links:
        raise UsageError(
            f"{description.name} has no sensor link: its channels are inputs of the board.",
            where=description.where(),
            todo="`eehal doctor --only inputs` shows their lines and their levels.",
        )
    name = next(iter(links)) if name is None else name
    link = links[name]
    if link.frame is not None:
        from .described import described_codec

        return described_codec(link, description.channels_over(name))
    try:
        codec = get_codec(link.codec)
    except UsageError as error:
        where = description.where(*description.link_path(name), "codec")
        raise type(error)(error.what, where=where, todo=error.todo) from error
    names = {each.codec.channel: mine for mine, each in description.channels_over(name).items() if each.codec}
    if not names and len(links) == 1:
        return codec
    if unknown := names.keys() - codec.channels.keys():
        mine = names[min(unknown)]
        raise UsageError(
            f"{codec.name} carries no {min(unknown)!r}.",
            where=description.where("channels", mine, "codec", "channel"),
            todo=f"It carries {', '.join(codec.channels)}.",
        )
    if len(links) == 1:
        names = {its: names.get(its, its) for its in codec.channels}
    return renamed(codec, names)


def line_of(link: Link, codec: Codec) -> tuple[int, str, int]:
    """Baud rate, parity and stop bits of a link: those that it gives, or those of its codec."""
    return link.baudrate or codec.baudrate, link.parity or parity_of(codec), link.stopbits or 1


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
    if not description.links and inputs is not None:
        return inputs
    if not description.named_links and inputs is None:
        return codec_of(description)
    codecs = {name: codec_of(description, name) for name in description.links or ("",)}
    brought: list[Codec | BoardInputs] = [*codecs.values(), *([inputs] if inputs else [])]
    own = frozenset(inputs.channels) if inputs else frozenset()
    sources = [
        FrameSource(frozenset(codec.channels) - own, codec.period_us, name or None, sequence_bits(codec))
        for name, codec in codecs.items()
    ]
    if inputs:
        sources.append(FrameSource(own, inputs.period_us))
    first = next(iter(codecs.values()))
    return SeveralSources(
        SEVERAL,
        {name: kind for each in brought for name, kind in each.channels.items()},
        max(source.period_us for source in sources),
        max(map(resolution_of, brought)),
        *sequence_bits(first),
        tuple(sources),
    )
