"""From a file to a tool: a description, held against the codec that it names."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.codecs._carrier import carrier_of, codec_of
from end_effector_hal.codecs._codec import shows_noise
from end_effector_hal.codecs._registry import codec_names
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


def match_codec(description: Description) -> CodecMatch:
    """Hold a description against its codec."""
    link, known = description.link, codec_names()
    wanted = link.codec if link and link.frame is None else ""
    try:
        codec = carrier_of(description)
    except MissingExtraError as error:
        place = description.place("link", "codec" if wanted else "frame")
        return CodecMatch(
            (Fault.at(place, "EE-226", error.what.rstrip("."), found="", hint=error.todo.rstrip(".")),)
        )
    except ReportedError as error:
        if not wanted:
            place, hint = description.place("link", "frame"), error.todo.rstrip(".")
            return CodecMatch((Fault.at(place, "EE-226", error.what.rstrip("."), found="", hint=hint),))
        what = error.what.rstrip(".") if wanted in known else "there is no such codec"
        place, hint = description.place("link", "codec"), did_you_mean(wanted, known)
        return CodecMatch(
            (Fault.at(place, "EE-226", what, expected=f"one of {', '.join(known)}", hint=hint),)
        )
    declared = link is None or link.frame is not None
    channels = CodecChannels(
        codec.name, codec.channels, codec.period_us, shows_noise(codec), declared=declared
    )
    return CodecMatch(
        tuple(sorted([*unproven(description, channels), *_hidden(description), *_too_short(description)])),
        tuple(not_fitted(description, channels)),
        (*slow(description, channels), *lost_by_silence(description, channels)),
    )


def _hidden(description: Description) -> Iterator[Fault]:
    """Channels of the link's codec that would not be seen behind a declared one of the same name."""
    if description.link is None or description.link.frame is not None:
        return
    codec = codec_of(description)
    for name in description.channels.keys() & codec.channels.keys():
        place = description.key_place("channels", name)
        what = f"{codec.name} carries a channel of this name, too"
        yield Fault.at(place, "EE-221", what, found=name, expected="another name")


def _too_short(description: Description) -> Iterator[Fault]:
    """A period in which what is declared does not fit on the wire: every reading would be stale."""
    link = description.link
    if link is None or link.frame is None or link.period_ms is None:
        return
    codec = described_codec(description)
    if codec.period_us < codec.least_period_us:
        least_ms = -(-codec.least_period_us // 1000)
        what = f"one frame takes {least_ms} ms at {codec.baudrate} baud"
        yield Fault.at(
            description.place("link", "period_ms"), "EE-228", what, expected=f"at least {least_ms}"
        )
