"""Synonyms of keys and words in ESPHome, Home Assistant, Telegraf, device trees and manuals."""

from __future__ import annotations

import re

from end_effector_hal.description._fault import Keys

_KEYS = {
    "active_low": "invert",
    "inverted": "invert",
    "values": "on",
    "slave": "unit",
    "slave_id": "unit",
    "stop_bits": "stopbits",
    "swap": "word_order",
    "unit_of_measurement": "unit",
}
_ELSEWHERE = {
    "timeout": "write timeout_ms under frame.modbus of the link, in milliseconds",
    "scan_interval": "write period_ms under the link, in milliseconds",
}
"""Keys of Home Assistant that belong to another stanza of the link here."""
_OF_THE_CHANNEL = ("invert", "on")
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
