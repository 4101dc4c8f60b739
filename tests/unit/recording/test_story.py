"""The story is read from the states alone."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from end_effector_hal.recording import (
    AlarmRow,
    AttemptOutcome,
    GripDecision,
    ReleaseCause,
    RunInfo,
    StatesLog,
    StatesRow,
    read_states,
    read_story,
)
from end_effector_hal.vocabulary import Command, EndEffectorState
from tests.support.nightly import examples
from tests.support.trace_recordings import CANCELLED, FAILS_ONCE, INFO, NAMES, NEVER, NOMINAL, log


def attempts(story):
    return [(a.actuator, a.number, a.outcome, a.length_s) for a in story.attempts]


def moments(story):
    return [(moment.time_s, moment.text) for moment in story.moments]


def test_the_nominal_scenario():
    story = read_story(NOMINAL)
    assert story.verdict == "Nominal: GRIPPED, then dropped"
    assert attempts(story) == [(name, 1, AttemptOutcome.CONFIRMED, 0.5) for name in NAMES]
    assert moments(story) == [(1.0, "GRIP"), (2.5, "GRIPPED"), (11.0, "DROP")]
    (grip,) = story.grips
    assert (grip.start_s, grip.decided_s, grip.decision, grip.culprit) == (
        1.0,
        2.5,
        GripDecision.GRIPPED,
        None,
    )
    (release,) = story.releases
    assert (release.cause, release.start_s, release.end_s) == (ReleaseCause.DROP, 11.0, 12.0)
    assert release.deactivated == (("top_vacuum",), ("cylinder",), ("bottom_vacuum",))
    assert release.in_reverse(NAMES)
    assert (release.ended, story.final) == (EndEffectorState.STAND_BY, EndEffectorState.STAND_BY)


def test_one_fails_once_and_recovers():
    story = read_story(FAILS_ONCE)
    assert story.verdict == "Cylinder confirmed on attempt 2: GRIPPED, then dropped"
    assert attempts(story) == [
        ("bottom_vacuum", 1, AttemptOutcome.CONFIRMED, 0.5),
        ("cylinder", 1, AttemptOutcome.TIMED_OUT, 5.0),
        ("cylinder", 2, AttemptOutcome.CONFIRMED, 0.75),
        ("top_vacuum", 1, AttemptOutcome.CONFIRMED, 0.5),
    ]
    assert [(reset.actuator, reset.start_s, reset.length_s) for reset in story.resets] == [
        ("cylinder", 6.5, 1.0)
    ]
    assert story.grips[0].attempts_by_actuator == {"bottom_vacuum": 1, "cylinder": 2, "top_vacuum": 1}
    assert moments(story)[1] == (6.5, "Cylinder time-out 1")


def test_a_counterexample_is_no_success():
    info = replace(INFO, violated="A grip takes 1 s.", violated_s=1.5)
    story, nominal = read_story(NOMINAL, info), read_story(NOMINAL)
    assert story.verdict == "VIOLATED at 1.5 s: A grip takes 1 s."
    kinds = [moment.kind for moment in nominal.moments]
    assert "gripped" in kinds
    assert "gripped" not in [moment.kind for moment in story.moments]
    assert [(moment.time_s, moment.text) for moment in story.moments if moment.kind == "lost"] == [
        (1.5, "VIOLATED")
    ]
    assert len(story.moments) == len(nominal.moments) + 1


def test_what_goes_wrong_as_a_counterexample_ends_shares_its_mark():
    at_s = next(moment.time_s for moment in read_story(NEVER, INFO).moments if "abort" in moment.text)
    story = read_story(NEVER, replace(INFO, violated="It succeeds.", violated_s=at_s))
    told = [(moment.kind, moment.text) for moment in story.moments if moment.time_s == at_s]
    assert told == [("lost", "Cylinder time-out 3/3 – abort – VIOLATED")]


def test_how_many_attempts_there_are_comes_from_the_run():
    story = read_story(FAILS_ONCE, INFO)
    assert moments(story)[1] == (6.5, "Cylinder time-out 1/3")
    assert str(story.attempts[1]) == "Cylinder, attempt 1 of 3: timed out after 5.00 s"


def test_what_gripped_nothing_did_not_time_out():
    state, grip = EndEffectorState, Command.GRIP
    rows = [(0.0, state.STAND_BY, Command.NONE, 0)]
    for at in (1.0, 2.2, 3.4):
        rows += [(at, state.GRIPPING, grip, 1), (at + 0.2, state.GRIPPING, grip, 0)]
    rows[-1] = (3.6, state.GRIP_ERROR, Command.RELEASE, 1)
    rows += [(3.6, state.RELEASING, Command.RELEASE, 0), (3.8, state.STAND_BY, Command.NONE, 0)]
    states = StatesLog(("jaw",), tuple(StatesRow(at, ee, command, (jaw,)) for at, ee, command, jaw in rows))
    info = RunInfo(actuators={"jaw": "gripper"}, limits={"jaw": {"attempts": 3}})
    alarms = [AlarmRow(at + 0.2, "begun", "Jaw closed on nothing.") for at in (1.0, 2.2, 3.4)]
    story = read_story(states, info, alarms)
    assert [attempt.outcome for attempt in story.attempts] == [AttemptOutcome.EMPTY] * 3
    assert [round(reset.length_s, 6) for reset in story.resets] == [1.0, 1.0]
    assert story.verdict == "Jaw gripped nothing: grip ABORTED after 3 attempts, released"
    assert (3.6, "Jaw empty 3/3 – abort") in moments(story)
    foreign = RunInfo(actuators={"jaw": "of_somebody"}, limits={"jaw": {"attempts": 3}})
    assert read_story(states, foreign, alarms).grips[0].culprit == "jaw"


def test_one_never_confirms():
    story = read_story(NEVER)
    assert (
        story.verdict == "Cylinder never confirmed: grip ABORTED after 3 attempts, released in reverse order"
    )
    assert attempts(story)[1:] == [("cylinder", n, AttemptOutcome.TIMED_OUT, 5.0) for n in (1, 2, 3)]
    assert [attempt.of for attempt in story.timeouts] == [3, 3, 3]
    assert [reset.length_s for reset in story.resets] == [1.0, 1.0]
    (grip,) = story.grips
    assert (grip.decision, grip.decided_s, grip.culprit) == (GripDecision.ABORTED, 18.5, "cylinder")
    assert story.releases[0].cause is ReleaseCause.ABORT
    assert story.releases[0].deactivated == (("cylinder",), ("bottom_vacuum",))
    assert moments(story) == [
        (1.0, "GRIP"),
        (6.5, "Cylinder time-out 1/3"),
        (12.5, "Cylinder time-out 2/3"),
        (18.5, "Cylinder time-out 3/3 – abort"),
    ]


@pytest.mark.parametrize(
    "end",
    [
        # deactivated in the row of the error, before it, and after it
        [(18.5, 2, 3, 2, 0, 0), (18.5, 4, 3, 2, 0, 0)],
        [(18.5, 1, 2, 2, 0, 0), (18.5, 2, 3, 2, 0, 0), (18.5, 4, 3, 2, 0, 0)],
        [(18.5, 2, 2, 2, 1, 0), (18.5, 2, 3, 2, 1, 0), (18.51, 4, 3, 2, 0, 0)],
    ],
)
def test_the_last_time_out_is_found_however_the_rows_fall(end):
    rows = [(r.time_s, *r.states) for r in NEVER.rows]
    story = read_story(log(*rows[:7], *end, *rows[9:]))
    assert (
        story.verdict == "Cylinder never confirmed: grip ABORTED after 3 attempts, released in reverse order"
    )
    assert attempts(story)[1:] == [("cylinder", n, AttemptOutcome.TIMED_OUT, 5.0) for n in (1, 2, 3)]


def test_an_earlier_step_lost_while_a_later_one_is_pending_is_no_time_out():
    rows = [(r.time_s, *r.states) for r in NEVER.rows]
    story = read_story(
        log(
            *rows[:5], (8.5, 2, 3, 2, 1, 0), (8.5, 4, 3, 2, 0, 0), (9.0, 4, 3, 0, 0, 0), (9.5, 6, -1, 0, 0, 0)
        )
    )
    assert story.verdict == "Grip ABORTED while Cylinder was pending, released in reverse order"
    assert [a[2] for a in attempts(story)[1:]] == [AttemptOutcome.TIMED_OUT, AttemptOutcome.DEACTIVATED]
    assert moments(story)[-1] == (8.5, "abort")


def test_a_loss_before_the_last_attempt_is_known_from_the_run_even_without_an_earlier_time_out():
    rows = [(r.time_s, *r.states) for r in NOMINAL.rows[:3]]
    story = read_story(log(*rows, (4.0, 2, 3, 2, 1, 0), (4.0, 4, 3, 2, 0, 0), (5.0, 6, -1, 0, 0, 0)), INFO)
    assert story.verdict.startswith("Grip ABORTED while Cylinder was pending")


def test_a_loss_during_a_reset_is_not_the_time_out_before_it():
    rows = [(r.time_s, *r.states) for r in NEVER.rows[:4]]
    story = read_story(log(*rows, (7.0, 2, 3, 2, 0, 0), (7.0, 4, 3, 0, 0, 0), (7.5, 6, -1, 0, 0, 0)))
    assert story.verdict == "Grip ABORTED, released"
    assert story.grips[0].culprit is None


def test_a_cancelled_grip():
    story = read_story(CANCELLED)
    assert story.verdict == "Grip CANCELLED while Cylinder was pending, released in reverse order"
    assert attempts(story)[1] == ("cylinder", 1, AttemptOutcome.DEACTIVATED, 0.75)
    assert moments(story) == [(1.0, "GRIP"), (2.25, "CANCEL")]
    assert story.timeouts == ()
    assert story.releases[0].cause is ReleaseCause.CANCEL


def test_what_an_ending_leaves_active_ends_the_unwinding_and_a_drop_is_another_one():
    grip = [(0.0, 6, -1, 0, 0, 0), (1.0, 1, 2, 1, 0, 0), (1.5, 1, 2, 2, 0, 0), (1.5, 1, 2, 2, 1, 0)]
    cancelled = [*grip, (3.0, 4, 4, 2, 1, 0), (3.0, 4, 4, 2, 0, 0), (3.2, 2, -1, 2, 0, 0)]
    story = read_story(log(*cancelled))
    assert story.verdict == "Grip CANCELLED while Cylinder was pending, partly released: GRIP ERROR"
    dropped = [*cancelled, (5.0, 4, 3, 2, 0, 0), (5.0, 4, 3, 0, 0, 0), (6.0, 6, -1, 0, 0, 0)]
    releases = read_story(log(*dropped)).releases
    assert [(each.cause, each.ended) for each in releases] == [
        (ReleaseCause.CANCEL, EndEffectorState.GRIP_ERROR),
        (ReleaseCause.DROP, EndEffectorState.STAND_BY),
    ]
    held = read_story(log(*grip, (3.0, 2, 4, 2, 1, 0), (3.0, 2, -1, 2, 1, 0)))
    assert held.verdict == "Grip CANCELLED while Cylinder was pending, outputs held"


def test_a_cancel_that_holds_and_the_drop_after_it():
    rows = [(r.time_s, *r.states) for r in NOMINAL.rows[:3]]
    held = [*rows, (2.25, 2, -1, 2, 1, 0)]
    story = read_story(log(*held))
    assert story.verdict == "Grip CANCELLED while Cylinder was pending, outputs held"
    assert (story.releases, story.final) == ((), EndEffectorState.GRIP_ERROR)
    assert moments(story) == [(1.0, "GRIP"), (2.25, "CANCEL")]
    story = read_story(log(*held, (4.0, 4, 3, 2, 0, 0), (4.5, 4, 3, 0, 0, 0), (5.0, 6, -1, 0, 0, 0)))
    assert story.verdict == "Grip CANCELLED while Cylinder was pending, outputs held, then dropped"


def test_a_grip_that_is_lost():
    rows = [(r.time_s, *r.states) for r in NOMINAL.rows]
    story = read_story(log(*rows[:5], (6.0, 2, -1, 2, 2, 2)))
    assert story.verdict == "GRIPPED, then LOST: outputs held"
    assert story.lost_s == (6.0,)
    assert moments(story)[-1] == (6.0, "grip lost")
    assert read_story(log(*rows[:5], (6.0, 2, -1, 2, 2, 2), *rows[5:])).verdict == (
        "GRIPPED, then LOST: outputs held, then dropped"
    )


def test_a_grip_that_is_lost_says_by_whom():
    rows = [(r.time_s, *r.states) for r in NOMINAL.rows]
    story = read_story(log(*rows[:5], (6.0, 2, -1, 2, 2, 1)))
    assert story.verdict == "GRIPPED, then Top vacuum LOST: outputs held"
    assert [loss.actuators for loss in story.losses] == [("top_vacuum",)]
    assert moments(story)[-1] == (6.0, "grip lost: Top vacuum")


def test_a_release_that_fails_and_the_drop_that_succeeds():
    rows = [(r.time_s, *r.states) for r in NOMINAL.rows]
    failed = [*rows[:8], (13.75, 5, -1, 0, 0, 0)]
    story = read_story(log(*failed))
    assert story.verdict == "GRIPPED, then release failed: RELEASE ERROR"
    assert moments(story)[-1] == (13.75, "release error")
    story = read_story(log(*failed, (20.0, 4, 3, 0, 0, 0), (20.5, 6, -1, 0, 0, 0)))
    assert story.verdict == "GRIPPED, then release failed: RELEASE ERROR, then dropped"
    assert [release.ended for release in story.releases] == [
        EndEffectorState.RELEASE_ERROR,
        EndEffectorState.STAND_BY,
    ]


def test_another_order_of_release_is_told():
    rows = [(r.time_s, *r.states) for r in NOMINAL.rows[:5]]
    story = read_story(log(*rows, (11.0, 4, 3, 0, 2, 2), (11.5, 4, 3, 0, 0, 0), (12.0, 6, -1, 0, 0, 0)))
    assert story.releases[0].deactivated == (("bottom_vacuum",), ("cylinder", "top_vacuum"))
    assert not story.releases[0].in_reverse(NAMES)
    assert (
        story.verdict == "Nominal: GRIPPED, then dropped in the order Bottom vacuum, Cylinder and Top vacuum"
    )


def test_several_grips():
    rows, start = [], 0.0
    for recording in (NOMINAL, NEVER, FAILS_ONCE):
        rows += [(start + r.time_s, *r.states) for r in recording.rows]
        start += 20.0
    story = read_story(log(*rows))
    assert story.verdict == "3 grips: 2 GRIPPED, 1 ABORTED (Cylinder never confirmed)"
    assert [grip.decision for grip in story.grips] == [
        GripDecision.GRIPPED,
        GripDecision.ABORTED,
        GripDecision.GRIPPED,
    ]
    assert [attempt.of for attempt in story.timeouts] == [3, 3, 3, 3]
    assert [len(grip.attempts) for grip in story.grips] == [3, 4, 4]
    assert [release.cause for release in story.releases] == [
        ReleaseCause.DROP,
        ReleaseCause.ABORT,
        ReleaseCause.DROP,
    ]


@pytest.mark.parametrize(
    ("rows", "verdict"),
    [
        ([], "Nothing was recorded"),
        ([(0, 6, -1, 0, 0, 0)], "No grip, stays in STAND-BY"),
        (
            [(0, 6, 1, 0, 0, 0), (1, 6, -1, 0, 0, 0), (2, 6, 0, 0, 0, 0)],
            "UNLOCK, LOCK: no grip, ends in STAND-BY",
        ),
        ([(0, 0, -1, 0, 0, 0), (0, 3, -1, 2, 2, 2)], "Adopted as GRIPPED"),
        (
            [(0, 2, -1, 2, 0, 0), (1, 4, 3, 0, 0, 0), (2, 6, -1, 0, 0, 0)],
            "Adopted as GRIP ERROR, then dropped",
        ),
        ([(0, 1, 2, 2, 1, 0)], "Grip UNFINISHED: Cylinder still pending at the end"),
        (
            [(0, 1, 2, 1, 0, 0), (1, 4, 3, 0, 0, 0)],
            "Grip STOPPED while Bottom vacuum was pending, still releasing at the end",
        ),
        ([(0, 1, 2, 1, 0, 0), (1, 0, -1, 0, 0, 0)], "Grip STOPPED while Bottom vacuum was pending, released"),
        (
            [(0, 1, 2, 1, 0, 0), (5, 2, 3, 0, 0, 0), (5, 6, -1, 0, 0, 0)],
            "Bottom vacuum never confirmed: grip ABORTED after 1 attempt, released",
        ),
    ],
)
def test_other_recordings(rows, verdict):
    assert read_story(log(*rows)).verdict == verdict


def test_names_come_from_the_columns():
    story = read_story(log((0, 1, 2, 1), (1, 2, 3, 1), (1, 6, -1, 0), names=["left_needle_cup"]))
    assert story.verdict == "Left needle cup never confirmed: grip ABORTED after 1 attempt, released"


def test_time_outs_of_several_actuators_are_named():
    story = read_story(
        log(
            (0, 1, 2, 1, 0, 0),
            (5, 1, 2, 0, 0, 0),
            (6, 1, 2, 1, 0, 0),
            (7, 1, 2, 2, 1, 0),
            (12, 1, 2, 2, 0, 0),
        )
    )
    assert [m.text for m in story.moments][1:] == ["Bottom vacuum time-out 1", "Cylinder time-out 1"]


def test_it_needs_nothing_but_the_file(tmp_path):
    path = tmp_path / "states.csv"
    lines = [
        ",".join(NEVER.columns),
        *(",".join(map(str, (r.time_s, *map(int, r.states)))) for r in NEVER.rows),
    ]
    path.write_text("\n".join(lines) + "\n")
    assert read_story(read_states(path)) == read_story(NEVER)


ROWS = st.lists(
    st.tuples(
        st.integers(0, 50),
        st.sampled_from(EndEffectorState),
        st.sampled_from(Command),
        st.tuples(*[st.integers(0, 2)] * 3),
    ),
    max_size=30,
)


@settings(max_examples=examples(50, 3000))
@given(ROWS, st.booleans())
def test_any_recording_has_a_story(rows, informed):
    times = sorted(row[0] / 4 for row in rows)
    recording = StatesLog(NAMES, tuple(StatesRow(t, *row[1:]) for t, row in zip(times, rows, strict=True)))
    story = read_story(recording, INFO if informed else RunInfo())
    assert story.verdict
    assert list(story.moments) == sorted(story.moments, key=lambda moment: moment.time_s)
    for grip in story.grips:
        for name in NAMES:
            assert [attempt.number for attempt in grip.of(name)] == list(range(1, len(grip.of(name)) + 1))
        for attempt in grip.attempts:
            assert (attempt.end_s is None) == (attempt.outcome is AttemptOutcome.PENDING)
            assert attempt.length_s is None or attempt.length_s >= 0
            assert attempt.outcome is not AttemptOutcome.PENDING or grip.decision is GripDecision.UNFINISHED
