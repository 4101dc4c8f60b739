"""Rules for `channels`: each has one source, a valid meaning, and a link that carries it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from end_effector_hal.description._fault import Fault, did_you_mean
from end_effector_hal.description._numbers import number
from end_effector_hal.description._shape import Facts
from end_effector_hal.description.model._channels import OPPOSITE, Channel
from end_effector_hal.kinds.stanza import NO_CHANNEL

from ._frames import CODE, ENDS, OVER_LINK, declared_format, link_of, link_paths
from ._places import limits_of_source, place_faults, shared_places

OF_BITS, OF_PRESSURES = ("on", "off", "invert"), ("scale", "offset", "range")
MEANING = ("unit", *OF_PRESSURES, "invalid", *OF_BITS)


def channel_faults(facts: Facts) -> Iterator[Fault]:
    """Yield every fault of the channels that a description declares."""
    names = facts.names("channels") if isinstance(facts.get("channels"), dict) else []
    for name in names:
        if isinstance(facts.get("channels", name), dict):
            yield from _channel(facts, name)
    yield from shared_places(facts, names)


def _channel(facts: Facts, name: str) -> Iterator[Fault]:
    path = ("channels", name)
    if name == NO_CHANNEL:
        yield facts.key_fault(path, "EE-211", "this name means that there is no channel", "another name")
    sources = [each for each in Channel.SOURCES if facts.says(*path, each)]
    if not sources and facts.broken_within(*path):
        return
    if not sources:
        expected = f"one of {', '.join(Channel.SOURCES)}"
        yield facts.key_fault(path, "EE-206", f"channel {name!r} has no source", expected, found="")
        return
    if len(sources) > 1:
        expected = f"one of {', '.join(sources)}"
        yield facts.key_fault((*path, sources[1]), CODE, f"channel {name!r} has two sources", expected)
        return
    (source,) = sources
    yield from _meaning(facts, name) if source != "codec" else _given_by_codec(facts, name)
    if source in OVER_LINK:
        yield from _over_link(facts, name, source)
    elif facts.says(*path, "link"):
        what = f"channel {name!r} is an input of the board and comes over no link"
        yield facts.key_fault((*path, "link"), CODE, what, "no link")
    if isinstance(facts.get(*path, source), dict):
        yield from place_faults(facts, name, source)
        yield from _words(facts, name, source)
        yield from _raws(facts, name, source)
        yield from _alarms(facts, name, source)


def _meaning(facts: Facts, name: str) -> Iterator[Fault]:
    """Check the unit and the keys that depend on it."""
    path = ("channels", name)
    if (*path, "unit") in facts.broken:
        return
    pressure = facts.get(*path, "unit") is not None
    for key in OF_BITS if pressure else OF_PRESSURES:
        if facts.says(*path, key):
            what = f"{key!r} is for a {'bit' if pressure else 'pressure'}"
            expected = "no unit" if pressure else "unit: that of the pressure"
            yield facts.key_fault((*path, key), CODE, what, expected)
    if not pressure:
        return
    if facts.get(*path, "scale") == 0:
        expected = "units per count"
        yield facts.fault((*path, "scale"), "EE-208", "with 'scale' 0 every value is the same", expected)
    span = facts.unbroken(*path, "range")
    if span is not None and span[0] >= span[1]:
        expected = "[lowest, highest]"
        yield facts.fault(
            (*path, "range"), "EE-222", "'range' is empty or reversed", expected, found=listed(span)
        )


def _alarms(facts: Facts, name: str, source: str) -> Iterator[Fault]:
    """Check that a bit has one alarm text, and that each code has its own, with one for all other codes."""
    path = ("channels", name, "alarm")
    given = facts.unbroken(*path) if facts.says(*path) else None
    if not given:
        return
    if facts.get("channels", name, "unit") is not None:
        yield facts.key_fault(path, CODE, "a pressure cannot be an alarm", "no unit: a bit, or codes")
        return
    alarms = [given] if isinstance(given, dict | str) else given
    entries = [each if isinstance(each, dict) else {} for each in alarms]
    codes = [each.get("code") for each in entries]
    coded = any(code is not None for code in codes)
    if not coded and len(codes) > 1:
        yield facts.key_fault(path, CODE, "a bit has one alarm", "one text, or a code in each")
    elif coded:
        yield from _codes(facts, name, source, codes)
    known = facts.names("actuators")
    for index, each in enumerate(entries):
        for unproven in each.get("unproven") or ():
            if unproven not in known:
                what, hint = f"no actuator is named {unproven!r}", did_you_mean(str(unproven), known)
                yield facts.fault(
                    (*(path if isinstance(given, dict) else (*path, index)), "unproven"),
                    CODE,
                    what,
                    f"one of {', '.join(known)}",
                    hint=hint,
                )


def _codes(facts: Facts, name: str, source: str, codes: list[Any]) -> Iterator[Fault]:
    path = ("channels", name)
    if source in ("codec", "digital"):
        what = f"{'an input line' if source == 'digital' else 'a channel of a codec'} has no codes"
        yield facts.key_fault((*path, "alarm"), CODE, what, "one text, without code")
        return
    of_bits = [key for key in ("invert", "off") if facts.says(*path, key)]
    for key in of_bits or (
        ["on"] if any(isinstance(each, str) for each in _meant(facts, name, "on")) else []
    ):
        what = f"{key!r} is for a bit" if of_bits else "a word is no code"
        expected = f"no {key}, or an alarm without codes" if of_bits else "numbers, or an alarm without codes"
        yield facts.key_fault((*path, key), CODE, what, expected)
    limits = limits_of_source(facts, (*path, source))
    invalid, on = facts.unbroken(*path, "invalid") or (), facts.unbroken(*path, "on")
    for index, code in enumerate(codes):
        place = facts.places.value(*path, "alarm", index, "code")
        if code in codes[:index]:
            what = "another alarm has this code" if code is not None else "two alarms have no code"
            yield Fault.at(place, CODE, what, expected="a different code in each alarm")
        elif code is not None and (code in invalid or (code == 0 if on is None else code not in on)):
            what = "this raw value is invalid, too" if code in invalid else "this raw value is no alarm"
            expected = "a value of 'on'" if on is not None else "not 0, where nothing is wrong"
            yield Fault.at(place, CODE, what, expected="one of the two" if code in invalid else expected)
        elif code is not None and limits is not None and not limits[0] <= code <= limits[1]:
            what, expected = "this raw value is never sent", f"{limits[0]} to {limits[1]}"
            yield Fault.at(place, "EE-208", what, expected=expected)


def _given_by_codec(facts: Facts, name: str) -> Iterator[Fault]:
    for key in MEANING:
        if facts.says("channels", name, key):
            what = f"the codec says what {name!r} means: it has no {key!r}"
            yield facts.key_fault(("channels", name, key), CODE, what, f"no {key}")


def listed(values: Any) -> str:
    return f"[{', '.join(number(each) for each in values)}]"


def _over_link(facts: Facts, name: str, source: str) -> Iterator[Fault]:
    path, links = ("channels", name, source), link_paths(facts)
    frame = "codec: …" if source == "codec" else f"frame: {{{source}: …}}"
    expected = f"link: {{port: …, {frame}}}"
    if not links:
        if ("links",) not in facts.broken:
            yield facts.key_fault(
                path, CODE, f"channel {name!r} comes over a link, and there is none", expected
            )
        return
    link = link_of(facts, name)
    if link is None:
        yield from _which_link(facts, name, [str(each[-1]) for each in links])
        return
    where = ".".join(map(str, link))
    if link in facts.broken:
        return
    if not facts.says(*link, "frame"):
        if source != "codec":
            what = f"channel {name!r} comes in a frame, and the link declares none"
            yield facts.key_fault(path, CODE, what, expected)
    elif (declared := declared_format(facts, link)) and declared != source:
        what = f"channel {name!r} does not fit the frame of the link"
        yield facts.key_fault(path, CODE, what, f"{declared}, as {where}.frame declares")


def _which_link(facts: Facts, name: str, links: list[str]) -> Iterator[Fault]:
    """Yield the fault of a channel whose link is not named or does not exist."""
    path = ("channels", name, "link")
    if path in facts.broken:
        return
    if not facts.says(*path):
        what = f"the link is missing over which {name!r} comes"
        yield facts.key_fault(("channels", name), "EE-206", what, f"link: {' or '.join(links)}", found="")
    elif facts.says("link"):
        what = "there is one link, and it has no name"
        yield facts.key_fault(path, CODE, what, "no link, or its name under links")
    else:
        hint = did_you_mean(str(facts.get(*path)), links)
        yield facts.fault(path, CODE, "there is no such link", f"one of {', '.join(links)}", hint=hint)


def _words(facts: Facts, name: str, source: str) -> Iterator[Fault]:
    """Yield faults of words that are never received, or that have no opposite."""
    path = ("channels", name)
    frame = (*(link_of(facts, name) or ("link",)), "frame", source)
    signs = set("".join(facts.get(*frame, key) or "" for key in ("separator", "equals"))) | ENDS
    for key in ("on", "off"):
        for index, word in enumerate(_meant(facts, name, key)):
            place = facts.places.value(*path, key, index)
            if not isinstance(word, str):
                continue
            if source not in ("text", "json"):
                yield Fault.at(place, CODE, "a word comes only in text or JSON", expected="a number")
            elif source == "text" and set(word) & signs:
                expected = "a word without separator and equals"
                yield Fault.at(place, CODE, "this word is never received", expected=expected)
            elif key == "on" and word not in OPPOSITE and not facts.says(*path, "off"):
                what = f"'off' is missing, and {word!r} has no known opposite"
                yield Fault.at(place, "EE-206", what, expected="off: the words that are off")


def _meant(facts: Facts, name: str, key: str) -> list[Any]:
    """Return the raw values and words of a key; true and false are words."""
    given = facts.unbroken("channels", name, key) or ()
    return [str(each).lower() if isinstance(each, bool) else each for each in given]


def _raws(facts: Facts, name: str, source: str) -> Iterator[Fault]:
    """Yield faults of raw values that the type does not have, or that have two meanings."""
    path = ("channels", name)
    limits = limits_of_source(facts, (*path, source))
    invalid, on = facts.unbroken(*path, "invalid") or (), facts.unbroken(*path, "on")
    off = facts.unbroken(*path, "off")
    for key, raws in (
        ("invalid", invalid),
        ("on", _meant(facts, name, "on")),
        ("off", _meant(facts, name, "off")),
    ):
        for index, raw in enumerate(raws):
            if isinstance(raw, str):
                continue
            if limits is not None and not limits[0] <= raw <= limits[1]:
                width = limits[1] - limits[0] + 1
                hint = (
                    f"the same bits are {raw - width}" if limits[0] < 0 and limits[0] <= raw - width else ""
                )
                expected = f"{limits[0]} to {limits[1]}"
                yield facts.fault(
                    (*path, key, index), "EE-208", "this raw value is never sent", expected, hint=hint
                )
            elif key != "invalid" and raw in invalid:
                yield facts.fault(
                    (*path, key, index), CODE, "this raw value is invalid, too", "one of the two"
                )
    for key, given in (("on", on), ("off", off)):
        if given is not None and not given:
            expected = f"the raw values that are {key}"
            yield facts.fault((*path, key), "EE-211", f"{key!r} is empty", expected, found="[]")
    if off and on is None and facts.get(*path, "unit") is None:
        yield facts.key_fault((*path, "off"), CODE, "'off' goes with 'on'", "on: the raw values that are on")
    if both := set(_meant(facts, name, "on")) & set(_meant(facts, name, "off")):
        what = f"{', '.join(map(str, both))} is on and off"
        yield facts.key_fault((*path, "off"), CODE, what, "one of the two")
    if (
        on
        and limits is not None
        and limits[1] - limits[0] < 256
        and set(range(limits[0], limits[1] + 1)) <= {*on}
    ):
        yield facts.fault((*path, "on"), CODE, "every raw value is on", "some that are off", found=listed(on))
    span, scale, offset = (facts.unbroken(*path, key) for key in ("range", "scale", "offset"))
    if span and scale and offset is not None and limits and facts.get(*path, "unit") and span[0] < span[1]:
        low, high = sorted(limit * scale + offset for limit in limits)
        if high < span[0] or low > span[1]:
            what = "no raw value is ever in this range"
            expected = f"something between {number(low)} and {number(high)} {facts.get(*path, 'unit')}"
            yield facts.fault((*path, "range"), "EE-222", what, expected, found=listed(span))
