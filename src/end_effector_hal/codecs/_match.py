"""From a file to a tool: a description, held against the codec that it names."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.codecs._carrier import carrier_of, codec_of, sources_of
from end_effector_hal.codecs._codec import shows_noise
from end_effector_hal.codecs._registry import codec_names, get_codec
from end_effector_hal.codecs.described import described_codec
from end_effector_hal.description import (
    CodecChannels,
    Description,
    Fault,
    did_you_mean,
    examine,
    lost_by_silence,
    not_fitted,
    slow,
    unproven,
)
from end_effector_hal.errors import DescriptionError, MissingExtraError, ReportedError

SEEN_WITHIN_S = 0.5
"""A period with which a reading counts for longer is warned of."""


@dataclass(frozen=True)
class CodecMatch:
    """How a description goes together with the codec that it names.

    Attributes:
        faults: what can never work.
        not_fitted: what is off because the codec does not carry it.
        slow: times that so slow a link cannot keep, and what a silent bus would let fall.
    """

    faults: tuple[Fault, ...]
    not_fitted: tuple[str, ...] = ()
    slow: tuple[str, ...] = ()


def load_tool(path: str | Path) -> Description:
    """Read a description and hold it against its codec: what every program that uses one does.

    Raises:
        DescriptionError: it is not valid, or its codec cannot prove it.
    """
    examination = examine(path)
    if examination.description is None:
        raise DescriptionError(examination.diagnostics)
    if faults := match_codec(examination.description).faults:
        raise DescriptionError([fault.diagnostic(examination.name) for fault in faults])
    return examination.description


def match_codec(description: Description, faulty: Collection[str] = ()) -> CodecMatch:
    """Hold a description against its codec.

    Args:
        description: the tool.
        faulty: channels whose declaration already has a fault.
    """
    links = description.links
    if unusable := [fault for name in links if (fault := _unusable(description, name))]:
        return CodecMatch(tuple(unusable))
    try:
        codec = carrier_of(description)
    except ReportedError as error:  # nothing brings a reading
        what, hint = error.what.rstrip("."), error.todo.rstrip(".")
        return CodecMatch((Fault.at(description.place("link"), "EE-226", what, found="", hint=hint),))
    declared = len(links) > 1 or all(link.frame is not None for link in links.values())
    fresh = ((description.freshness_of(source.link), source.period_us / 1e6) for source in sources_of(codec))
    stale_s = max(max(each.stale_s, each.stale_periods * period_s) for each, period_s in fresh)
    channels = CodecChannels(
        codec.name, codec.channels, codec.period_us, stale_s, shows_noise(codec), declared, frozenset(faulty)
    )
    return CodecMatch(
        tuple(sorted([*unproven(description, channels), *_hidden(description), *_too_short(description)])),
        tuple(not_fitted(description, channels)),
        (*slow(description, channels), *lost_by_silence(description, channels), *_slowly_seen(description)),
    )


def _slowly_seen(description: Description) -> Iterator[str]:
    """A sentence for each link whose declared period makes a loss be seen late."""
    for name, link in description.links.items():
        stale_s = max(link.stale_s, link.stale_periods * (link.period_ms or 0) / 1000)
        if link.frame and link.period_ms and stale_s > SEEN_WITHIN_S:
            down_s = max(link.down_s, link.down_periods * link.period_ms / 1000)
            place = description.where(*description.link_path(name), "period_ms")
            yield (
                f"{place}: period_ms: {link.period_ms}: a device that falls silent, or a grip that is lost, "
                f"may be seen only after {stale_s:g} s, and the link is down after {down_s:g} s"
            )


def _unusable(description: Description, name: str) -> Fault | None:
    """Why the codec of a link cannot be used; None: it can be."""
    link, path = description.links[name], description.link_path(name)
    wanted = link.codec if link.frame is None else ""
    try:
        if wanted:
            get_codec(wanted)
            return _not_carried(description, name)
        codec_of(description, name)
    except ReportedError as error:
        what, hint = error.what.rstrip("."), error.todo.rstrip(".")
        place = description.place(*path, "codec" if wanted else "frame")
        if not wanted or isinstance(error, MissingExtraError):
            return Fault.at(place, "EE-226", what, found="", hint=hint)
        known = codec_names()
        if wanted in known:
            return Fault.at(place, "EE-226", what, expected="a codec that can be loaded", hint=hint)
        what, expected = "there is no such codec", f"one of {', '.join(known)}"
        return Fault.at(place, "EE-226", what, expected=expected, hint=did_you_mean(wanted, known))
    return None


def _not_carried(description: Description, name: str) -> Fault | None:
    """A channel that the named codec of a link does not have."""
    codec = get_codec(description.links[name].codec)
    for mine, each in description.channels_over(name).items():
        if each.codec and each.codec.channel not in codec.channels:
            place, known = description.place("channels", mine, "codec", "channel"), [*codec.channels]
            what, expected = f"{codec.name} carries no such channel", f"one of {', '.join(known)}"
            return Fault.at(
                place, "EE-225", what, expected=expected, hint=did_you_mean(each.codec.channel, known)
            )
    return None


def _hidden(description: Description) -> Iterator[Fault]:
    """Channels of the only link's codec that would not be seen behind a declared one of the same name."""
    if len(description.links) != 1:
        return
    (link,) = description.links.values()
    taken = {mine: each.codec.channel for mine, each in description.channels.items() if each.codec}
    for mine in description.channels if link.frame is None else ():
        codec = get_codec(link.codec)
        if mine in codec.channels.keys() - {*taken.values()}:
            place = description.key_place("channels", mine)
            what = f"{codec.name} carries a channel of this name, too"
            yield Fault.at(place, "EE-221", what, found=mine, expected="another name")


def _too_short(description: Description) -> Iterator[Fault]:
    """A period in which what is declared does not fit on the wire: every reading would be stale."""
    for name, link in description.links.items():
        if link.frame is None or link.period_ms is None:
            continue
        codec = described_codec(link, description.channels_over(name))
        if codec.period_us < codec.least_period_us:
            least_ms = -(-codec.least_period_us // 1000)
            what = f"one frame takes {least_ms} ms at {codec.baudrate} baud"
            place = description.place(*description.link_path(name), "period_ms")
            yield Fault.at(place, "EE-228", what, expected=f"at least {least_ms}")
