"""Loads a tool from a file: reads its description and checks it against its codecs."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.codecs._carrier import carrier_of, codec_of, sources_of
from end_effector_hal.codecs._codec import shows_noise
from end_effector_hal.codecs._registry import codec_names, get_codec
from end_effector_hal.codecs.described._described import described_codec
from end_effector_hal.description import (
    MODBUS_SCHEMES,
    CodecChannels,
    Description,
    Fault,
    did_you_mean,
    examine,
    lost_by_silence,
    network_address,
    not_fitted,
    refused_fieldbus,
    right_form,
    slow,
    unproven,
)
from end_effector_hal.errors import DescriptionError, MissingExtraError, ReportedError

SEEN_WITHIN_S = 0.5
"""Longest validity of a reading without a warning, s; a longer period delays the detection of a loss."""


@dataclass(frozen=True)
class CodecMatch:
    """The result of checking a description against its codecs.

    Attributes:
        faults: requirements that can never be met.
        not_fitted: functions that are off because the codec lacks their channel.
        slow: times that a slow link cannot keep, and parts that may be dropped when a bus is silent.
    """

    faults: tuple[Fault, ...]
    not_fitted: tuple[str, ...] = ()
    slow: tuple[str, ...] = ()


def load_tool(path: str | Path) -> Description:
    """Read a description and check it against its codec; every program that uses a description calls this.

    Raises:
        DescriptionError: the description is not valid, or its codec cannot prove its conditions.
    """
    examination = examine(path)
    if examination.description is None:
        raise DescriptionError(examination.diagnostics)
    if faults := match_codec(examination.description).faults:
        raise DescriptionError([fault.diagnostic(examination.name) for fault in faults])
    return examination.description


def match_codec(description: Description, faulty: Collection[str] = ()) -> CodecMatch:
    """Check a description against its codecs.

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
        tuple(
            sorted(
                {
                    *(fault for each in description.per_part for fault in unproven(each, channels)),
                    *_hidden(description),
                    *_too_short(description),
                }
            )
        ),
        tuple(not_fitted(description, channels)),
        (*slow(description, channels), *lost_by_silence(description, channels), *_slowly_seen(description)),
    )


def _slowly_seen(description: Description) -> Iterator[str]:
    """Yield a sentence for each link whose declared period delays the detection of a loss."""
    for name, link in description.links.items():
        stale_s = max(link.stale_s, link.stale_periods * (link.period_ms or 0) / 1000)
        if link.frame and link.period_ms and stale_s > SEEN_WITHIN_S:
            down_s = max(link.down_s, link.down_periods * link.period_ms / 1000)
            place = description.where(*description.link_path(name), "period_ms")
            yield (
                f"{place}: period_ms: {link.period_ms}: a device that falls silent, or a grip that is lost, "
                f"may be detected only after {stale_s:g} s, and the link is down after {down_s:g} s"
            )


def _unusable(description: Description, name: str) -> Fault | None:
    """Return why the codec of a link cannot be used; None: it can be used."""
    link, path = description.links[name], description.link_path(name)
    wanted = link.codec if link.frame is None else ""
    try:
        if wanted:
            asks_modbus = hasattr(get_codec(wanted), "reads")
            return _wrong_address(description, name, modbus=asks_modbus) or _not_carried(description, name)
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
        hint = refused_fieldbus(wanted) or did_you_mean(wanted, known)
        return Fault.at(place, "EE-226", what, expected=expected, hint=hint)
    return None


def _wrong_address(description: Description, name: str, *, modbus: bool) -> Fault | None:
    """Return a fault if the codec of a link does not fit its address in a network."""
    port = description.links[name].port
    address = network_address(port)
    if address is None or (address.scheme in MODBUS_SCHEMES) is modbus:
        return None
    place = description.place(*description.link_path(name), "port")
    expected = right_form(port, modbus=modbus)
    return Fault.at(place, "EE-211", "'port' is no address that this codec can use", expected=expected)


def _not_carried(description: Description, name: str) -> Fault | None:
    """Return the fault of a channel that the named codec of a link does not have; None: there is none."""
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
    """Yield faults for channels of the only link's codec that a declared channel of the same name would hide."""
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
    """Yield faults for declared periods in which a frame cannot be transmitted: every reading would be stale."""
    for name, link in description.links.items():
        if link.frame is None or link.period_ms is None:
            continue
        codec = described_codec(link, description.channels_over(name))
        if codec.period_us < codec.least_period_us:
            least_ms = -(-codec.least_period_us // 1000)
            what = f"one frame takes {least_ms} ms at {codec.baudrate} baud"
            place = description.place(*description.link_path(name), "period_ms")
            yield Fault.at(place, "EE-228", what, expected=f"at least {least_ms}")
