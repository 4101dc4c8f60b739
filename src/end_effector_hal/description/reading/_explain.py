"""Turns pydantic's errors into faults with helpful messages: keys here, values in ``_values``."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from end_effector_hal.description._fault import Fault, Keys, Places, closest, did_you_mean
from end_effector_hal.description._numbers import WORDS, right_key, split
from end_effector_hal.description._shape import actuator_stanzas, fields_of, homes_of, stanza_at
from end_effector_hal.description.reading._values import key_hint
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import get_kind, kind_names

from ._values import no_choice, out_of_range, wrong_form, wrong_type

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails


def explain(error: ErrorDetails, places: Places, kinds: Mapping[str, str]) -> tuple[Keys, Fault]:
    """Return the faulty path and the fault for an error of pydantic; ``kinds``: the kind of each actuator."""
    path: Keys = error["loc"]
    # pydantic's sign for the key of a mapping; an unknown key may be called so, too
    is_key = path[-1] == "[key]" and error["type"] != "extra_forbidden"
    path = path[:-1] if is_key else path
    kind = kinds.get(str(path[1]), "") if len(path) > 1 else ""
    match error["type"]:
        case "extra_forbidden":
            return path, _unknown_key(path, kind, error["input"], places)
        case "missing":
            return path, _missing_key(path, kind, places)
        case "greater_than" | "greater_than_equal" | "less_than" | "less_than_equal":
            return path, out_of_range(path, kind, error, places)
        case "stanza_fault":
            said = error["ctx"]
            whole = path[0] == "actuators" and len(path) == 2  # its text would say nothing
            place, found = (places.key(*path), "") if whole else (places.value(*path), None)
            return path, Fault.at(
                place, said["code"], said["what"], found=found, expected=said["expected"], hint=said["hint"]
            )
        case "literal_error":
            return path, no_choice(path, error, places)
        case "string_pattern_mismatch" | "string_too_short" | "string_too_long" | "too_short" | "too_long":
            place = places.key(*path) if is_key else places.value(*path)
            return path, wrong_form(path, error, place)
        case _:
            return path, wrong_type(path, error, places)


def meant(path: Keys, fault: Fault) -> Iterator[Keys]:
    """Yield the path of the key that an unknown key was meant to be: its default must not be judged."""
    pattern = {"EE-205": r"(?:did you mean '|write )(\w+)", "EE-210": r"write (\w+)"}.get(fault.code)
    if pattern and (found := re.match(pattern, fault.hint)):
        yield (*path[:-1], found[1])


def _unknown_key(path: Keys, kind: str, value: Any, places: Places) -> Fault:
    key, stanza = str(path[-1]), stanza_at(path[:-1], kind)
    known = list(fields_of(stanza)) if stanza else []
    place = places.key(*path)
    found = f"{key}:" if isinstance(value, dict | list) else f"{key}: {places.value(*path).text}"
    if other := right_key(key, value, known):
        what = f"wrong unit in key {key!r}" if split(key)[1] else f"key {key!r} has no unit"
        return Fault.at(
            place,
            "EE-210",
            what,
            found=found,
            expected=WORDS.get(split(other[0])[1], ""),
            hint=f"write {other[1]}",
        )
    outer = (path[:end] for end in range(len(path) - 2, 0, -1))
    around = next((at for at in outer if (near := stanza_at(at, kind)) and key in fields_of(near)), ())
    hint = key_hint(key, path, known)
    hint = hint or (f"it belongs to {'.'.join(map(str, around))}" if around else did_you_mean(key, known))
    if not hint and (homes := homes_of(key, value)):
        hint = f"it belongs to {' or '.join(each or 'the top' for each in homes)}"
    inside = ".".join(map(str, path[:-1])) or "the description"
    expected = f"a key of {inside}" if hint else f"one of {', '.join(known)}"
    return Fault.at(place, "EE-205", f"unknown key {key!r}", found=found, expected=expected, hint=hint)


def _missing_key(path: Keys, kind: str, places: Places) -> Fault:
    if isinstance(path[-1], int):
        place, what = places.value(*path[:-1]), f"{str(path[-2])!r} has too few elements"
        return Fault.at(place, "EE-207", what, expected="two: [lowest, highest]")
    key, stanza = str(path[-1]), stanza_at(path[:-1], kind)
    meaning = fields_of(stanza)[key].description if stanza else ""
    where = f" in {path[-2]!r}" if len(path) > 1 else ""
    what, place = f"key {key!r} is missing{where}", places.key(*path[:-1])
    return Fault.at(place, "EE-206", what, found="", expected=f"{key}: {meaning}")


def no_kind(name: str, stanza: dict[str, object], places: Places) -> Fault:
    """Return a fault for a missing or unknown kind of actuator; pydantic would stop there."""
    names = kind_names()
    kinds = " or ".join(names)
    if "kind" not in stanza:
        place, what = places.key("actuators", name), f"key 'kind' is missing in {name!r}"
        return Fault.at(place, "EE-206", what, found="", expected=f"kind: {kinds}")
    place, hint = places.value("actuators", name, "kind"), did_you_mean(stanza["kind"], names)
    if stanza["kind"] is None:
        return Fault.at(place, "EE-207", "'kind' has no value", found="", expected=kinds)
    if stanza["kind"] in names:
        return Fault.at(place, "EE-209", why_not(str(stanza["kind"])), expected="a kind that can be loaded")
    if stanza["kind"] == "output":
        hint = f"a plain output stands under outputs, in no sequence: outputs: {{{name}: {{line: …}}}}"
    return Fault.at(place, "EE-209", "unknown kind of actuator", expected=kinds, hint=hint)


def why_not(kind: object) -> str:
    """Return why a kind cannot be used; empty: it can."""
    if not isinstance(kind, str):
        return "this is no kind"
    try:
        get_kind(kind)
    except UsageError as error:
        return error.what.rstrip(".")
    return ""


def likely_kind(stanza: dict[str, object]) -> tuple[str, bool]:
    """Return the probable kind of a stanza with a faulty kind.

    The second value is True if the word itself shows the kind, False if only the keys do.
    """
    near = closest(stanza.get("kind"), kind_names())
    why_not(near)  # one that was meant is loaded
    stanzas = actuator_stanzas()
    near = near if near in stanzas else None
    by_keys = max(stanzas, key=lambda kind: len(stanza.keys() & fields_of(stanzas[kind]).keys()))
    return near or by_keys, near is not None
