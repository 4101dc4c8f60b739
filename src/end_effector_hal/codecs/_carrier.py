"""The sources of a tool's channels: the codecs of its links, the inputs of its board, or both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from end_effector_hal.codecs._codec import Carrier, Codec, parity_of, resolution_of
from end_effector_hal.codecs._registry import get_codec
from end_effector_hal.codecs._renamed import renamed
from end_effector_hal.description import has_line
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Kind

if TYPE_CHECKING:
    from end_effector_hal.description import Description, Link

SEVERAL = "the wiring"
"""Name, for messages, of several links, or of links and inputs of the board together."""
INPUTS = "the board"
"""Name of the board's inputs, for messages."""
PERIOD_MS = 20


class FrameSource(NamedTuple):
    """One source of frames: the channels in each of its frames, and its period. A link and the inputs of a board are
    two sources.

    ``link``: its name under `links`; None: the inputs of the board, or the only link.
    """

    channels: frozenset[str]
    period_us: int
    link: str | None = None


def sources_of(carrier: Carrier) -> tuple[FrameSource, ...]:
    """Return the ``sources`` of a carrier; a codec is one source."""
    found: tuple[FrameSource, ...] = getattr(carrier, "sources", ())
    return found or (FrameSource(frozenset(carrier.channels), carrier.period_us),)


def period_of(carrier: Carrier, channel: str) -> int:
    """Return the nominal time between two readings of a channel, µs."""
    found = (source.period_us for source in sources_of(carrier) if channel in source.channels)
    return next(found, carrier.period_us)


@dataclass(frozen=True)
class BoardInputs:
    """The carrier of a board's digital and analog inputs."""

    channels: Mapping[str, Kind]
    period_us: int
    resolution_pa: float
    name: str = INPUTS


@dataclass(frozen=True)
class SeveralSources:
    """The carrier of several links, or of links and the inputs of the board."""

    name: str
    channels: Mapping[str, Kind]
    period_us: int
    resolution_pa: float
    sources: tuple[FrameSource, ...]


def codec_of(description: Description, name: str | None = None) -> Codec:
    """Return the codec of a link: the one that it names, or the one that it declares with `frame`.

    Its channels have the names that the description gives them. If there is only one link, channels of a named codec
    that the description does not rename keep their own names; if there are several links, such channels are left out.

    Args:
        description: the tool.
        name: name of the link; None: the first one.

    Raises:
        UsageError: there is no link, no such codec, or the codec lacks a channel; the error has the place in the
            description.
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
        from end_effector_hal.codecs.described._described import described_codec

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
            f"{codec.name} has no channel {min(unknown)!r}.",
            where=description.where("channels", mine, "codec", "channel"),
            todo=f"It has {', '.join(codec.channels)}.",
        )
    if len(links) == 1:
        names = {its: names.get(its, its) for its in codec.channels}
    return renamed(codec, names)


def line_of(link: Link, codec: Codec) -> tuple[int, str, int]:
    """Return baud rate, parity and stop bits of a link: its own, or those of its codec."""
    return link.baudrate or codec.baudrate, link.parity or parity_of(codec), link.stopbits or 1


def line_words(link: Link, codec: Codec) -> str:
    """Return the settings of a link's line, such as ``9600 baud 8E1``; empty: it has none."""
    if not has_line(link.port):
        return ""
    baudrate, parity, stopbits = line_of(link, codec)
    own = f" 8{parity}{stopbits}" if link.frame or link.parity or link.stopbits else ""
    return f"{baudrate} baud{own}"


def board_inputs(description: Description) -> BoardInputs | None:
    """Return the carrier of the board's inputs; None: the tool has none."""
    found = {name: each for name, each in description.channels.items() if each.on_board}
    if not found:
        return None
    period_ms = description.inputs.period_ms if description.inputs else PERIOD_MS
    steps = [channel.step_pa for channel in found.values() if channel.kind is Kind.PRESSURE]
    return BoardInputs(
        {name: each.kind for name, each in found.items()}, 1000 * period_ms, max(steps, default=1.0)
    )


def carrier_of(description: Description) -> Carrier:
    """Return the carrier of all channels of a description; raises UsageError with the place in the description."""
    inputs = board_inputs(description)
    if not description.links and inputs is not None:
        return inputs
    if not description.named_links and inputs is None:
        return codec_of(description)
    codecs = {name: codec_of(description, name) for name in description.links or ("",)}
    brought: list[Codec | BoardInputs] = [*codecs.values(), *([inputs] if inputs else [])]
    own = frozenset(inputs.channels) if inputs else frozenset()
    sources = [
        FrameSource(frozenset(codec.channels) - own, codec.period_us, name or None)
        for name, codec in codecs.items()
    ]
    if inputs:
        sources.append(FrameSource(own, inputs.period_us))
    return SeveralSources(
        SEVERAL,
        {name: kind for each in brought for name, kind in each.channels.items()},
        max(source.period_us for source in sources),
        max(map(resolution_of, brought)),
        tuple(sources),
    )
