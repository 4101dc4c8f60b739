"""The newest reading of each channel, as long as it is fresh."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar

from end_effector_hal.codecs import Carrier, FrameSource, sources_of
from end_effector_hal.description import Description, ToolChanger, measures_of
from end_effector_hal.signals import Frame, Value
from end_effector_hal.vocabulary import to_us


@dataclass(frozen=True, slots=True)
class JudgedReadings:
    """What the sensors read at one time.

    Attributes:
        at: the time, µs.
        values: gauge Pa or a bit, by channel; None: invalid, doubted, stale, or never read.
        sampled: the channels that the newest frame has read; empty: a reading turned stale, without a frame.
    """

    at: int
    values: Mapping[str, Value]
    sampled: tuple[str, ...] = ()


class Readings:
    """Values by channel; a stale or invalid value is absent, and the last value is never used instead.

    A reading is stale after 150 ms or three periods of its source, and the source is down after 1 s or seven periods,
    whichever is longer, unless the link declares other values.

    Args:
        description: the tool.
        carrier: carries its channels.
    """

    MEMORY: ClassVar = {
        "_values": dict[str, int | bool],
        "read_at": dict[str, int],
        "_invalid": dict[str, int],
        "_heard": dict[str, int],
        "last_frame": int,
        "arrived": frozenset[str],
    }

    def __init__(self, description: Description, carrier: Carrier) -> None:
        self.carried = carrier.channels
        self.measures = measures_of(description)
        """Display format of each channel."""
        self._sources = sources_of(carrier)
        fresh = [description.freshness_of(source.link) for source in self._sources]
        spans = [
            max(to_us(each.stale_s), each.stale_periods * source.period_us)
            for each, source in zip(fresh, self._sources, strict=True)
        ]
        self._stale_us = {
            channel: span
            for source, span in zip(self._sources, spans, strict=True)
            for channel in source.channels
        }
        self.stale_us = max(spans)
        """Time after which a reading of the slowest source is stale, µs."""
        self._least_stale_us = min(self._stale_us.values(), default=0)
        # a link and inputs without names are down together, by the slower of them
        self._down_us = [
            max(
                to_us(each.down_s),
                each.down_periods * (source.period_us if source.link else carrier.period_us),
            )
            for each, source in zip(fresh, self._sources, strict=True)
        ]
        self.down_us = max(self._down_us)
        """Time after which the slowest source is down, µs."""
        self._values: dict[str, int | bool] = {}
        self.read_at: dict[str, int] = {}
        """Time of the last reading by channel, µs; a new object whenever one of these times has changed."""
        self._numbers = {
            channel: str(number) for number, source in enumerate(self._sources) for channel in source.channels
        }
        # input lines that the line arbiter reads come by another way than those of this process
        self._names = {
            channel: f"{number} relay" if channel in description.arbiter_inputs else number
            for channel, number in self._numbers.items()
        }
        own = {name for name, each in description.channels.items() if each.on_board}
        self._on_board = tuple([bool(source.channels) and source.channels <= own for source in self._sources])
        self._invalid: dict[str, int] = {}
        """Time of the last frame with an invalid value, by channels that have had no valid value since."""
        self._heard: dict[str, int] = {}
        """Time of the last frame, by the numbers of several sources."""
        self.fresh: Mapping[str, int | bool] = {}
        """The values at the time that is judged; `look` finds them again before each sample."""
        self.last_frame = -self.down_us
        """Latest stamp of a frame, µs; before the first one it lies so far in the past that all sources are down."""
        self.arrived: frozenset[str] = frozenset()
        """The channels of which the newest frame has a valid value: only that is a sample."""
        self._ends: tuple[dict[str, int] | None, list[int]] = None, []
        """Cache: the reading times it belongs to, and the sorted times at which a reading or source ends."""

    def take(self, frame: Frame, doubted: Collection[str] = ()) -> None:
        """Store the values of a frame; an invalid value refreshes nothing.

        Args:
            frame: the frame after its judgement.
            doubted: channels whose value was sent but is not trusted; they are invalid in the frame.
        """
        self.last_frame = max(frame.at, self.last_frame)
        if len(self._sources) > 1 and (number := self._numbers.get(next(iter(frame.values), ""))):
            self._heard = {**self._heard, number: frame.at}
        valid: Mapping[str, Any] = frame.values
        if None in valid.values():
            valid = {channel: value for channel, value in valid.items() if value is not None}
        self._values = {**self._values, **valid}
        self.read_at = {**self.read_at, **dict.fromkeys(valid, frame.at)}  # another one: so `_ends` are new
        self.arrived = frozenset(valid)
        if self._invalid or len(valid) < len(frame.values):
            before = {name: at for name, at in self._invalid.items() if name not in frame.values}
            now = [name for name in frame.values if name not in valid and name not in doubted]
            self._invalid = before | dict.fromkeys(now, frame.at)

    def renew(self, at: int) -> None:
        """Account for frames equal to the newest one that came until ``at`` µs."""
        self.last_frame = at
        self.read_at = self.read_at | dict.fromkeys(self.arrived, at)
        self._invalid = dict.fromkeys(self._invalid, at)

    def forget(self, channel: str) -> None:
        """Discard the reading of a channel."""
        if channel in self._values:
            self._values = {name: value for name, value in self._values.items() if name != channel}
            self.read_at = {name: at for name, at in self.read_at.items() if name != channel}

    def look(self, at: int) -> None:
        """Determine the fresh values at ``at`` µs."""
        self.fresh = self._values
        if at - min(self.read_at.values(), default=at) >= self._least_stale_us:
            self.fresh = {name: value for name in self._values if (value := self.get(name, at)) is not None}

    def idle(self) -> None:
        """Mark that time has passed without a frame: the stored values are no new samples."""
        self.arrived = frozenset()

    def get(self, channel: str | None, at: int) -> int | bool | None:
        """Return the value of a channel at a time in µs; None: not carried, never read, or stale."""
        if channel is None or (then := self.read_at.get(channel)) is None:
            return None
        # without another call: each frame is asked for a dozen of them
        return self._values[channel] if at - then < self._stale_us.get(channel, self.stale_us) else None

    def judged(self, now: int) -> JudgedReadings:
        """Return the readings at the time of the newest frame, or at ``now`` µs if time has passed since."""
        at = self.last_frame if self.arrived else now
        values = {name: None if self.sent_invalid(name, at) else self.get(name, at) for name in self.carried}
        return JudgedReadings(at, values, tuple(sorted(self.arrived)))

    def sent_invalid(self, channel: str, at: int) -> bool:
        """Return whether frames with the channel arrive, but without a valid value: its device works."""
        then = self._invalid.get(channel)
        return then is not None and at - then < self.stale_after_us(channel)

    def stale_after_us(self, channel: str) -> int:
        """Return the time for which a reading of a channel is valid, µs."""
        return self._stale_us.get(channel, self.stale_us)

    def origin(self, frame: Frame) -> tuple[str, int]:
        """Return the source of a frame, by its channels, and how long the values of the frame are valid, µs.

        The stamps of one source must be in order. The values of several sources are valid for the shortest time.
        """
        stale_us, source = self.stale_us, self._names.get(next(iter(frame.values), ""), "")
        if len(self._sources) > 1:
            stale_us = min([self.stale_after_us(channel) for channel in frame.values], default=stale_us)
        return source, stale_us

    def stale(self, at: int) -> tuple[str, ...]:
        """Return the carried channels without a valid reading now."""
        read_at, spans = self.read_at, self._stale_us
        if len(read_at) == len(spans) and at - min(read_at.values(), default=at) < self._least_stale_us:
            return ()
        return tuple(
            [
                channel
                for channel in self.carried
                if channel not in read_at or at - read_at[channel] >= spans[channel]
            ]
        )

    def link_up(self, at: int) -> bool:
        """Return whether every source has sent a frame within the time after which it is down.

        If there are several sources, the inputs of the board are also down while none of them can be read.
        """
        return not self.down(at)

    def down(self, at: int) -> tuple[FrameSource, ...]:
        """Return the sources that are not up."""
        if at - self.last_frame >= self.down_us:
            return self._sources
        if len(self._sources) == 1:
            return ()
        seen = zip(self._sources, self._last_of_sources(), self._down_us, strict=True)
        return tuple([source for source, last, down_us in seen if at - last >= down_us])

    def deadline(self, at: int) -> int | None:
        """Return when the next reading turns stale or a source goes down without a new frame, µs."""
        of, ends = self._ends
        if of is not self.read_at:
            spans = self._stale_us
            found = {then + spans.get(channel, self.stale_us) for channel, then in self.read_at.items()}
            found.add(self.last_frame + self.down_us)
            if len(self._sources) > 1:
                found |= {last + us for last, us in zip(self._last_of_sources(), self._down_us, strict=True)}
            ends = sorted(found)
            self._ends = self.read_at, ends
        for end in ends:
            if end > at:
                return end
        return None

    def _last_of_sources(self) -> list[int]:
        """Return the time of the last frame of each link, and of the last valid value of the board, µs.

        Before the first one the time lies far in the past.

        A frame of a link was sent by a device, even if its values are invalid; a frame of the board is made in this
        process.
        """
        last = []
        for number, source in enumerate(self._sources):
            gone = -self._down_us[number]
            if self._on_board[number]:
                read_at = [self.read_at[name] for name in source.channels if name in self.read_at]
                last.append(max(read_at, default=gone))
            else:
                last.append(self._heard.get(str(number), gone))
        return last


class ToolPlace(IntEnum):
    """Place of the tool; ``ToolStandPosition`` of the ROS messages."""

    UNKNOWN = 0
    """A bit is stale, invalid, or not carried."""
    IN_STAND = 1
    AWAY = 2
    """On the tool changer, and not in its stand: an unlock would drop it."""
    ABSENT = 3
    """The tool changer carries no tool."""


def tool_place(changer: ToolChanger, values: Mapping[str, Value]) -> ToolPlace:
    """Return the place of the tool, as far as the readings prove it."""
    present, in_stand = values.get(changer.present_bit), values.get(changer.stand_bit)
    if present is not None and not present:
        return ToolPlace.ABSENT
    if in_stand is None or (present is None and changer.present_bit in values):
        return ToolPlace.UNKNOWN
    return ToolPlace.IN_STAND if in_stand else ToolPlace.AWAY
