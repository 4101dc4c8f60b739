"""Recordings to test with: (time_s, end_effector, command, actuators...), and their events."""

from dataclasses import replace
from pathlib import Path

from end_effector_hal.control import COMMANDS, EventKind
from end_effector_hal.recording import (
    EventRow,
    EventsWriter,
    PressuresLog,
    RunInfo,
    StatesLog,
    StatesRow,
    StatesWriter,
)
from end_effector_hal.vocabulary import Cause, Command, EndEffectorState

NAMES = ("bottom_vacuum", "cylinder", "top_vacuum")
_KINDS = {
    "began": EventKind.ATTEMPT_BEGAN,
    "confirmed": EventKind.CONFIRMED,
    "late": EventKind.TIMED_OUT,
    "empty": EventKind.CLOSED_ON_NOTHING,
    "off": EventKind.DEACTIVATED,
    "lost": EventKind.LOST,
}


def log(*rows, names=NAMES, events=()):
    return StatesLog(
        tuple(names),
        tuple(StatesRow(t, EndEffectorState(e), Command(c), tuple(values)) for t, e, c, *values in rows),
        events=tuple(each for at, text in events for each in events_of(at, text)),
    )


def moved(recording, move):
    """A recording with other times."""
    rows, events = (
        tuple(replace(each, time_s=move(each.time_s)) for each in part)
        for part in (recording.rows, recording.events)
    )
    return replace(recording, rows=rows, events=events)


def events_of(at, text):
    """``grip; STAND_BY>GRIPPING; began cylinder 1; GRIPPING>GRIP_ERROR TIMED_OUT cylinder; off cylinder``."""
    for words in (each.split() for each in text.split(";")):
        what, who, more = (*words, "", "")[:3]
        if what in COMMANDS:
            yield EventRow(at, EventKind.COMMAND_ACCEPTED, command=what)
        elif ">" in what:
            old, new = (int(EndEffectorState[name]) for name in what.split(">"))
            yield EventRow(at, EventKind.STATE_CHANGED, more, 0, old, new, Cause[who or "NONE"])
        else:
            yield EventRow(at, _KINDS[what], who, int(more or 0))


_GRIP = [(0.0, 6, -1, 0, 0, 0), (1.0, 1, 2, 1, 0, 0), (1.5, 1, 2, 2, 1, 0)]
_DROP = [(11.0, 4, 3, 2, 2, 0), (11.25, 4, 3, 2, 0, 0), (11.75, 4, 3, 0, 0, 0), (12.0, 6, -1, 0, 0, 0)]
GRIP = [
    (1.0, "grip; STAND_BY>GRIPPING; began bottom_vacuum 1"),
    (1.5, "confirmed bottom_vacuum 1; began cylinder 1"),
]
GRIPPED = [
    *GRIP,
    (2.0, "confirmed cylinder 1; began top_vacuum 1"),
    (2.5, "confirmed top_vacuum 1; GRIPPING>GRIPPED"),
]
DROP = [
    (11.0, "drop; GRIPPED>RELEASING; off top_vacuum"),
    (11.25, "off cylinder"),
    (11.75, "off bottom_vacuum"),
    (12.0, "RELEASING>STAND_BY"),
]
LATE = [(6.5, "late cylinder 1"), (7.5, "began cylinder 2")]
TWICE_LATE = [*LATE, (12.5, "late cylinder 2"), (13.5, "began cylinder 3")]

NOMINAL = log(*_GRIP, (2.0, 1, 2, 2, 2, 1), (2.5, 3, -1, 2, 2, 2), *_DROP, events=[*GRIPPED, *DROP])
FAILS_ONCE = log(
    *_GRIP, (6.5, 1, 2, 2, 0, 0), (7.5, 1, 2, 2, 1, 0), (8.25, 1, 2, 2, 2, 1), (8.75, 3, -1, 2, 2, 2), *_DROP,
    events=[
        *GRIP, *LATE, (8.25, "confirmed cylinder 2; began top_vacuum 1"),
        (8.75, "confirmed top_vacuum 1; GRIPPING>GRIPPED"), *DROP,
    ],
)  # fmt: skip
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
    events=[
        *GRIP, *TWICE_LATE,
        (18.5, "late cylinder 3; GRIPPING>GRIP_ERROR TIMED_OUT cylinder; GRIP_ERROR>RELEASING; off cylinder"),
        (18.75, "off bottom_vacuum"), (19.0, "RELEASING>STAND_BY"),
    ],
)  # fmt: skip
CANCELLED = log(
    *_GRIP, (2.25, 4, 4, 2, 0, 0), (2.5, 4, 4, 0, 0, 0), (3.0, 6, -1, 0, 0, 0),
    events=[
        *GRIP, (2.25, "cancel; GRIPPING>RELEASING CANCELLED; off cylinder"), (2.5, "off bottom_vacuum"),
        (3.0, "RELEASING>STAND_BY"),
    ],
)  # fmt: skip

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


def written(folder: Path, states: StatesLog, info: RunInfo = INFO) -> Path:
    """A folder that is made, with the states, the events and the facts of a recording."""
    folder.mkdir(parents=True)
    with StatesWriter(folder / "states.csv", states.actuators) as writer:
        for row in states.rows:
            writer.write(row.time_s, row.end_effector, row.command, row.actuators)
    with EventsWriter(folder / "events.csv", states.actuators) as table:
        table.write(states.events or ())
    info.write(folder)
    return folder
