"""A frame is judged once in a process, however many look at it."""

from __future__ import annotations

from typing import NamedTuple

from end_effector_hal.signals import Frame, same_memory

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
    own, too. The next frame leads them together again, once their states are equal: after a silence of the link not
    before what the programs then began to count anew has ended. So nobody waits for anybody, and each decides as if it
    were alone: as a replay of its recording does.

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


def _alike(ones: tuple[SensorState, ...], others: tuple[SensorState, ...]) -> bool:
    return len(ones) == len(others) and all(map(same_memory, ones, others))
