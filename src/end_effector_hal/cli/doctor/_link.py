"""The sensor link: its port, who reads it, and whether frames arrive. A port that is read is left alone."""

from __future__ import annotations

import os
import select
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from end_effector_hal.description import Description, Link, used_channels
from end_effector_hal.errors import LinkError, ReportedError
from end_effector_hal.wires import Holder, holders_of

from ._check_result import CheckedPart, CheckResult, CheckResults

if TYPE_CHECKING:
    from end_effector_hal.wires.link import GuardedDecoder

LISTEN_US, ENOUGH = 2_000_000, 50
OURS = ("eehal", "end_effector_hal", "pressure")
_say = CheckedPart("link")


def look_at_link(description: Description, *, listen: bool = True) -> CheckResults:
    """Args: ``listen``: open the port for up to 2 s if nobody has it."""
    link = description.link
    if link is None:
        yield _say.ok("none: the channels are inputs of the board")
        return
    port = Path(link.port)
    if not port.exists():
        yield _no_port(link.port)
        return
    if not os.access(port, os.R_OK | os.W_OK):
        yield _say.missing(
            f"{link.port} may not be opened: permission denied",
            "Add the user to the group dialout (gid 20) and log in again; container: --group-add 20.",
        )
        return
    if holders := holders_of(port):
        yield _held(link.port, holders)
    elif not listen:
        yield _say.ok(f"{link.port} is there and nobody reads it; not listened to")
    else:
        yield _listen(description, link)


def _no_port(port: str) -> CheckResult:
    if os.path.islink(port):
        return _say.missing(
            f"{port} leads to {os.readlink(port)}, which is not there", "Is the device plugged in?"
        )
    return _say.missing(
        f"{port} does not exist",
        "Is the device plugged in, the testbench up? A container needs --device for it.",
    )


def _held(port: str, holders: list[Holder]) -> CheckResult:
    who = " and ".join(map(str, holders))
    text = f"{port} is read by {who}; not listened to, its bytes are theirs"
    if len(holders) > 1:
        return _say.warning(text, "Two readers steal each other's bytes: stop one.")
    if any(word in holders[0].program.lower() for word in OURS):
        return _say.ok(text)
    return _say.warning(text, "Stop it, if it is not a program of this tool.")


class Heard(NamedTuple):
    """What came over a link while it was listened to.

    Attributes:
        data: all bytes.
        frames: number of frames.
        errors: by kind, since the first frame: a listener comes in the middle of one.
        lost, reboots: as the decoder counts.
        invalid: channels without a value in the last frame.
        seconds: from the first to the last frame.
    """

    data: bytes
    frames: int = 0
    errors: Mapping[str, int] = MappingProxyType({})
    lost: int = 0
    reboots: int = 0
    invalid: tuple[str, ...] = ()
    seconds: float = 0.0


def _listen(description: Description, link: Link) -> CheckResult:
    from end_effector_hal.codecs import codec_of, line_of
    from end_effector_hal.wires.link import CodecCalls, GuardedDecoder, open_port

    try:
        codec = codec_of(description)
        baudrate, parity = line_of(link, codec)
        with open_port(link.port, baudrate, parity=parity) as port:
            calls = CodecCalls(link.port)
            heard = _hear(port.fileno(), GuardedDecoder(codec, calls), max(LISTEN_US, 3 * codec.period_us))
    except LinkError as error:
        if " is used by " in error.what:
            return _say.warning(f"{link.port}: {error.what}", error.todo)
        return _say.missing(f"{link.port}: {error.what}", error.todo)
    except ReportedError as error:
        return _say.missing(f"{link.port}: {error.what}", error.todo)
    except OSError as error:
        return _say.missing(f"{link.port} was lost: {error.strerror or error}", "Is the device plugged in?")
    # what else a device sends, or has no sensor for, does not matter to this tool
    heard = heard._replace(
        invalid=tuple(each for each in heard.invalid if each in used_channels(description))
    )
    return judged(f"{link.port}, {codec.name}, {baudrate} baud", heard, "" if link.frame else codec.name)


def _hear(fd: int, decoder: GuardedDecoder, listen_us: int) -> Heard:
    """For ``listen_us``, or until there are enough frames; raises OSError, LinkError when the port or codec fails."""
    from end_effector_hal.wires import now_us

    end = now_us() + listen_us
    heard, before, first_us = Heard(b""), {}, 0
    while heard.frames < ENOUGH and (left := end - now_us()) > 0:
        wait_s = left / 1e6
        if decoder.asks:
            os.write(fd, decoder.poll().data)
            wait_s = min(wait_s, decoder.wait_s() or 0)
        if not select.select([fd], [], [], wait_s)[0]:
            continue
        data = os.read(fd, 4096)
        if not data:
            raise OSError("end of file")
        at = now_us()
        frames = decoder.feed(data)
        heard = heard._replace(data=heard.data + data)
        if not frames:
            continue
        if not heard.frames:
            before, first_us = dict(decoder.counters.errors), at
        invalid = tuple(name for name, value in frames[-1].values.items() if value is None)
        heard = heard._replace(frames=decoder.counters.frames, invalid=invalid, seconds=(at - first_us) / 1e6)
    counters = decoder.counters
    errors = {kind: count - before.get(kind, 0) for kind, count in counters.errors.items()}
    return heard._replace(
        errors={kind: count for kind, count in errors.items() if count},
        lost=counters.lost,
        reboots=counters.reboots,
    )


def judged(port: str, heard: Heard, codec: str) -> CheckResult:
    """Args: ``port``: how it is called; ``codec``: the one that was expected, empty where the frame is declared."""
    if not heard.data:
        return _say.missing(
            f"{port}: silent", "Is the device powered, RX and TX not exchanged, the ground connected?"
        )
    if not heard.frames:
        others = ", ".join(_fitting(heard.data, but=codec))
        return _say.missing(
            f"{port}: {len(heard.data)} bytes and no frame"
            + (f"; they look like {others}" if others else ""),
            f"Set link.codec: {others}."
            if others
            else f"Baud rate, parity, {'codec' if codec else 'link.frame'} and voltage levels: do they fit?",
        )
    text = f"{port}: {heard.frames} frames"
    if heard.seconds:
        text += f", {(heard.frames - 1) / heard.seconds:.0f} per second"
    counted = {"lost": heard.lost, "reboots": heard.reboots, **heard.errors}
    faults = [f"{count} {kind}" for kind, count in counted.items() if count]
    if heard.invalid:
        faults.append(f"no value of {', '.join(heard.invalid)}")
    if not faults:
        return _say.ok(text)
    return _say.warning(f"{text}; {', '.join(faults)}", "See to the cable, its ground and the sensors.")


def _fitting(data: bytes, but: str) -> Iterator[str]:
    """Codecs that find frames and little else in it."""
    from end_effector_hal.codecs import codec_names, get_codec
    from end_effector_hal.wires.link import CodecCalls, GuardedDecoder

    for name in codec_names():
        if name == but:
            continue
        try:
            decoder = GuardedDecoder(get_codec(name), CodecCalls(name))
            frames, counters = decoder.feed(data), decoder.counters
        except ReportedError:  # somebody else's, and broken
            continue
        if frames and counters.frames > sum(
            count for kind, count in counters.errors.items() if kind != "noise"
        ):
            yield name
