"""A frame is judged once in a process, however many look at it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from end_effector_hal.signals import Frame, Value, clone, lengthen, same_memory, streaks_of
from end_effector_hal.vocabulary import Evidence

from ._sensor_state import SensorState


class _Judged(NamedTuple):
    """What a frame has led to."""

    before: SensorState
    frame: Frame
    states: tuple[SensorState, ...]


class FrameJudge:
    """Remembers what the newest frame has led to: from the same state it leads to the same.

    Those who share one are in the same state as long as all of them see the same frames. Between two frames each of
    them also looks at the sensors when something is due for itself, and so at times of its own; what that shows is its
    own, too. The next frame leads them together again, once their states are equal: after a silence of the link at
    once; where one has refused a frame for its age and another has not, when what they count since then has ended. So
    nobody waits for anybody, and each decides as if it were alone: as a replay of its recording does.

    Thread-safe. All who share one have the same description and codec.
    """

    def __init__(self) -> None:
        self._newest: tuple[_Judged, ...] = ()

    def after(self, state: SensorState, frame: Frame) -> tuple[SensorState, ...]:
        """What `SensorState.after` returns."""
        newest = self._newest
        if not newest or newest[0].frame is not frame:
            states = state.after(frame)
            if not newest or newest[0].frame.at <= frame.at:
                self._newest = (_Judged(state, frame, states),)
            return states
        for judged in newest:
            if judged.before is state:
                return judged.states
        states = state.after(frame)
        for judged in newest:
            if _alike(states, judged.states):
                return judged.states
        self._newest = (*newest, _Judged(state, frame, states))
        return states

    @property
    def released(self) -> bool:
        """Whether the newest frame has proven that nothing is gripped by any actuator."""
        return all(
            level is Evidence.GONE
            for judged in self._newest
            for state in judged.states
            for level in state.evidence
        )

    def pass_over(self, samples: int, at: int | None = None) -> None:
        """So many frames as in `stays` have come and were left out: what counts samples counts them.

        Args:
            samples: how many.
            at: µs of the last of them; what the sensors prove is as fresh as that. None: a frame that counts follows.
        """
        for judged in self._newest:
            lengthen(streaks_of(judged.states[-1]), samples)
            if at is not None:
                judged.states[-1].readings.renew(at)

    def stays(self, corners: Sequence[Mapping[str, Value]], first: int, period: int, samples: int) -> bool:
        """Whether frames that are yet to come leave all as it is that the newest one has shown; nothing is changed.

        Two things are asked. A frame of each corner proves what the newest one does, and has no detector begin or cease
        to count: so no order of them does. After so many samples, and so long, nothing else is proven: fed with the
        same, no detector comes back to what it left.

        Args:
            corners: values of a frame; those that come lie between them.
            first: µs of the first of the frames, and ``period`` from one to the next.
            samples: how many there are.
        """
        last = first + (samples - 1) * period
        # one for all, or some who have not yet counted as much as the others
        return bool(self._newest) and all(
            _stays(judged, corners, first, last, samples) for judged in self._newest
        )


def _stays(
    judged: _Judged, corners: Iterable[Mapping[str, Value]], first: int, last: int, samples: int
) -> bool:
    if judged.states[-1].is_guarded:  # a detector is somebody else's, who may count by himself
        return False
    frame, state = judged.frame, clone(judged.states[-1])
    now, streaks = state.verdict(frame.at), list(streaks_of(state))
    counts = [streak.samples > 0 for streak in streaks]

    def ends_alike(at: int, values: Mapping[str, Value]) -> bool:
        for _ in state.take(Frame(at, None, None, values)):
            if state.verdict(at) != now or [streak.samples > 0 for streak in streaks] != counts:
                return False
        return True

    values: Mapping[str, Value] = frame.values
    for values in corners:
        if not ends_alike(first, values):
            return False
    lengthen(streaks, samples)
    return ends_alike(last, values)


def _alike(ones: tuple[SensorState, ...], others: tuple[SensorState, ...]) -> bool:
    return len(ones) == len(others) and all(map(same_memory, ones, others))
