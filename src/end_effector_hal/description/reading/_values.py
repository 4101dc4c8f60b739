"""Faults of single values: their type, their range, their form.

Synonyms of keys and words in ESPHome, Home Assistant, Telegraf, device trees and manuals are recognised.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from end_effector_hal.description._address import refused_fieldbus
from end_effector_hal.description._fault import Fault, Keys, Place, Places, did_you_mean
from end_effector_hal.description._numbers import (
    Limits,
    convert,
    limits_of,
    number,
    split,
    with_unit,
    wrong_scale,
)
from end_effector_hal.description.model._channels import HEXADECIMAL
from end_effector_hal.kinds.stanza import PRINTABLE, Condition

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

_KEYS = {
    "active_low": "invert",
    "inverted": "invert",
    "values": "on",
    "slave": "unit",
    "slave_id": "unit",
    "stop_bits": "stopbits",
    "message_wait_milliseconds": "pause_ms",
    "swap": "word_order",
    "unit_of_measurement": "unit",
    "data_type": "value_type",
    "type": "value_type",
    "device_address": "unit",
    "path": "key",
    "json_path": "key",
    "nan_value": "invalid",
    "payload_on": "on",
    "payload_off": "off",
    "serial_port": "port",
    "controller": "port",
}
_ELSEWHERE = {
    "timeout": "write timeout_ms under frame.modbus of the link, in milliseconds",
    "message_wait_milliseconds": "write pause_ms under frame.modbus of the link",
    "scan_interval": "write period_ms under the link, in milliseconds",
    "bytesize": "leave it out: a byte has 8 bits",
    "data_bits": "leave it out: a byte has 8 bits",
    "method": "leave it out: frame: {modbus: {}} is RTU, with the port tcp://HOST Modbus TCP",
    "retries": "leave it out: the next period asks again",
}
"""Keys of Home Assistant and Telegraf that belong to another stanza of the link here, or to none."""
_CHANNELS_HAVE = {
    "min_value": "write range: [lowest, highest]",
    "max_value": "write range: [lowest, highest]",
    "value_template": "write json: {key: …} with the path behind value_json, and frame: {json: {}} for the link",
}
"""Keys of a sensor in Home Assistant, by what a channel has instead."""
_OF_THE_CHANNEL = ("invert", "on", "off", "invalid")
_WORDS = {
    "even": "E",
    "odd": "O",
    "none": "N",
    "u_word": "uint16",
    "s_word": "int16",
    "u_dword": "uint32",
    "s_dword": "int32",
    "fp32": "float32",
}


def key_hint(key: str, path: Keys, known: list[str]) -> str:
    """Return a hint with the name of an unknown key in a description; empty: it is not a known synonym."""
    other = _KEYS.get(key, "")
    if other in known:
        return f"write {other}"
    if key in _ELSEWHERE and (path[0] in ("link", "links") or "modbus" in path):
        return _ELSEWHERE[key]
    if path[0] in ("link", "links", "channels", "actuators") and (refused := refused_fieldbus(key)):
        return refused
    if key in _CHANNELS_HAVE and path[0] == "channels":
        return _CHANNELS_HAVE[key]
    in_a_source = len(path) == 4 and path[0] == "channels"
    return f"write {other}, beside {path[2]}" if other in _OF_THE_CHANNEL and in_a_source else ""


def word_hint(word: object, choices: list[str]) -> str:
    """Return a hint with the word that a description uses instead; empty: it is not a known synonym."""
    other = _WORDS.get(str(word).lower(), "")
    return f"write {other}" if other in choices else ""


def text_hint(path: Keys, text: str) -> str:
    """Return a hint with the probable meaning of a text in the wrong form; empty: there is none."""
    if path[-2:] == ("analog", "channel") and text.isdecimal():
        return f"write voltage{int(text)}"
    if path[-2:] == ("record", "start") and re.fullmatch(r"0[xX](?:[0-9A-Fa-f]{2}){1,8}", text):
        digits = text[2:].upper()
        return f"write start: {digits}" if re.search("[A-DF]", digits) else f'write start: "{digits}"'
    return ""


TYPES = {
    "string_type": "text",
    "string_unicode": "text",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "bool_type": "true or false",
    "tuple_type": "a list: [a, b, c]",
}
BOOLEANS = {"yes": "true", "on": "true", "1": "true", "no": "false", "off": "false", "0": "false"}
NAME = "lower-case letters, digits and '_', a letter first"
ROS_NAME = "a ROS name: letters, digits, '_' and '/', a letter first"


def out_of_range(path: Keys, kind: str, error: ErrorDetails, places: Places) -> Fault:
    """Return the fault of a number that is too small or too large."""
    value, bounds = error["input"], error.get("ctx", {})
    of_element = Limits(bounds.get("gt"), bounds.get("ge"), bounds.get("le"))
    limits = of_element if isinstance(path[-1], int) else limits_of(path, kind)
    what, hint = f"{_label(path)} is out of range", wrong_scale(str(path[-1]), value, limits)
    return Fault.at(places.value(*path), "EE-208", what, expected=str(limits), hint=hint)


def no_choice(path: Keys, error: ErrorDetails, places: Places) -> Fault:
    """Return the fault of a word that is not one of the allowed words."""
    choices = [word.strip("'") for word in re.findall(r"'[^']*'|\d+", error["ctx"]["expected"])]
    what, hint = f"{_label(path)} is not one of its choices", word_hint(error["input"], choices)
    hint = hint or did_you_mean(error["input"], choices)
    if error["input"] == "leave" and "endings" in path:
        says_the_same = "write hold: here it says the same"
        hint = (
            says_the_same
            if path[-1] != "power_up"
            else "the line arbiter drives every line from its start on"
        )
    return Fault.at(places.value(*path), "EE-209", what, expected=" or ".join(choices), hint=hint)


def wrong_form(path: Keys, error: ErrorDetails, place: Place) -> Fault:
    """Return the fault of a text or list of the wrong length, or of a name with wrong characters."""
    context = error.get("ctx", {})
    if context.get("pattern") == PRINTABLE:
        what = f"{_label(path)} holds a character that is not printed"
        folded = str(error["input"]).rstrip("\n").isprintable()
        hint = "end a folded text without a line break: >-" if folded else ""
        return Fault.at(place, "EE-211", what, expected="text in one line", hint=hint)
    if context.get("pattern") == HEXADECIMAL:
        what = f"{_label(path)} is not hexadecimal"
        return Fault.at(
            place,
            "EE-211",
            what,
            expected="1 to 8 bytes of two digits each, such as AA55",
            hint=text_hint(path, str(error["input"])),
        )
    if "pattern" in context:
        expected, hint = _name(str(error["input"]), context["pattern"])
        hint = text_hint(path, str(error["input"])) or hint
        return Fault.at(place, "EE-211", f"{_label(path)} is not a name", expected=expected, hint=hint)
    if error["type"] == "too_long":
        what, expected = f"{_label(path)} has too many elements", f"at most {context['max_length']}"
        return Fault.at(place, "EE-211", what, expected=expected)
    if "max_length" in context:
        most = context["max_length"]
        expected = "one character" if most == 1 else f"at most {most} characters"
        return Fault.at(place, "EE-211", f"{_label(path)} is too long", expected=expected)
    expected = "at least one " + ("element" if error["type"] == "too_short" else "character")
    return Fault.at(place, "EE-211", f"{_label(path)} is empty", expected=expected)


def wrong_type(path: Keys, error: ErrorDetails, places: Places) -> Fault:
    """Return the fault of a value that has not the type of its key."""
    expected = TYPES.get(error["type"], "keys with values")
    value, place, label = error["input"], places.value(*path), _label(path)
    if value is None:
        return Fault.at(place, "EE-207", f"{label} has no value", found="", expected=expected)
    hint = ""
    if isinstance(value, dict | list):
        pass
    elif error.get("ctx", {}).get("class_name") == Condition.__name__ and isinstance(value, str):
        expected, hint = "a condition", f"write {{on: {value}}}"
    elif expected == "text":
        hint = text_hint(path, place.text) or f'write "{place.text}"'
    elif expected == "true or false" and str(value).lower() in BOOLEANS:
        hint = f"did you mean {BOOLEANS[str(value).lower()]}?"
    elif "number" in expected:
        expected, hint = _number(str(path[-1]), value, expected)
    return Fault.at(place, "EE-207", f"{label} is of the wrong type", expected=expected, hint=hint)


def _number(key: str, value: Any, expected: str) -> tuple[str, str]:
    """Return the expected value in place of ``5 s`` or, in milliseconds, ``0.05``; and how to write it."""
    unit = split(key)[1]
    if isinstance(value, float) and unit == "ms" and 0 < value < 1:
        return expected, f"seconds? write {key}: {number(value * 1000)}"
    parsed = with_unit(value) if isinstance(value, str) else None
    if parsed is None:
        return expected, ""
    amount, written = parsed
    if not written:
        return f"{expected}, not quoted", f"write {key}: {number(amount)}"
    converted = convert(amount, written, unit)
    hint = f"write {key}: {number(converted)}" if converted is not None else ""
    return "a plain number; the unit is in the key" if unit else expected, hint


def _name(text: str, pattern: str) -> tuple[str, str]:
    """Return the form of a name, and a hint with a similar valid name."""
    ros = "A-Z" in pattern
    near = re.sub(r"[^A-Za-z0-9/]+" if ros else r"[^A-Za-z0-9]+", "_", text).strip("_/").lstrip("_0123456789")
    near = near if ros else near.lower()
    hint = f"did you mean {near!r}?" if re.fullmatch(pattern.strip("^$"), near) and near != text else ""
    return ROS_NAME if ros else NAME, hint


def _label(path: Keys) -> str:
    """Return the key in quotes, such as ``'timeout_s'``, or ``'sequence[1]'`` for an element."""
    last = next(index for index in reversed(range(len(path))) if not isinstance(path[index], int))
    return f"'{path[last]}{''.join(f'[{index}]' for index in path[last + 1 :])}'"
