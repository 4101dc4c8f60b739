"""Parses the options of ``eehal init``: the actuators of a new tool, and the links that confirm them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from end_effector_hal.codecs import codec_names
from end_effector_hal.description import did_you_mean
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import DeviceKind, get_kind
from end_effector_hal.kinds.stanza import NO_CHANNEL

NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_OTHER_WORDS = ("null", "true", "false", NO_CHANNEL)
BOARD = "none"
LINKS = ("text", "binary", "modbus", BOARD)
"""Links without a codec: a frame that is declared, or inputs of the board; the name of a codec is allowed as well."""


@dataclass(frozen=True)
class WantedActuator:
    """One actuator of the new tool; ``link`` is the name or kind of the link that confirms it, "" for any link."""

    name: str
    kind: DeviceKind[Any]
    link: str = ""


@dataclass(frozen=True)
class WantedLink:
    """A link that confirms actuators: ``what`` is one of `LINKS` or a codec; ``name`` is "" if there is
    only one link.
    """

    name: str
    what: str

    @property
    def said(self) -> str:
        """The text by which an actuator refers to this link."""
        return self.name or self.what


def wanted_actuators(text: str) -> tuple[WantedActuator, ...]:
    """Parse ``cups:vacuum,jaw:gripper``, or with the link of each actuator ``cups:vacuum:front``; raises UsageError."""
    found: dict[str, WantedActuator] = {}
    for each in text.split(","):
        name, colon, rest = each.strip().partition(":")
        kind, _, link = rest.partition(":")
        if not colon:
            raise UsageError(
                f"{each.strip()!r} is not an actuator.",
                todo="Write NAME:KIND, such as cups:vacuum,rod:cylinder.",
            )
        if not NAME.fullmatch(name):
            raise UsageError(
                f"{name!r} is not a valid name of an actuator.",
                todo="Write lower-case letters, digits and '_'.",
            )
        if name in _OTHER_WORDS:
            raise UsageError(
                f"{name!r} has another meaning in a description and cannot name an actuator.",
                todo=f"Write another one, such as {name}_1.",
            )
        if name in found:
            raise UsageError(f"Two actuators are named {name!r}.", todo="Give each a name of its own.")
        found[name] = WantedActuator(name, get_kind(kind), link)
    return tuple(found.values())


def wanted_links(texts: Sequence[str]) -> tuple[WantedLink, ...]:
    """Parse ``text``, or ``front:text`` and ``arm:modbus``, or one of these and ``none``; raises UsageError."""
    each_text = [each.strip() for text in texts for each in text.split(",")]
    several = len([each for each in each_text if each != BOARD]) > 1
    found: dict[str, WantedLink] = {}
    for each in each_text:
        name, colon, what = each.partition(":")
        if not colon:
            name, what = BOARD if each == BOARD and len(each_text) > 1 else "", each
        elif not NAME.fullmatch(name) or name in _OTHER_WORDS:
            raise UsageError(
                f"{name!r} is not a valid name of a link.",
                todo="Write lower-case letters, digits and '_': front:text.",
            )
        if not name and several:
            raise UsageError(f"The link {each!r} has no name.", todo=f"Write NAME:{each}, one for each link.")
        if name in found:
            raise UsageError(f"Two links are named {name!r}.", todo="Give each a name of its own.")
        if colon and what == BOARD:
            raise UsageError(
                "Inputs of the board have no link.", todo=f"Write --link {BOARD}, without a name."
            )
        found[name] = WantedLink(name, _known_link(what))
    return tuple(found.values())


def _known_link(link: str) -> str:
    if link not in LINKS and link not in codec_names():
        known = [*LINKS, *codec_names()]
        meant = did_you_mean(link, known)
        hint = f"{meant[0].upper()}{meant[1:]} " if meant else ""
        raise UsageError(f"There is no link {link!r}.", todo=f"{hint}There are: {', '.join(known)}.")
    return link
