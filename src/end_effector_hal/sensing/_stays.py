"""Find out whether coming frames change nothing, so that a simulation may leave them out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from end_effector_hal.signals import Frame, Value, clone, lengthen, streaks_of

from ._sensor_state import SensorState


def stays(
    state: SensorState,
    newest: Frame,
    corners: Sequence[Mapping[str, Value]],
    first: int,
    period: int,
    samples: int,
) -> bool:
    """Return whether coming frames will change nothing that the newest one has shown; the state does not change.

    Two conditions are checked. First, a frame of each corner proves the same as the newest frame, and starts or stops
    no count of a detector, so that their order does not matter. Second, after this number of samples and this time
    nothing else is proven; with constant values no detector returns to an earlier state.

    Args:
        state: the state after the newest frame.
        newest: that frame.
        corners: values of a frame; the coming values lie between them.
        first: time of the first frame, µs.
        period: time from one frame to the next, µs.
        samples: number of frames.
    """
    if state.is_guarded:  # a detector is somebody else's, who may count by himself
        return False
    last, state = first + (samples - 1) * period, clone(state)
    now, streaks = state.verdict(newest.at), list(streaks_of(state))
    counts = [streak.samples > 0 for streak in streaks]

    def ends_alike(at: int, values: Mapping[str, Value]) -> bool:
        for _ in state.take(Frame(at, None, None, values)):
            if state.verdict(at) != now or [streak.samples > 0 for streak in streaks] != counts:
                return False
        return True

    values: Mapping[str, Value] = newest.values
    for values in corners:
        if not ends_alike(first, values):
            return False
    lengthen(streaks, samples)
    return ends_alike(last, values)
