"""Judges every frame only once per process, however many objects need the result."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from end_effector_hal.signals import Frame, Value, clone, lengthen, same_memory, streaks_of
from end_effector_hal.vocabulary import Evidence

from ._sensor_state import SensorState


class _Judged(NamedTuple):
    """A frame, the state before it, and the states that it led to."""

    before: SensorState
    frame: Frame
    states: tuple[SensorState, ...]


class FrameJudge:
    """Stores the result of the newest frame: the same frame leads from the same state to the same result.

    The users of one judge have the same state as long as they receive the same frames. Between two frames a user also
    looks at the sensors at its own deadlines, and that result is its own. The next frame gives users with equal states
    one state again: after a silence of the link at once; if only one of them has refused a frame for its age, when the
    counts since then have ended. So no user waits for another, and each decides as if it were alone, as a replay of
    its recording does.

    Thread-safe. All users of one judge have the same description and codec.
    """

    def __init__(self) -> None:
        self._newest: tuple[_Judged, ...] = ()

    def after(self, state: SensorState, frame: Frame) -> tuple[SensorState, ...]:
        """Return the states after a frame, as `SensorState.after` does."""
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
        """Whether the newest frame has proven that no actuator grips anything."""
        return all(
            level is Evidence.GONE
            for judged in self._newest
            for state in judged.states
            for level in state.evidence
        )

    def pass_over(self, samples: int, at: int | None = None) -> None:
        """Account for frames that `stays` allowed to leave out, as if their samples had been counted.

        Args:
            samples: number of these frames.
            at: time of the last one, µs: the present evidence is as fresh as that. None: a frame that counts follows.
        """
        for judged in self._newest:
            lengthen(streaks_of(judged.states[-1]), samples)
            if at is not None:
                judged.states[-1].readings.renew(at)

    def stays(self, corners: Sequence[Mapping[str, Value]], first: int, period: int, samples: int) -> bool:
        """Return whether coming frames will change nothing that the newest one has shown.

        This call does not change the state.

        Two conditions are checked. First, a frame of each corner proves the same as the newest frame, and starts or
        stops no count of a detector, so that their order does not matter. Second, after this number of samples and
        this time nothing else is proven; with constant values no detector returns to an earlier state.

        Args:
            corners: values of a frame; the coming values lie between them.
            first: time of the first frame, µs.
            period: time from one frame to the next, µs.
            samples: number of frames.
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
