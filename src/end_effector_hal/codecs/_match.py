"""From a file to a tool: a description, held against the codec that it names."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.codecs._carrier import carrier_of
from end_effector_hal.codecs._codec import shows_noise
from end_effector_hal.codecs._registry import codec_names
from end_effector_hal.description import (
    CodecChannels,
    Description,
    Fault,
    did_you_mean,
    examine,
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
        slow: times that so slow a link cannot keep.
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
    wanted, known = description.link.codec if description.link else "", codec_names()
    try:
        codec = carrier_of(description)
    except MissingExtraError as error:
        place = description.place("link", "codec")
        return CodecMatch(
            (Fault.at(place, "EE-226", error.what.rstrip("."), found="", hint=error.todo.rstrip(".")),)
        )
    except ReportedError as error:
        what = error.what.rstrip(".") if wanted in known else "there is no such codec"
        place, hint = description.place("link", "codec"), did_you_mean(wanted, known)
        return CodecMatch(
            (Fault.at(place, "EE-226", what, expected=f"one of {', '.join(known)}", hint=hint),)
        )
    channels = CodecChannels(codec.name, codec.channels, codec.period_us, shows_noise(codec))
    return CodecMatch(
        tuple(unproven(description, channels)),
        tuple(not_fitted(description, channels)),
        tuple(slow(description, channels)),
    )
