"""Rules for links and the frames that they declare: settings that are possible but make no sense."""

from __future__ import annotations

import re
from collections.abc import Iterator
from posixpath import normpath

from end_effector_hal.description._address import (
    MODBUS_SCHEMES,
    STREAMS,
    looks_like_address,
    network_address,
    refused_fieldbus,
    right_form,
)
from end_effector_hal.description._fault import Fault, Keys
from end_effector_hal.description._shape import Facts
from end_effector_hal.description.model._channels import Channel, LinkFrame

CODE = "EE-228"
MOST_LINKS = 16
FORMATS, OVER_LINK = LinkFrame.FORMATS, Channel.OVER_LINK
ENDS = set("\r\n")
"""Characters that end a line."""
_NUMERIC = set("0123456789+-.eE")


def frame_faults(facts: Facts) -> Iterator[Fault]:
    """Yield every fault of the links, and of the frames that they declare."""
    yield from _links(facts)
    for link in link_paths(facts):
        yield from _link(facts, link)
        yield from _text_frame(facts, (*link, "frame", "text"))
        yield from _asked(facts, link)
        yield from _record_frame(facts, (*link, "frame", "record"))


def link_paths(facts: Facts) -> list[Keys]:
    """Return the keys of each link: ``link``, or those under ``links``."""
    if facts.says("link"):
        return [("link",)]
    names = facts.names("links") if isinstance(facts.get("links"), dict) else []
    return [("links", name) for name in names]


def link_of(facts: Facts, channel: str) -> Keys | None:
    """Return the keys of the link that carries a channel; None: it is not known."""
    links, named = link_paths(facts), facts.get("channels", channel, "link")
    if named is not None:
        return ("links", named) if ("links", named) in links else None
    return links[0] if len(links) == 1 else None


def _links(facts: Facts) -> Iterator[Fault]:
    """Check the rules between several links."""
    if not facts.written("links"):
        return
    if facts.says("link"):
        expected = "link alone, or every link under links with a name of its own"
        yield facts.key_fault(("links",), CODE, "'link' and 'links' exclude each other", expected)
        return
    if ("links",) in facts.broken:
        return
    names, place = facts.names("links"), facts.places.key("links")
    if not names:
        expected = "links: {a_name: {port: …}}"
        yield Fault.at(place, "EE-206", "'links' names no link", found="", expected=expected)
    elif len(names) > MOST_LINKS:
        what, expected = "too many links", f"at most {MOST_LINKS}"
        yield Fault.at(place, "EE-208", what, found=str(len(names)), expected=expected)
    ports: dict[str, str] = {}
    for name in names:
        port = facts.get("links", name, "port")
        if port is None:
            continue
        owner = ports.setdefault(place_of(port), name)
        if owner != name:
            what, hint = f"this port already belongs to link {owner!r}", "devices on one bus differ by 'unit'"
            yield facts.fault(("links", name, "port"), "EE-221", what, "a port of its own", hint=hint)


def declared_format(facts: Facts, link: Keys) -> str:
    """Return the format that the frame of a link declares; empty if it declares none or several."""
    formats = [each for each in FORMATS if facts.says(*link, "frame", each)]
    return formats[0] if len(formats) == 1 else ""


def _link(facts: Facts, link: Keys) -> Iterator[Fault]:
    frame = (*link, "frame")
    yield from port_faults(facts, link)
    if not facts.says(*frame):
        if facts.says(*link, "period_ms"):
            what, hint = "'period_ms' is for a declared frame", "a codec has a period of its own"
            yield facts.key_fault((*link, "period_ms"), CODE, what, "frame", hint=hint)
        if len(link_paths(facts)) > 1 and not facts.broken_within(*link):
            yield from _unused(facts, link, link, "codec: {channel: …}")
        return
    if facts.written(*link, "codec"):
        expected = "frame with channels, or the name of a codec"
        yield facts.key_fault((*link, "codec"), CODE, "'codec' and 'frame' exclude each other", expected)
    formats = [each for each in FORMATS if facts.says(*frame, each)]
    if len(formats) > 1:
        expected = f"one of {', '.join(FORMATS)}"
        yield facts.key_fault((*frame, formats[1]), CODE, "a link has frames of one format", expected)
    elif not formats and not facts.broken_within(*frame):
        expected = f"one of {', '.join(FORMATS)}"
        yield facts.key_fault(frame, "EE-206", "'frame' declares no format", expected, found="")
    elif formats:
        yield from _unused(facts, link, frame, f"{formats[0]}: …")


def _unused(facts: Facts, link: Keys, path: Keys, source: str) -> Iterator[Fault]:
    """Yield a fault for a link that carries no channel of the description."""
    if facts.broken_within("channels"):
        return
    over = (
        name for name in facts.names("channels") if any(facts.says("channels", name, s) for s in OVER_LINK)
    )
    several = len(link_paths(facts)) > 1
    if any(link_of(facts, name) in (link, None) if several else True for name in over):
        return
    named = f"link: {link[1]}, " if several else ""
    what = "no channel comes over the link"
    yield facts.key_fault(path, "EE-206", what, f"channels: {{a_name: {{{named}{source}}}}}", found="")


def _text_frame(facts: Facts, path: Keys) -> Iterator[Fault]:
    if not isinstance(facts.get(*path), dict):
        return
    signs = {key: facts.get(*path, key) or "" for key in ("separator", "equals", "checksum_mark")}
    for key, sign in signs.items():
        if set(sign) & (_NUMERIC | ENDS):
            why = "ends a line" if set(sign) & ENDS else "stands in numbers"
            yield facts.fault((*path, key), CODE, f"{key!r} {why}", "another character")
    if signs["separator"] and signs["separator"] == signs["equals"]:
        what = "'separator' and 'equals' are the same"
        key = "equals" if facts.says(*path, "equals") else "separator"
        yield facts.fault((*path, key), CODE, what, "two characters")
    if start := facts.get(*path, "start") or "":
        if set(start) & ENDS:
            yield facts.fault((*path, "start"), CODE, "'start' ends a line", "a text that begins one")
        elif not set(start) - _NUMERIC - set("".join(signs.values())):
            what = "'start' may stand within a line"
            yield facts.fault((*path, "start"), CODE, what, "a character that no value has, such as $")


def _asked(facts: Facts, link: Keys) -> Iterator[Fault]:
    """Check the request of a link: a backslash in it is an escape that YAML did not read."""
    for path in ((*link, "frame", each, "ask") for each in ("text", "json")):
        ask = facts.get(*path) if facts.says(*path) else None
        if isinstance(ask, str) and re.search(r"\\[rntx]", ask):
            expected = f'double quotes: ask: "{ask}"'
            yield facts.fault(path, CODE, "this would be sent with a backslash", expected)


def _record_frame(facts: Facts, path: Keys) -> Iterator[Fault]:
    if not isinstance(facts.get(*path), dict):
        return
    framing, start = facts.get(*path, "framing"), facts.says(*path, "start")
    if framing == "start" and not start:
        expected = "start: the bytes that begin a record, such as AA55; or framing: cobs or slip"
        yield facts.key_fault(path, "EE-206", "key 'start' is missing in 'record'", expected, found="")
    elif framing in ("cobs", "slip") and start:
        what = f"framing: {framing} has no start bytes"
        yield facts.key_fault((*path, "start"), CODE, what, "a delimiter only, or framing: start")


def port_faults(facts: Facts, link: Keys) -> Iterator[Fault]:
    """Yield the faults of a link's port, and of keys that such a port does not have."""
    port = facts.get(*link, "port")
    if port is None:
        return
    place, modbus = facts.places.value(*link, "port"), facts.says(*link, "frame", "modbus")
    if hint := refused_fieldbus(port):
        yield Fault.at(place, "EE-211", "'port' is no address that this link can use", expected="", hint=hint)
        return
    if not looks_like_address(port):
        return
    # a codec may be either; whether it fits is checked when it is known
    schemes = (
        MODBUS_SCHEMES if modbus else STREAMS if facts.says(*link, "frame") else (*MODBUS_SCHEMES, *STREAMS)
    )
    address = network_address(port)
    if address is None or address.scheme not in schemes:
        what = "'port' is no address that this link can use"
        guess = modbus or (address is None and schemes != STREAMS)
        yield Fault.at(place, "EE-211", what, expected=right_form(port, modbus=guess))
        return
    if not address.has_line:
        for key in ("baudrate", "parity", "stopbits"):
            if facts.says(*link, key):
                what, hint = f"{key!r} is for a serial line", "the far end has its own settings"
                yield facts.key_fault((*link, key), "EE-228", what, "no such key", hint=hint)


def place_of(port: str) -> str:
    """Return the place that only one link may use: the path of a device, or host and port of an address."""
    address = network_address(port)
    return address.place if address else normpath(port)


def unit_faults(facts: Facts, link: Keys | None, path: Keys) -> Iterator[Fault]:
    """Yield a fault if the unit of a register is the broadcast of its line: no device answers that."""
    if facts.get(*path, "unit") != 0 or link is None or (port := facts.get(*link, "port")) is None:
        return
    address = network_address(port)
    if address is None or address.scheme != "tcp":
        what = "unit 0 is the broadcast of a serial line"
        yield facts.fault((*path, "unit"), "EE-208", what, "1 to 255; 0 is possible with tcp://")
