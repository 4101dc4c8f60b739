"""Rules for `channels` and for the frame that a link declares: what can be written and cannot be meant."""

from __future__ import annotations

from collections.abc import Iterator
from posixpath import normpath
from typing import Any

from end_effector_hal.description._fault import Fault, Keys, did_you_mean
from end_effector_hal.description._numbers import number
from end_effector_hal.description._shape import Facts
from end_effector_hal.description.model import Channel, LinkFrame, raw_limits, type_bits
from end_effector_hal.kinds.stanza import NO_CHANNEL

CODE = "EE-228"
MOST_CHANNELS = 64
MOST_LINKS = 16
FORMATS, OVER_LINK = LinkFrame.FORMATS, Channel.OVER_LINK
OF_BITS, OF_PRESSURES = ("on", "invert"), ("scale", "offset", "range")
MEANING = ("unit", *OF_PRESSURES, "invalid", *OF_BITS)
_NUMERIC = set("0123456789+-.eE")
_ENDS = set("\r\n")


def frame_faults(facts: Facts) -> Iterator[Fault]:
    """Every fault of the links, of declared frames, and of the channels."""
    yield from _links(facts)
    for link in link_paths(facts):
        yield from _link(facts, link)
        yield from _text_frame(facts, (*link, "frame", "text"))
        yield from _record_frame(facts, (*link, "frame", "record"))
    names = facts.names("channels") if isinstance(facts.get("channels"), dict) else []
    if len(names) > MOST_CHANNELS:
        place = facts.places.key("channels")
        what, expected = "too many channels", f"at most {MOST_CHANNELS}"
        yield Fault.at(place, "EE-208", what, found=str(len(names)), expected=expected)
    for name in names:
        if isinstance(facts.get("channels", name), dict):
            yield from _channel(facts, name)
    yield from _shared(facts, names)


def _says(facts: Facts, *path: str | int) -> bool:
    """Whether a key stands there with something else than its default, which a recorded description has, too."""
    if path in facts.broken:
        return facts.written(*path)
    return facts.written(*path) and facts.get(*path) != facts.default(path)


def _numbers(facts: Facts, *path: str | int) -> Any:
    """The numbers of a list; None where it is not written, or one of them is broken."""
    return None if _broken_within(facts, *path) else facts.get(*path)


def _broken_within(facts: Facts, *path: str | int) -> bool:
    """Whether something in a stanza already has a fault, from which others may only follow."""
    return any(each[: len(path)] == path for each in facts.broken)


def _fault(facts: Facts, path: Keys, what: str, expected: str = "", hint: str = "") -> Fault:
    """One that stands at a key, whatever its value."""
    place = facts.places.key(*path)
    return Fault.at(place, CODE, what, found=str(path[-1]), expected=expected, hint=hint)


def link_paths(facts: Facts) -> list[Keys]:
    """The keys of each link: ``link``, or each of ``links``."""
    if _says(facts, "link"):
        return [("link",)]
    names = facts.names("links") if isinstance(facts.get("links"), dict) else []
    return [("links", name) for name in names]


def _link_of(facts: Facts, channel: str) -> Keys | None:
    """The link that a channel comes over; None: that is not known."""
    links, named = link_paths(facts), facts.get("channels", channel, "link")
    if named is not None:
        return ("links", named) if ("links", named) in links else None
    return links[0] if len(links) == 1 else None


def _links(facts: Facts) -> Iterator[Fault]:
    """What lies between several links."""
    if not facts.written("links"):
        return
    if _says(facts, "link"):
        expected = "link alone, or every link under links with a name of its own"
        yield _fault(facts, ("links",), "'link' and 'links' exclude each other", expected)
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
        owner = ports.setdefault(normpath(port), name)
        if owner != name:
            what, hint = f"this port already belongs to link {owner!r}", "devices on one bus differ by 'unit'"
            where = facts.places.value("links", name, "port")
            yield Fault.at(where, "EE-221", what, expected="a port of its own", hint=hint)


def _format(facts: Facts, link: Keys) -> str:
    """The one format that the frame of a link declares, else empty."""
    formats = [each for each in FORMATS if _says(facts, *link, "frame", each)]
    return formats[0] if len(formats) == 1 else ""


def _link(facts: Facts, link: Keys) -> Iterator[Fault]:
    frame = (*link, "frame")
    if not _says(facts, *frame):
        if _says(facts, *link, "period_ms"):
            hint = "a codec has a period of its own"
            yield _fault(facts, (*link, "period_ms"), "'period_ms' is for a declared frame", "frame", hint)
        if len(link_paths(facts)) > 1 and not _broken_within(facts, *link):
            yield from _unused(facts, link, link, "codec: {channel: …}")
        return
    if facts.written(*link, "codec"):
        expected = "frame with channels, or the name of a codec"
        yield _fault(facts, (*link, "codec"), "'codec' and 'frame' exclude each other", expected)
    formats = [each for each in FORMATS if _says(facts, *frame, each)]
    if len(formats) > 1:
        expected = f"one of {', '.join(FORMATS)}"
        yield _fault(facts, (*frame, formats[1]), "a link has frames of one format", expected)
    elif not formats and not _broken_within(facts, *frame):
        place = facts.places.key(*frame)
        expected = f"one of {', '.join(FORMATS)}"
        yield Fault.at(place, "EE-206", "'frame' declares no format", found="", expected=expected)
    elif formats:
        yield from _unused(facts, link, frame, f"{formats[0]}: …")


def _unused(facts: Facts, link: Keys, path: Keys, source: str) -> Iterator[Fault]:
    """A link that brings nothing: a description says of each what comes over it."""
    if _broken_within(facts, "channels"):
        return
    over = (
        name for name in facts.names("channels") if any(_says(facts, "channels", name, s) for s in OVER_LINK)
    )
    several = len(link_paths(facts)) > 1
    if any(_link_of(facts, name) in (link, None) if several else True for name in over):
        return
    named = f"link: {link[1]}, " if several else ""
    place, what = facts.places.key(*path), "no channel comes over the link"
    expected = f"channels: {{a_name: {{{named}{source}}}}}"
    yield Fault.at(place, "EE-206", what, found="", expected=expected)


def _text_frame(facts: Facts, path: Keys) -> Iterator[Fault]:
    if not isinstance(facts.get(*path), dict):
        return
    signs = {key: facts.get(*path, key) or "" for key in ("separator", "equals", "checksum_mark")}
    for key, sign in signs.items():
        if set(sign) & (_NUMERIC | _ENDS):
            why = "ends a line" if set(sign) & _ENDS else "stands in numbers"
            yield _sign(facts, (*path, key), f"{key!r} {why}", "another character")
    if signs["separator"] and signs["separator"] == signs["equals"]:
        what = "'separator' and 'equals' are the same"
        key = "equals" if _says(facts, *path, "equals") else "separator"
        yield _sign(facts, (*path, key), what, "two characters")
    if start := facts.get(*path, "start") or "":
        if set(start) & _ENDS:
            yield _sign(facts, (*path, "start"), "'start' ends a line", "a text that begins one")
        elif not set(start) - _NUMERIC - set("".join(signs.values())):
            what = "'start' may stand within a line"
            yield _sign(facts, (*path, "start"), what, "a character that no value has, such as $")


def _sign(facts: Facts, path: Keys, what: str, expected: str) -> Fault:
    return Fault.at(facts.places.value(*path), CODE, what, expected=expected)


def _record_frame(facts: Facts, path: Keys) -> Iterator[Fault]:
    if not isinstance(facts.get(*path), dict):
        return
    framing, start = facts.get(*path, "framing"), _says(facts, *path, "start")
    if framing == "start" and not start:
        place = facts.places.key(*path)
        expected = "start: the bytes that begin a record, such as AA55; or framing: cobs or slip"
        yield Fault.at(place, "EE-206", "key 'start' is missing in 'record'", found="", expected=expected)
    elif framing in ("cobs", "slip") and start:
        what = f"framing: {framing} has no start bytes"
        yield _fault(facts, (*path, "start"), what, "a delimiter only, or framing: start")


def _channel(facts: Facts, name: str) -> Iterator[Fault]:
    path = ("channels", name)
    if name == NO_CHANNEL:
        place, expected = facts.places.key(*path), "another name"
        yield Fault.at(place, "EE-211", "this name says that there is no channel", expected=expected)
    sources = [each for each in Channel.SOURCES if _says(facts, *path, each)]
    if not sources and _broken_within(facts, *path):
        return
    if not sources:
        place, expected = facts.places.key(*path), f"one of {', '.join(Channel.SOURCES)}"
        yield Fault.at(place, "EE-206", f"channel {name!r} has no source", found="", expected=expected)
        return
    if len(sources) > 1:
        what, expected = f"channel {name!r} has two sources", f"one of {', '.join(sources)}"
        yield _fault(facts, (*path, sources[1]), what, expected)
        return
    (source,) = sources
    yield from _meaning(facts, name) if source != "codec" else _given_by_codec(facts, name)
    if source in OVER_LINK:
        yield from _over_link(facts, name, source)
    elif _says(facts, *path, "link"):
        what = f"channel {name!r} is an input of the board and comes over no link"
        yield _fault(facts, (*path, "link"), what, "no link")
    if isinstance(facts.get(*path, source), dict):
        yield from _place(facts, name, source)
        yield from _raws(facts, name, source)


def _meaning(facts: Facts, name: str) -> Iterator[Fault]:
    """Unit and what belongs to it."""
    path = ("channels", name)
    if (*path, "unit") in facts.broken:
        return
    pressure = facts.get(*path, "unit") is not None
    for key in OF_BITS if pressure else OF_PRESSURES:
        if _says(facts, *path, key):
            what = f"{key!r} is for a {'bit' if pressure else 'pressure'}"
            expected = "no unit" if pressure else "unit: that of the pressure"
            yield _fault(facts, (*path, key), what, expected)
    if not pressure:
        return
    if facts.get(*path, "scale") == 0:
        place, expected = facts.places.value(*path, "scale"), "units per count"
        yield Fault.at(place, "EE-208", "with 'scale' 0 every value is the same", expected=expected)
    span = _numbers(facts, *path, "range")
    if span is not None and span[0] >= span[1]:
        place = facts.places.value(*path, "range")
        expected = "[lowest, highest]"
        yield Fault.at(
            place, "EE-222", "'range' is empty or reversed", found=_listed(span), expected=expected
        )


def _given_by_codec(facts: Facts, name: str) -> Iterator[Fault]:
    for key in MEANING:
        if _says(facts, "channels", name, key):
            what = f"the codec says what {name!r} means: it has no {key!r}"
            yield _fault(facts, ("channels", name, key), what, f"no {key}")


def _listed(values: Any) -> str:
    return f"[{', '.join(number(each) for each in values)}]"


def _over_link(facts: Facts, name: str, source: str) -> Iterator[Fault]:
    path, links = ("channels", name, source), link_paths(facts)
    frame = "codec: …" if source == "codec" else f"frame: {{{source}: …}}"
    expected = f"link: {{port: …, {frame}}}"
    if not links:
        if ("links",) not in facts.broken:
            yield _fault(facts, path, f"channel {name!r} comes over a link, and there is none", expected)
        return
    link = _link_of(facts, name)
    if link is None:
        yield from _which_link(facts, name, [str(each[-1]) for each in links])
        return
    where = ".".join(map(str, link))
    if link in facts.broken:
        return
    if not _says(facts, *link, "frame"):
        if source != "codec":
            what = f"channel {name!r} comes in a frame, and the link declares none"
            yield _fault(facts, path, what, expected)
    elif (declared := _format(facts, link)) and declared != source:
        what = f"channel {name!r} does not fit the frame of the link"
        yield _fault(facts, path, what, f"{declared}, as {where}.frame declares")


def _which_link(facts: Facts, name: str, links: list[str]) -> Iterator[Fault]:
    """It is not said, or there is no such link."""
    path = ("channels", name, "link")
    if path in facts.broken:
        return
    if not _says(facts, *path):
        what, expected = f"it is not said over which link {name!r} comes", f"link: {' or '.join(links)}"
        yield Fault.at(facts.places.key("channels", name), "EE-206", what, found="", expected=expected)
    elif _says(facts, "link"):
        what = "there is one link, and it has no name"
        yield _fault(facts, path, what, "no link, or its name under links")
    else:
        what, hint = "there is no such link", did_you_mean(str(facts.get(*path)), links)
        yield Fault.at(
            facts.places.value(*path), CODE, what, expected=f"one of {', '.join(links)}", hint=hint
        )


def _place(facts: Facts, name: str, source: str) -> Iterator[Fault]:
    """Where it stands in the frame."""
    path = ("channels", name, source)
    frame = (*(_link_of(facts, name) or ("link",)), "frame")
    if source == "text":
        yield from _text_place(facts, path, (*frame, source))
    elif source == "record":
        yield from _record_place(facts, path, (*frame, source))
    elif source == "modbus":
        yield from _register_place(facts, path)


def _text_place(facts: Facts, path: Keys, frame: Keys) -> Iterator[Fault]:
    key = facts.get(*path, "key")
    if _says(facts, *path, "field") and _says(facts, *path, "key"):
        yield _fault(facts, (*path, "key"), "a value stands in a field or behind a key", "one of the two")
    elif (
        not _says(facts, *path, "field")
        and not _says(facts, *path, "key")
        and not _broken_within(facts, *path)
    ):
        place, expected = facts.places.key(*path), "field: which one, or key: what stands in front of it"
        yield Fault.at(place, "EE-206", "it is not said where in the line", found="", expected=expected)
    if key and isinstance(facts.get(*frame), dict):
        signs = "".join(facts.get(*frame, each) or "" for each in ("separator", "equals"))
        if set(key) & (set(signs) | _ENDS) or key != key.strip():
            what, expected = (
                "no such key is ever found",
                "a key without separator, equals and blanks around it",
            )
            yield _sign(facts, (*path, "key"), what, expected)


def _mask(facts: Facts, path: Keys) -> Iterator[Fault]:
    """Bits that the type does not have."""
    mask, value_type = facts.get(*path, "bitmask"), facts.get(*path, "value_type")
    if mask is None or value_type is None:
        return
    full = raw_limits("u" + value_type.removeprefix("u")) if value_type != "float32" else None
    if full is None:
        yield _fault(facts, (*path, "bitmask"), "a float32 has no bits to choose", "an integer type")
    elif mask > full[1]:
        expected = f"at most 0x{full[1]:X}"
        yield _sign(facts, (*path, "bitmask"), f"'bitmask' has bits that no {value_type} has", expected)


def _record_place(facts: Facts, path: Keys, frame: Keys) -> Iterator[Fault]:
    yield from _mask(facts, path)
    first, value_type = facts.get(*path, "byte"), facts.get(*path, "value_type")
    length = facts.get(*frame, "length") if _says(facts, *frame) else None
    if first is None or value_type is None:
        return
    size = type_bits(value_type) // 8
    if length is not None and first + size > length:
        what = f"the record ends before this {value_type}"
        expected = (
            f"at most {length - size} of {length} bytes" if length >= size else f"length of {size} or more"
        )
        yield Fault.at(facts.places.value(*path, "byte"), "EE-208", what, expected=expected)
    if size == 1 and _says(facts, *path, "byte_order"):
        yield _fault(facts, (*path, "byte_order"), f"{value_type} is a single byte", "no byte_order")


def _register_place(facts: Facts, path: Keys) -> Iterator[Fault]:
    table, value_type = facts.get(*path, "register_type"), facts.get(*path, "value_type")
    if table in ("coil", "discrete_input"):
        for key in ("value_type", "word_order", "bitmask"):
            if _says(facts, *path, key):
                yield _fault(facts, (*path, key), f"a {table} is a single bit", f"no {key}")
        return
    yield from _mask(facts, path)
    if value_type is None:
        return
    wide = type_bits(value_type) == 32
    if not wide and _says(facts, *path, "word_order"):
        yield _fault(facts, (*path, "word_order"), f"{value_type} is a single register", "no word_order")
    if wide and facts.get(*path, "address") == 0xFFFF:
        place, what = (
            facts.places.value(*path, "address"),
            f"the second register of this {value_type} does not exist",
        )
        yield Fault.at(place, "EE-208", what, expected="at most 65534")


def limits_of_source(facts: Facts, path: Keys) -> tuple[int, int] | None:
    """The lowest and the highest raw value of a place; None: it is a number with a fraction, or broken."""
    source = path[-1]
    if source == "modbus" and facts.get(*path, "register_type") in ("coil", "discrete_input"):
        return 0, 1
    if source not in ("record", "modbus") or (value_type := facts.get(*path, "value_type")) is None:
        return None
    mask = facts.get(*path, "bitmask")
    full = raw_limits("u" + value_type) if value_type.startswith("int") else raw_limits(value_type)
    return None if mask is not None and (full is None or mask > full[1]) else raw_limits(value_type, mask)


def _raws(facts: Facts, name: str, source: str) -> Iterator[Fault]:
    """Raw values that the type does not have, or that say two things."""
    path = ("channels", name)
    limits = limits_of_source(facts, (*path, source))
    invalid, on = _numbers(facts, *path, "invalid") or (), _numbers(facts, *path, "on")
    for key, raws in (("invalid", invalid), ("on", on or ())):
        for index, raw in enumerate(raws):
            if limits is not None and not limits[0] <= raw <= limits[1]:
                place = facts.places.value(*path, key, index)
                width = limits[1] - limits[0] + 1
                hint = (
                    f"the same bits are {raw - width}" if limits[0] < 0 and limits[0] <= raw - width else ""
                )
                expected = f"{limits[0]} to {limits[1]}"
                yield Fault.at(
                    place, "EE-208", "no such raw value is ever sent", expected=expected, hint=hint
                )
            elif key == "on" and raw in invalid:
                place = facts.places.value(*path, key, index)
                yield Fault.at(place, CODE, "this raw value is invalid, too", expected="one of the two")
    if on is not None and not on:
        place, expected = facts.places.value(*path, "on"), "the raw values that are on"
        yield Fault.at(place, "EE-211", "'on' is empty", found="[]", expected=expected)
    if (
        on
        and limits is not None
        and limits[1] - limits[0] < 256
        and set(range(limits[0], limits[1] + 1)) <= {*on}
    ):
        place = facts.places.value(*path, "on")
        yield Fault.at(place, CODE, "every raw value is on", found=_listed(on), expected="some that are off")
    span, scale, offset = (_numbers(facts, *path, key) for key in ("range", "scale", "offset"))
    if span and scale and offset is not None and limits and facts.get(*path, "unit") and span[0] < span[1]:
        low, high = sorted(limit * scale + offset for limit in limits)
        if high < span[0] or low > span[1]:
            place = facts.places.value(*path, "range")
            what = "no raw value is ever in this range"
            expected = f"something between {number(low)} and {number(high)} {facts.get(*path, 'unit')}"
            yield Fault.at(place, "EE-222", what, found=_listed(span), expected=expected)


def _shared(facts: Facts, names: list[str]) -> Iterator[Fault]:
    """Two channels that are read from the same place, and are not bits that say different things."""
    seen: list[tuple[str, str, set[tuple[Any, ...]], Any]] = []
    for name in names:
        for source in Channel.SOURCES:
            path = ("channels", name, source)
            if not isinstance(facts.get(*path), dict):
                continue
            pressure = facts.get("channels", name, "unit") is not None
            meaning = None if pressure else (_plain(facts, name, "on"), facts.get("channels", name, "invert"))
            place = {(_link_of(facts, name), *bit) for bit in _bits_of(facts, path)}
            for other, theirs, taken, said in seen:
                same = place == taken and said == meaning
                if theirs == source and place & taken and (same or (pressure and said is None)):
                    what = f"its place already belongs to {other!r}"
                    yield _shared_fault(facts, path, what)
                    break
            seen.append((name, source, place, meaning))


def _plain(facts: Facts, name: str, key: str) -> tuple[Any, ...]:
    return tuple(_numbers(facts, "channels", name, key) or ())


def _shared_fault(facts: Facts, path: Keys, what: str) -> Fault:
    place, expected = facts.places.key(*path), "a place of its own"
    return Fault.at(place, "EE-221", what, found=str(path[-1]), expected=expected)


def _bits_of(facts: Facts, path: Keys) -> Iterator[tuple[Any, ...]]:
    """Each bit that a channel is read from; of text, its field or key; of a codec, its channel."""
    source = path[-1]
    if source == "codec":
        yield source, facts.get(*path, "channel")
    if source == "text":
        for key in ("field", "key"):
            if _says(facts, *path, key):
                yield key, facts.get(*path, key)
        return
    if source not in ("record", "modbus"):
        return
    first = facts.get(*path, "byte" if source == "record" else "address")
    if first is None:
        return
    where: tuple[Any, ...] = ()
    if source == "modbus":
        where = facts.get(*path, "unit"), facts.get(*path, "register_type")
        if where[1] in ("coil", "discrete_input"):
            yield *where, first
            return
    limits = limits_of_source(facts, path)
    value_type, mask = facts.get(*path, "value_type"), facts.get(*path, "bitmask")
    if value_type is None or (limits is None and value_type != "float32"):
        return
    width, unit = type_bits(value_type), 8 if source == "record" else 16
    order = facts.get(*path, "byte_order" if source == "record" else "word_order")
    for bit in range(width):
        if mask is None or mask >> bit & 1:
            part = bit // unit
            yield *where, first + (part if order == "little" else width // unit - 1 - part), bit % unit
