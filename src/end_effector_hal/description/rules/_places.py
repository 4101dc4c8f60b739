"""Rules for the place of a channel in a frame of its link, and for two channels at the same place."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from end_effector_hal.description._fault import Fault, Keys
from end_effector_hal.description._shape import Facts
from end_effector_hal.description.model._channels import Channel, raw_limits, type_bits

from ._frames import CODE, ENDS, link_of, unit_faults

DEEPEST = 8
"""Most keys in the path of a value in JSON."""
_IIO_FILE = re.compile(r"in_([a-z]+[0-9]*)_(?:raw|scale|offset)")


def place_faults(facts: Facts, name: str, source: str) -> Iterator[Fault]:
    """Yield every fault of a channel's place in its frame."""
    path = ("channels", name, source)
    frame = (*(link_of(facts, name) or ("link",)), "frame")
    if source == "text":
        yield from _text_place(facts, path, (*frame, source))
    elif source == "json":
        yield from _json_place(facts, name)
    elif source == "record":
        yield from _record_place(facts, path, (*frame, source))
    elif source == "modbus":
        yield from unit_faults(facts, link_of(facts, name), path)
        yield from _register_place(facts, path)
    elif source == "analog" and (found := _IIO_FILE.fullmatch(facts.get(*path, "channel") or "")):
        yield facts.fault((*path, "channel"), CODE, "this is a file of the channel", f"its name: {found[1]}")


def _text_place(facts: Facts, path: Keys, frame: Keys) -> Iterator[Fault]:
    key = facts.get(*path, "key")
    if facts.says(*path, "field") and facts.says(*path, "key"):
        yield facts.key_fault(
            (*path, "key"), CODE, "a value stands in a field or behind a key", "one of the two"
        )
    elif not facts.says(*path, "field") and not facts.says(*path, "key") and not facts.broken_within(*path):
        expected = "field: which one, or key: what stands in front of it"
        yield facts.key_fault(path, "EE-206", "its place in the line is missing", expected, found="")
    if key and isinstance(facts.get(*frame), dict):
        signs = "".join(facts.get(*frame, each) or "" for each in ("separator", "equals"))
        if set(key) & (set(signs) | ENDS) or key != key.strip():
            expected = "a key without separator, equals and blanks around it"
            yield facts.fault((*path, "key"), CODE, "this key is never found", expected)


def _json_place(facts: Facts, name: str) -> Iterator[Fault]:
    """Check the path of a value, and that no other value is inside or around it."""
    path = ("channels", name, "json", "key")
    if (key := facts.get(*path)) is None:
        return
    keys = key.split(".")
    if not all(each.strip() == each != "" for each in keys) or len(keys) > DEEPEST:
        expected = f"at most {DEEPEST} keys with points between them, such as sensors.0.pressure"
        yield facts.fault(path, CODE, "this is no path", expected)
    for other in facts.names("channels"):
        outer = facts.get("channels", other, "json", "key") if other != name else None
        if outer and key.startswith(f"{outer}.") and link_of(facts, other) == link_of(facts, name):
            yield facts.fault(path, CODE, f"{outer!r} of {other!r} is a value, not an object", "another path")
            return


def _mask(facts: Facts, path: Keys) -> Iterator[Fault]:
    """Yield a fault for a bitmask with bits that the type does not have."""
    mask, value_type = facts.get(*path, "bitmask"), facts.get(*path, "value_type")
    if mask is None or value_type is None:
        return
    full = raw_limits("u" + value_type.removeprefix("u")) if value_type != "float32" else None
    if full is None:
        yield facts.key_fault((*path, "bitmask"), CODE, "a float32 has no bits to choose", "an integer type")
    elif mask > full[1]:
        expected = f"at most 0x{full[1]:X}"
        yield facts.fault((*path, "bitmask"), CODE, f"'bitmask' has bits that no {value_type} has", expected)


def _record_place(facts: Facts, path: Keys, frame: Keys) -> Iterator[Fault]:
    yield from _mask(facts, path)
    first, value_type = facts.get(*path, "byte"), facts.get(*path, "value_type")
    length = facts.get(*frame, "length") if facts.says(*frame) else None
    if first is None or value_type is None:
        return
    size = type_bits(value_type) // 8
    if length is not None and first + size > length:
        what = f"the record ends before this {value_type}"
        expected = (
            f"at most {length - size} of {length} bytes" if length >= size else f"length of {size} or more"
        )
        yield facts.fault((*path, "byte"), "EE-208", what, expected)
    if size == 1 and facts.says(*path, "byte_order"):
        yield facts.key_fault((*path, "byte_order"), CODE, f"{value_type} is a single byte", "no byte_order")


def _register_place(facts: Facts, path: Keys) -> Iterator[Fault]:
    table, value_type = facts.get(*path, "register_type"), facts.get(*path, "value_type")
    if table in ("coil", "discrete_input"):
        for key in ("value_type", "byte_order", "word_order", "bitmask"):
            if facts.says(*path, key):
                yield facts.key_fault((*path, key), CODE, f"a {table} is a single bit", f"no {key}")
        return
    yield from _mask(facts, path)
    if value_type is None:
        return
    wide = type_bits(value_type) == 32
    if not wide and facts.says(*path, "word_order"):
        yield facts.key_fault(
            (*path, "word_order"), CODE, f"{value_type} is a single register", "no word_order"
        )
    if wide and facts.get(*path, "address") == 0xFFFF:
        what = f"the second register of this {value_type} does not exist"
        yield facts.fault((*path, "address"), "EE-208", what, "at most 65534")


def limits_of_source(facts: Facts, path: Keys) -> tuple[int, int] | None:
    """Return the lowest and highest raw value at a place; None: it has fractions, or is faulty."""
    source = path[-1]
    if source == "modbus" and facts.get(*path, "register_type") in ("coil", "discrete_input"):
        return 0, 1
    if source not in ("record", "modbus") or (value_type := facts.get(*path, "value_type")) is None:
        return None
    mask = facts.get(*path, "bitmask")
    full = raw_limits("u" + value_type) if value_type.startswith("int") else raw_limits(value_type)
    return None if mask is not None and (full is None or mask > full[1]) else raw_limits(value_type, mask)


def shared_places(facts: Facts, names: list[str]) -> Iterator[Fault]:
    """Yield a fault for each channel at the place of another one.

    Bits with different meanings may share a place.
    """
    seen: list[tuple[str, str, set[tuple[Any, ...]], Any]] = []
    for name in names:
        for source in Channel.SOURCES:
            path = ("channels", name, source)
            if not isinstance(facts.get(*path), dict):
                continue
            pressure = facts.get("channels", name, "unit") is not None
            meaning = None if pressure else (_plain(facts, name, "on"), facts.get("channels", name, "invert"))
            place = {(link_of(facts, name), *bit) for bit in _bits_of(facts, path)}
            for other, theirs, taken, said in seen:
                same = place == taken and said == meaning
                if theirs == source and place & taken and (same or (pressure and said is None)):
                    what = f"its place already belongs to {other!r}"
                    yield facts.key_fault(path, "EE-221", what, "a place of its own")
                    break
            seen.append((name, source, place, meaning))


def _plain(facts: Facts, name: str, key: str) -> tuple[Any, ...]:
    return tuple(facts.unbroken("channels", name, key) or ())


def _bits_of(facts: Facts, path: Keys) -> Iterator[tuple[Any, ...]]:
    """Yield each bit that a channel is read from; for text its field or key, for a codec its channel."""
    source = path[-1]
    if source == "codec":
        yield source, facts.get(*path, "channel")
    if source in ("text", "json"):
        for key in ("field", "key"):
            if facts.says(*path, key):
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
    swapped = 8 if source == "modbus" and facts.get(*path, "byte_order") == "little" else 0
    for bit in range(width):
        if mask is None or mask >> bit & 1:
            part = bit // unit
            yield (
                *where,
                first + (part if order == "little" else width // unit - 1 - part),
                bit % unit ^ swapped,
            )
