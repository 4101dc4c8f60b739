"""Recordings to test with: (time_s, end_effector, command, actuators...)."""

from end_effector_hal.recording import PressuresLog, RunInfo, StatesLog, StatesRow
from end_effector_hal.vocabulary import Command, EndEffectorState

NAMES = ("bottom_vacuum", "cylinder", "top_vacuum")


def log(*rows, names=NAMES):
    return StatesLog(
        tuple(names),
        tuple(StatesRow(t, EndEffectorState(e), Command(c), tuple(values)) for t, e, c, *values in rows),
    )


_GRIP = [(0.0, 6, -1, 0, 0, 0), (1.0, 1, 2, 1, 0, 0), (1.5, 1, 2, 2, 1, 0)]
_DROP = [(11.0, 4, 3, 2, 2, 0), (11.25, 4, 3, 2, 0, 0), (11.75, 4, 3, 0, 0, 0), (12.0, 6, -1, 0, 0, 0)]

NOMINAL = log(*_GRIP, (2.0, 1, 2, 2, 2, 1), (2.5, 3, -1, 2, 2, 2), *_DROP)
FAILS_ONCE = log(
    *_GRIP, (6.5, 1, 2, 2, 0, 0), (7.5, 1, 2, 2, 1, 0), (8.25, 1, 2, 2, 2, 1), (8.75, 3, -1, 2, 2, 2), *_DROP
)
NEVER = log(
    *_GRIP,
    (6.5, 1, 2, 2, 0, 0),
    (7.5, 1, 2, 2, 1, 0),
    (12.5, 1, 2, 2, 0, 0),
    (13.5, 1, 2, 2, 1, 0),
    (18.5, 2, 3, 2, 1, 0),
    (18.5, 4, 3, 2, 0, 0),
    (18.75, 4, 3, 0, 0, 0),
    (19.0, 6, -1, 0, 0, 0),
)
CANCELLED = log(*_GRIP, (2.25, 4, 4, 2, 0, 0), (2.5, 4, 4, 0, 0, 0), (3.0, 6, -1, 0, 0, 0))

INFO = RunInfo(
    scenario="never-confirms:cylinder",
    description="verdin_gripper",
    hash="3f9c1a2b77aa",
    version="0.1.0",
    ros=True,
    started="2026-03-04T10:20:30+00:00",
    actuators={"bottom_vacuum": "vacuum", "cylinder": "cylinder", "top_vacuum": "vacuum"},
    limits={
        "bottom_vacuum": {"channel": "bottom", "kind": "vacuum", "confirmed_kpa": 55.0, "attempts": 3},
        "cylinder": {"channel": "cylinder", "kind": "cylinder", "confirmed_kpa": 510.0, "attempts": 3},
        "top_vacuum": {"channel": "top", "kind": "vacuum", "confirmed_kpa": 55.0, "attempts": 3},
    },
)

PRESSURES = PressuresLog(
    ("bottom", "cylinder", "top", "supply"),
    (
        (0.0, (0.0, 0.0, 0.0, 600.0)),
        (0.5, (0.0, 0.0, 0.0, 600.0)),
        (1.0, (0.0, 0.0, None, 600.0)),
        (1.5, (-60.0, 0.0, 0.0, 598.0)),
        (2.0, (-78.0, 100.0, 0.0, 597.0)),
        (19.5, (-2.0, 0.0, 0.0, 600.0)),
    ),
)
