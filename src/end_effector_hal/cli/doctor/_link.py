"""Checks the sensor link: its port, the process that reads it, and whether frames arrive. A port that is being read is
not opened.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from end_effector_hal.cli.listen import OpenLink, open_link, why_no_frame
from end_effector_hal.description import Description, Link, network_address, used_channels
from end_effector_hal.errors import LinkBusyError, ReportedError
from end_effector_hal.wires import Holder
from end_effector_hal.wires.link import users_of

from ._check_result import CheckedPart, CheckResult, CheckResults

LISTEN_US, ENOUGH = 2_000_000, 50
OURS = ("eehal", "end_effector_hal", "pressure")
_say = CheckedPart("link")


def look_at_link(description: Description, *, listen: bool = True) -> CheckResults:
    """Check every sensor link.

    Args:
        listen: whether to open every port that no process reads, for up to 2 s.
    """
    if not description.links:
        yield _say.ok("none: the channels are inputs of the board")
    for name in description.links:
        yield from _look_at(description, name, listen=listen)


def _look_at(description: Description, name: str, *, listen: bool) -> CheckResults:
    link = description.links[name]
    port, address = Path(link.port), network_address(link.port)
    if not address and not port.exists():
        yield _no_port(link.port)
        return
    if not address and not os.access(port, os.R_OK | os.W_OK):
        yield _say.missing(
            f"{link.port} may not be opened: permission denied",
            "Add the user to the group dialout (gid 20) and log in again; container: --group-add 20.",
        )
        return
    if holders := users_of(link.port):
        yield _held(link.port, holders)
    elif not listen:
        free = "is used by no program of this machine" if address else "exists and is free"
        yield _say.ok(f"{link.port} {free}; not listened to")
    else:
        yield _listen(description, name, link)


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
    """The data that arrived over a link during the examination.

    Attributes:
        data: all bytes.
        frames: number of frames.
        errors: number of errors by kind, counted from the first frame, because reading starts in the middle of one.
        lost, reboots: counters of the decoder.
        invalid: channels without a value in the last frame.
        faults: sentences about wrong answers of single devices.
        seconds: time from the first to the last frame.
    """

    data: bytes
    frames: int = 0
    errors: Mapping[str, int] = MappingProxyType({})
    lost: int = 0
    reboots: int = 0
    invalid: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    seconds: float = 0.0


def _listen(description: Description, name: str, wire: Link) -> CheckResult:
    port = wire.port
    try:
        with open_link(description, name) as link:
            heard, title, codec = (
                _hear(link, max(LISTEN_US, 3 * link.codec.period_us)),
                link.name,
                "" if wire.frame else link.codec.name,
            )
    except LinkBusyError as error:
        return _say.warning(f"{port}: {error.what}", error.todo)
    except ReportedError as error:
        return _say.missing(f"{port}: {error.what}", error.todo)
    except OSError as error:
        return _say.missing(f"{port} was lost: {error.strerror or error}", "Is the device plugged in?")
    # what else a device sends, or has no sensor for, does not matter to this tool
    heard = heard._replace(
        invalid=tuple(each for each in heard.invalid if each in used_channels(description))
    )
    return judged(title, heard, codec, network=network_address(port) is not None)


def _hear(link: OpenLink, listen_us: int) -> Heard:
    """Receive for ``listen_us``, twice as long if data arrives, or until there are enough frames.

    Raises OSError or LinkError when the port or codec fails.
    """
    from end_effector_hal.wires import now_us

    end = now_us() + listen_us
    heard, before, first_us, decoder = Heard(b""), {}, 0, link.decoder
    while heard.frames < ENOUGH and (left := end - now_us()) > 0:
        data, frames = link.hear(left / 1e6)
        at = now_us()
        end += 0 if heard.data or not data else listen_us
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
        faults=decoder.faults,
        lost=counters.lost,
        reboots=counters.reboots,
    )


def judged(port: str, heard: Heard, codec: str, *, network: bool = False) -> CheckResult:
    """Return the finding about a link from the data that arrived.

    Args:
        port: name of the port.
        heard: the data that arrived.
        codec: name of the expected codec; "" if the frame is declared in the description.
        network: whether the port is an address in a network.
    """
    if heard.faults and not heard.frames:
        return _say.missing(f"{port}: no frame", " ".join(heard.faults))
    if not heard.data or not heard.frames:
        what, todo = why_no_frame(heard.data, codec, network=network)
        return _say.missing(f"{port}: {what}", todo)
    text = f"{port}: {heard.frames} frames"
    if heard.seconds:
        text += f", {(heard.frames - 1) / heard.seconds:.0f} per second"
    counted = {"lost": heard.lost, "reboots": heard.reboots, **heard.errors}
    faults = [f"{count} {kind}" for kind, count in counted.items() if count]
    if heard.invalid:
        faults.append(f"no value of {', '.join(heard.invalid)}")
    if not faults and not heard.faults:
        return _say.ok(text)
    todo = " ".join(heard.faults) or "See to the cable, its ground and the sensors."
    return _say.warning("; ".join(filter(None, (text, ", ".join(faults)))), todo)
