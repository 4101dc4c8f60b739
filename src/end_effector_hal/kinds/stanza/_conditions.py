"""Conditions over channels that prove an actuator: the keys of ``evidence``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf
from typing import Annotated, Any, NamedTuple, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator
from pydantic_core import PydanticCustomError

from ._base import BaseStanza, Name

DEEPEST, MOST = 6, 64
"""Limits: levels of one condition, and conditions of one actuator (every ``all``, ``on`` … counts)."""

_Gauge = Annotated[float | None, Field(ge=-110, le=2000)]
_Quantity = Annotated[float | None, Field(ge=-1e6, le=1e6)]


class Leaf(NamedTuple):
    """A channel that a condition reads.

    Attributes:
        path: path from the outer condition to the one that names the channel.
        key: the key that names the channel.
        channel: name of the channel.
        bit: True if the channel is a bit, False if it is a measured quantity.
        thresholds: key and value of each threshold, in gauge kPa or the unit of the channel.
    """

    path: tuple[str | int, ...]
    key: str
    channel: str
    bit: bool
    thresholds: tuple[tuple[str, float], ...]


class Condition(BaseStanza):
    """A condition over channels: exactly one of `all`, `any`, `not`, `on`, or `channel` with one threshold.

    The threshold of a pressure has `_kpa` in its key; that of another quantity is in the unit of its channel.

    A channel without a fresh, valid reading makes its condition unknown. `any` is true if one condition is true, and
    `all` is false if one is false, even if others are unknown. Otherwise one unknown condition makes `any`, `all` and
    `not` unknown.
    """

    all: Annotated[tuple[Condition, ...] | None, Field(strict=False)] = Field(
        default=None, description="each of these conditions holds"
    )
    any: Annotated[tuple[Condition, ...] | None, Field(strict=False)] = Field(
        default=None, description="at least one of these conditions holds"
    )
    not_: Condition | None = Field(default=None, alias="not", description="this condition does not hold")
    on: Name | None = Field(default=None, description="this bit is on")
    channel: Name | None = Field(default=None, description="what is measured, to which a threshold belongs")
    below_kpa: _Gauge = Field(default=None, description="gauge pressure less than this; a vacuum is negative")
    above_kpa: _Gauge = Field(default=None, description="gauge pressure more than this; a vacuum is negative")
    between_kpa: Annotated[tuple[float, ...] | None, Field(strict=False)] = Field(
        default=None, description="gauge pressure from the first to the second, both included"
    )
    below: _Quantity = Field(
        default=None, description="less than this, in the unit of the channel (mm, %, V, …)"
    )
    above: _Quantity = Field(
        default=None, description="more than this, in the unit of the channel (mm, %, V, …)"
    )
    between: Annotated[tuple[float, ...] | None, Field(strict=False)] = Field(
        default=None, description="from the first to the second, both included, in the unit of the channel"
    )
    for_ms: Annotated[int, Field(ge=0, le=60_000)] = Field(
        default=0, description="without a break for at least this long, seen by the samples at its ends"
    )
    samples: Annotated[int, Field(ge=1, le=1000)] = Field(
        default=1, description="for this many consecutive samples"
    )

    @model_validator(mode="after")
    def _says_one_thing(self) -> Self:
        said = [key for key in _SAYS if getattr(self, key) is not None]
        words = [key.rstrip("_") for key in said]
        if len(said) > 1:
            what = f"a condition has {len(said)} keys that exclude each other: {', '.join(words)}"
            raise _wrong(what, "one of them", "all: [{…}, {…}] holds where each of them does")
        if self.channel is not None and not {*said} & {*_THRESHOLDS}:
            raise _wrong("'channel' has no threshold", f"one of {', '.join(_THRESHOLDS)}, beside channel")
        if not said:
            raise _wrong("a condition is empty", f"one of {', '.join(key.rstrip('_') for key in _SAYS)}")
        key = said[0]
        if key in _THRESHOLDS and self.channel is None:
            raise _wrong(f"{key!r} names no channel", f"channel: its name, beside {key}")
        if key in ("all", "any") and not getattr(self, key):
            raise _wrong(f"{key!r} has no conditions", "at least one condition")
        if self.between_kpa is not None:
            low, high = self.between_kpa if len(self.between_kpa) == 2 else (inf, -inf)
            if not -110 <= low < high <= 2000:
                raise _wrong("'between_kpa' is no range", "[low, high], gauge kPa from -110 to 2000")
        if self.between is not None:
            low, high = self.between if len(self.between) == 2 else (inf, -inf)
            if not -1e6 <= low < high <= 1e6:
                raise _wrong("'between' is no range", "[low, high], in the unit of the channel")
        if self.depth > DEEPEST:
            raise _wrong("conditions are nested too deep", f"at most {DEEPEST} levels")
        return self

    @model_serializer(mode="wrap")
    def _what_is_said(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: value for key, value in handler(self).items() if value != _DEFAULTS.get(key)}

    @property
    def parts(self) -> tuple[Condition, ...]:
        """The conditions directly inside this one."""
        return self.all or self.any or (() if self.not_ is None else (self.not_,))

    @property
    def depth(self) -> int:
        """Number of nested levels, this condition included."""
        return 1 + max((each.depth for each in self.parts), default=0)

    @property
    def size(self) -> int:
        """Number of conditions, this one included."""
        return 1 + sum(each.size for each in self.parts)

    @property
    def leaves(self) -> Iterator[Leaf]:
        """The channels that this condition reads, in order, with repetitions."""
        if self.on is not None:
            yield Leaf((), "on", self.on, True, ())
        elif self.channel is not None:
            limits = {key: getattr(self, key) for key in _THRESHOLDS}
            found = tuple(
                (key, each)
                for key, value in limits.items()
                if value is not None
                for each in (value if isinstance(value, tuple) else (value,))
            )
            yield Leaf((), "channel", self.channel, False, found)
        key = "not" if self.not_ is not None else "all" if self.all else "any"
        for index, part in enumerate(self.parts):
            inside: tuple[str | int, ...] = (key,) if self.not_ is not None else (key, index)
            for leaf in part.leaves:
                yield leaf._replace(path=(*inside, *leaf.path))

    @property
    def span(self) -> tuple[float, float]:
        """The limits of its threshold, kPa or the channel's unit.

        Both limits are included for a range (`between`), else excluded.
        """
        between = self.between_kpa or self.between
        if between is not None:
            return between[0], between[1]
        below = self.below if self.below_kpa is None else self.below_kpa
        if below is not None:
            return -inf, below
        above = self.above if self.above_kpa is None else self.above_kpa
        return (inf if above is None else above), inf

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that this condition reads, without repetitions."""
        return tuple(dict.fromkeys(leaf.channel for leaf in self.leaves))

    @property
    def at_once(self) -> Condition:
        """This condition without `for_ms` and `samples`: it judges a single sample."""
        inside: dict[str, Any] = {}
        if self.not_ is not None:
            inside["not_"] = self.not_.at_once
        elif self.parts:
            inside["all" if self.all else "any"] = tuple(each.at_once for each in self.parts)
        return self.model_copy(update={"for_ms": 0, "samples": 1, **inside})

    @property
    def asked(self) -> Condition | None:
        """The parts of this condition that require something to hold, judged at once; None: there are none.

        `for_ms`, `samples` and every `not` are left out.
        """
        if self.not_ is not None:
            return None
        if not self.parts:
            return self.at_once
        asked = [each.asked for each in self.parts]
        if self.any and None in asked:
            return None
        found = tuple(each for each in asked if each is not None)
        return self.at_once.model_copy(update={"all" if self.all else "any": found}) if found else None

    def lasts_s(self, period_s: float) -> float:
        """Return the shortest time in which it can become true, s, with a sample every ``period_s``."""
        own = max(self.for_ms / 1000, (self.samples - 1) * period_s)
        return own + max((each.lasts_s(period_s) for each in self.parts), default=0.0)

    def can_be_known(self, carried: Mapping[str, object]) -> bool:
        """Return whether the carried channels can make the condition true or false rather than unknown."""
        if not self.parts:
            return (self.on or self.channel) in carried
        known = [each.can_be_known(carried) for each in self.parts]
        return any(known) if self.any else all(known)


_THRESHOLDS = ("below_kpa", "above_kpa", "between_kpa", "below", "above", "between")
_SAYS = ("all", "any", "not_", "on", *_THRESHOLDS)
_DEFAULTS = {field.alias or key: field.default for key, field in Condition.model_fields.items()}


def _wrong(what: str, expected: str, hint: str = "") -> PydanticCustomError:
    return stanza_fault("EE-227", what, expected, hint)


def stanza_fault(code: str, what: str, expected: str, hint: str = "") -> PydanticCustomError:
    """Return the error to raise in a pydantic validator; it becomes a fault at the place of the value.

    Args:
        code: ``EE-2..``.
        what: what is wrong, without a full stop.
        expected: what is allowed at this place.
        hint: how to correct it.
    """
    told = {"code": code, "what": what, "expected": expected, "hint": hint}
    return PydanticCustomError("stanza_fault", "{what}, expected {expected}", told)


class EvidenceConditions(BaseStanza):
    """Conditions that prove an actuator. They replace the evidence of its kind.

    The evidence is UNKNOWN while a channel that decides is not known, and while the sensors contradict each other:
    `fault` holds, or `confirmed` and `gone` hold at once. A contradiction that lasts for half a second raises an
    alarm.
    """

    confirmed: Condition = Field(description="proves that it grips")
    gone: Condition = Field(description="proves that it has released; not the opposite of confirmed")
    lost: Condition | None = Field(
        default=None, description="once confirmed: no longer; default: as soon as a sample no longer confirms"
    )
    empty: Condition | None = Field(default=None, description="it has gripped nothing; default: never")
    fault: Condition | None = Field(
        default=None,
        description="its sensors contradict each other; default: all bits that confirmed and gone require are on",
    )

    @model_validator(mode="after")
    def _is_bounded(self) -> Self:
        if sum(each.size for _, each in self.named) > MOST:
            raise _wrong("there are too many conditions", f"at most {MOST} for one actuator")
        if self.confirmed.at_once == self.gone.at_once:
            raise _wrong("'confirmed' and 'gone' are the same condition", "gone: what only a release shows")
        return self

    @model_serializer(mode="wrap")
    def _what_is_said(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: value for key, value in handler(self).items() if value is not None}

    @property
    def named(self) -> tuple[tuple[str, Condition], ...]:
        """The conditions that are given, with their keys."""
        return tuple((key, value) for key, value in self if value is not None)

    @property
    def leaves(self) -> Iterator[Leaf]:
        """The channels that the conditions read, with repetitions; a path begins with the condition's key."""
        for key, condition in self.named:
            for leaf in condition.leaves:
                yield leaf._replace(path=(key, *leaf.path))

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that the conditions read, without repetitions."""
        return tuple(dict.fromkeys(leaf.channel for leaf in self.leaves))
