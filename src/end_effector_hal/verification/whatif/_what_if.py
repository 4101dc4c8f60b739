"""A recorded run and what another description would have made of it, side by side."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from end_effector_hal.description import Description, measures_of
from end_effector_hal.recording import (
    KPA,
    Grip,
    PressuresLog,
    SwitchesLog,
    pressure_channels,
    switch_channels,
)
from end_effector_hal.runtime.boundary import FrameTaken
from end_effector_hal.verification.replay import Entry

from ._changed import changes
from ._other_run import OtherRun
from ._run_story import RunStory, StoryLine
from ._spans import ApartSpan

SHIFT_S = 0.5
"""The same sentence this much earlier or later is the same event; farther apart, it is two."""
MOST_SAMPLES = 20_000
SAMPLE_S = 0.02


class LinePair(NamedTuple):
    """What happened in both runs, or in one of them: seconds since the recording began; None: it did not."""

    text: str
    recorded_s: float | None
    other_s: float | None

    @property
    def same(self) -> bool:
        """Whether it happened in both at the same µs."""
        return self.recorded_s == self.other_s

    @property
    def time_s(self) -> float:
        """Of the first of the two."""
        return min(at for at in (self.recorded_s, self.other_s) if at is not None)


class GripPair(NamedTuple):
    """A grip of both runs, or of one of them.

    Attributes:
        recorded, other: None: there was none.
        guess_s: seconds since the recording began, from when on the other one is a guess; None: it is none.
    """

    recorded: Grip | None
    other: Grip | None
    guess_s: float | None


@dataclass(frozen=True)
class WhatIf:
    """Both stories and where they part.

    Attributes:
        begin: µs, time zero of all seconds in it.
        end_s: when the recording ends.
        recorded, other: the stories.
        spans: from when to when the other one is a guess.
        pressures, switches: what both controllers read.
        notes: in words: what could not be played.
    """

    begin: int
    end_s: float
    recorded: RunStory
    other: RunStory
    spans: tuple[ApartSpan, ...]
    pressures: PressuresLog
    switches: SwitchesLog
    notes: tuple[str, ...]

    @property
    def lines(self) -> tuple[LinePair, ...]:
        """What happened, in order of time."""
        return tuple(paired_lines(self.recorded.lines, self.other.lines))

    @property
    def grips(self) -> tuple[GripPair, ...]:
        """The grips of both, in order of time."""
        return tuple(self._grips())

    @property
    def same(self) -> bool:
        """Whether both stories are the same to the µs."""
        return all(line.same for line in self.lines) and self.recorded.rows == self.other.rows

    def seconds(self, at: int) -> float:
        """µs on the monotonic clock as seconds since the recording began."""
        return (at - self.begin) / 1e6

    def guess(self, since_s: float, until_s: float | None) -> float | None:
        """From when on the other story is a guess within that time; None: it is none."""
        since, until = self._us(since_s), None if until_s is None else self._us(until_s)
        found = next((span for span in self.spans if span.overlaps(since, until)), None)
        return None if found is None else max(since_s, self.seconds(found.since))

    def as_json(self) -> dict[str, Any]:
        """For programs; times in seconds since the recording began."""
        return {
            "same": self.same,
            "changes": list(changes(self.recorded.description, self.other.description)),
            "recorded": self._side(self.recorded),
            "other": self._side(self.other),
            "apart": [
                {
                    "since_s": round(self.seconds(span.since), 6),
                    "until_s": None if span.until is None else round(self.seconds(span.until), 6),
                    "why": span.why,
                }
                for span in self.spans
            ],
            "grips": [
                {
                    "recorded": each.recorded and asdict(each.recorded),
                    "other": each.other and asdict(each.other),
                    "guess_s": each.guess_s,
                }
                for each in self.grips
            ],
            "lines": [
                {"text": each.text, "recorded_s": each.recorded_s, "other_s": each.other_s}
                for each in self.lines
            ],
            "notes": list(self.notes),
        }

    def _side(self, side: RunStory) -> dict[str, Any]:
        story = side.story
        return {
            "description": side.description.name,
            "hash": side.info.hash,
            "verdict": story.verdict,
            "final": story.final.name if story.final is not None else None,
            "alarms": [asdict(row) for row in side.alarms],
            "lines_left_out": side.left_out,
        }

    def _us(self, at_s: float) -> int:
        return self.begin + round(at_s * 1e6)

    def _grips(self) -> Iterator[GripPair]:
        """Those that begin with the same command belong together."""
        recorded, other = list(self.recorded.story.grips), list(self.other.story.grips)
        while recorded or other:
            if recorded and other and abs(recorded[0].start_s - other[0].start_s) <= SHIFT_S:
                ours, theirs = recorded.pop(0), other.pop(0)
                yield GripPair(ours, theirs, self.guess(theirs.start_s, theirs.decided_s))
            elif not other or (recorded and recorded[0].start_s < other[0].start_s):
                ours = recorded.pop(0)
                yield GripPair(ours, None, self.guess(ours.start_s, ours.decided_s))
            else:
                theirs = other.pop(0)
                yield GripPair(None, theirs, self.guess(theirs.start_s, theirs.decided_s))


def what_if(entries: Iterable[Entry], recorded: Description, other: Description) -> WhatIf:
    """Play a recorded run with another description.

    Args:
        entries: of the recorded run, both programs in the order of time.
        recorded: the tool that was recorded.
        other: the tool that it is played with.

    Raises:
        ModelError: the other automata cannot be executed.
    """
    run = OtherRun(other, recorded)
    both = _Both(recorded, other)
    for entry in run.play(both.watched(entries)):
        both.theirs.take(entry)
    return WhatIf(
        both.begin,
        max(0.0, (both.end - both.begin) / 1e6),
        both.ours,
        both.theirs,
        tuple(run.spans),
        both.pressures(),
        SwitchesLog(both.bits, tuple(both.levels)),
        tuple(run.notes),
    )


class _Both:
    """The recorded story is read on the way to the other controller."""

    def __init__(self, recorded: Description, other: Description) -> None:
        self._tools = recorded, other
        self.begin = self.end = 0
        self.ours = self.theirs = RunStory(recorded, 0)
        self._channels = tuple(dict.fromkeys((*pressure_channels(recorded), *pressure_channels(other))))
        self._samples: list[tuple[float, tuple[float | None, ...]]] = []
        self._kpa: dict[str, float | None] = {}
        self._step_s = SAMPLE_S
        self.bits = tuple(dict.fromkeys((*switch_channels(recorded), *switch_channels(other))))
        self.levels: list[tuple[float, tuple[bool | None, ...]]] = []
        """Of the bits, whenever one of them has changed; at most `MOST_SAMPLES`."""
        self._bits: dict[str, bool | None] = {}

    def watched(self, entries: Iterable[Entry]) -> Iterator[Entry]:
        for number, entry in enumerate(entries):
            if not number:
                self.begin = entry.at
                self.ours, self.theirs = (RunStory(tool, entry.at) for tool in self._tools)
            self.end = max(self.end, entry.at)
            self.ours.take(entry)
            if entry.kind == "frame" and entry.program == "grip":
                self._sample(entry.record)
            yield entry

    def _sample(self, frame: FrameTaken) -> None:
        at_s = (frame.stamp - self.begin) / 1e6
        self._kpa |= {
            name: None if value is None else value / 1000
            for name, value in frame.values.items()
            if name in self._channels
        }
        self._bits |= {
            name: None if value is None else bool(value)
            for name, value in frame.values.items()
            if name in self.bits
        }
        levels = tuple(self._bits.get(name) for name in self.bits)
        if (not self.levels or self.levels[-1][1] != levels) and len(self.levels) < MOST_SAMPLES:
            self.levels.append((at_s, levels))
        if self._samples and at_s - self._samples[-1][0] < self._step_s * 0.9:
            return
        self._samples.append((at_s, tuple(self._kpa.get(name) for name in self._channels)))
        if len(self._samples) > MOST_SAMPLES:  # a figure has some thousand points in its width
            self._samples, self._step_s = self._samples[::2], self._step_s * 2

    def pressures(self) -> PressuresLog:
        measures = {name: each for tool in self._tools for name, each in measures_of(tool).items()}
        units = {name: measures[name].unit for name in self._channels if measures[name].unit != KPA}
        return PressuresLog(self._channels, tuple(self._samples), units=units)


def paired_lines(recorded: Sequence[StoryLine], other: Sequence[StoryLine]) -> Iterator[LinePair]:
    """The lines of two runs in order of time; those that say the same at about the same time are one.

    Two runs on the same inputs have one clock, so that a line is looked for near its time only. Recordings of two
    grips have none in common: `compare_runs` aligns what they say, whenever.
    """
    found: list[tuple[float, int, LinePair]] = []
    waiting: dict[str, deque[tuple[int, StoryLine]]] = {}
    for number, line in enumerate(other):
        waiting.setdefault(line.text, deque()).append((number, line))

    def put(number: int, text: str, recorded_s: float | None, other_s: float | None) -> None:
        pair = LinePair(text, recorded_s, other_s)
        found.append((pair.time_s, number, pair))

    for number, line in enumerate(recorded):
        same = waiting.get(line.text, deque())
        while same and same[0][1].time_s < line.time_s - SHIFT_S:
            place, early = same.popleft()
            put(place, early.text, None, early.time_s)
        if same and same[0][1].time_s <= line.time_s + SHIFT_S:
            put(number, line.text, line.time_s, same.popleft()[1].time_s)
        else:
            put(number, line.text, line.time_s, None)
    for rest in waiting.values():
        for place, line in rest:
            put(place, line.text, None, line.time_s)
    yield from (pair for _, _, pair in sorted(found, key=lambda each: each[:2]))
