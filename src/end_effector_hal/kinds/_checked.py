"""What another distribution's kind says of itself: looked at once, before anything rests on it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, get_args

from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import ACTIVE, INACTIVE, PENDING, TableState

from ._evidence import ChannelKey
from ._kind import DeviceKind
from .stanza import Actuator

_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


def checked(kind: Any) -> DeviceKind[Any]:
    """The kind itself; raises UsageError for a declaration that is not what `DeviceKind` says."""
    if wrong := next(_wrong(kind), ""):
        raise UsageError(
            f"the kind declares {wrong}.",
            todo="Inherit end_effector_hal.kinds.conformance.KindConformance in its tests.",
        )
    found: DeviceKind[Any] = kind
    return found


def _wrong(kind: Any) -> Iterator[str]:
    if not isinstance(kind, DeviceKind):
        yield "no subclass of DeviceKind"
    missing = [key for key in ("name", "stanza", "channels", "states") if not hasattr(kind, key)]
    if missing:
        yield f"no {', '.join(missing)}"
    if type(kind.name) is not str or not _NAME.fullmatch(kind.name):
        yield "a name that is no word of lower-case letters, digits and '_'"
    if not (isinstance(kind.stanza, type) and issubclass(kind.stanza, Actuator)):
        yield "a stanza that does not inherit Actuator"
    fields = kind.stanza.model_fields
    if "kind" not in fields or get_args(fields["kind"].annotation) != (kind.name,):
        yield f'a stanza whose kind is not Literal["{kind.name}"]'
    if not isinstance(kind.channels, tuple) or not all(
        isinstance(each, ChannelKey) for each in kind.channels
    ):
        yield "channels that are no ChannelKey"
    keys = [kind.opposing, kind.samples, *(key for low, _, high in kind.orders for key in (low, high))]
    for key in filter(None, (*(each.key for each in kind.channels), *keys)):
        if key not in fields:
            yield f"{key!r}, which its stanza does not have"
    for each in kind.channels:
        if each.carries is Kind.BIT and not each.key.endswith("_bit"):
            yield f"{each.key!r}, a bit whose key does not end in _bit"
    if not any(each.confirms for each in kind.channels):
        yield "no channel that confirms"
    states = kind.states
    if not (isinstance(states, type) and issubclass(states, TableState)):
        yield "states that are no TableState"
    if {int(state) for state in states} != {INACTIVE, PENDING, ACTIVE}:
        yield "other states than 0 inactive, 1 pending and 2 active"
