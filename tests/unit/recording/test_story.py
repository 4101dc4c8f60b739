"""The story is a fold of the events."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from end_effector_hal.control import COMMANDS, EventKind
from end_effector_hal.recording import (
    AttemptOutcome,
    EventRow,
    EventsWriter,
    GripDecision,
    ReleaseCause,
    RunInfo,
    StatesLog,
    StatesRow,
    read_states,
    read_story,
)
from end_effector_hal.vocabulary import Cause, Command, EndEffectorState
from tests.support.nightly import examples
from tests.support.trace_recordings import (
    CANCELLED,
    DROP,
    FAILS_ONCE,
    GRIP,
    GRIPPED,
    INFO,
    LATE,
    NAMES,
    NEVER,
    NOMINAL,
    log,
)


def attempts(story):
    return [(a.actuator, a.number, a.outcome, a.length_s) for a in story.attempts]


def moments(story):
    return [(moment.time_s, moment.text) for moment in story.moments]


def told(*events, end=6, info=None):
    """The story of some events, which ends in a state."""
    return read_story(log((0.0, 6, -1, 0, 0, 0), (99.0, end, -1, 0, 0, 0), events=events), info)


def test_the_nominal_scenario():
    story = read_story(NOMINAL)
    assert story.verdict == "Nominal: GRIPPED, then dropped"
    assert attempts(story) == [(name, 1, AttemptOutcome.CONFIRMED, 0.5) for name in NAMES]
    assert moments(story) == [(1.0, "GRIP"), (2.5, "GRIPPED"), (11.0, "DROP")]
    (grip,) = story.grips
    assert (grip.start_s, grip.decided_s, grip.decision, grip.culprit) == (
        1.0, 2.5, GripDecision.GRIPPED, None,
    )  # fmt: skip
    (release,) = story.releases
    assert (release.cause, release.start_s, release.end_s) == (ReleaseCause.DROP, 11.0, 12.0)
    assert release.deactivated == ("top_vacuum", "cylinder", "bottom_vacuum")
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


def test_a_recording_without_events_says_so():
    story = read_story(replace(NOMINAL, events=None), INFO)
    assert story.verdict == "No events were recorded, so grips are not known, ends in STAND_BY"
    assert (story.grips, story.releases, story.moments) == ((), (), ())


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
    story = told(
        *GRIP,
        (1.75, "empty cylinder 1"),
        (2.75, "began cylinder 2"),
        (3.0, "empty cylinder 2; GRIPPING>GRIP_ERROR EMPTY cylinder; GRIP_ERROR>RELEASING; off cylinder"),
        (4.0, "RELEASING>STAND_BY"),
    )
    assert [attempt.outcome for attempt in story.attempts[1:]] == [AttemptOutcome.EMPTY] * 2
    assert [round(reset.length_s, 6) for reset in story.resets] == [1.0]
    assert story.verdict == "Cylinder gripped nothing: grip ABORTED after 2 attempts, released"
    assert (3.0, "Cylinder empty 2 – abort") in moments(story)


def test_one_never_confirms():
    story = read_story(NEVER, INFO)
    assert (
        story.verdict == "Cylinder never confirmed: grip ABORTED after 3 attempts, released in reverse order"
    )
    assert attempts(story)[1:] == [("cylinder", n, AttemptOutcome.TIMED_OUT, 5.0) for n in (1, 2, 3)]
    assert [attempt.of for attempt in story.timeouts] == [3, 3, 3]
    assert [reset.length_s for reset in story.resets] == [1.0, 1.0]
    (grip,) = story.grips
    assert (grip.decision, grip.decided_s, grip.culprit) == (GripDecision.ABORTED, 18.5, "cylinder")
    assert story.releases[0].cause is ReleaseCause.ABORT
    assert story.releases[0].deactivated == ("cylinder", "bottom_vacuum")
    assert moments(story) == [
        (1.0, "GRIP"),
        (6.5, "Cylinder time-out 1/3"),
        (12.5, "Cylinder time-out 2/3"),
        (18.5, "Cylinder time-out 3/3 – abort"),
    ]


def test_attempts_without_a_reset_between_them_have_none():
    story = told(*GRIP, (6.5, "late cylinder 1; began cylinder 2"))
    assert [(each.number, each.outcome) for each in story.attempts[1:]] == [
        (1, AttemptOutcome.TIMED_OUT),
        (2, AttemptOutcome.PENDING),
    ]
    assert story.resets == ()


def test_an_earlier_step_lost_while_a_later_one_is_pending_is_no_time_out():
    story = told(
        *GRIP, *LATE,
        (8.5, "lost bottom_vacuum; GRIPPING>GRIP_ERROR LOST bottom_vacuum; GRIP_ERROR>RELEASING; off cylinder"),
        (9.0, "off bottom_vacuum"), (9.5, "RELEASING>STAND_BY"),
    )  # fmt: skip
    assert story.verdict == "Grip ABORTED while Cylinder was pending, released in reverse order"
    assert [a[2] for a in attempts(story)[1:]] == [AttemptOutcome.TIMED_OUT, AttemptOutcome.DEACTIVATED]
    assert moments(story)[-1] == (8.5, "abort")


def test_a_loss_during_a_reset_is_not_the_time_out_before_it():
    story = told(
        *GRIP, LATE[0],
        (7.0, "lost bottom_vacuum; GRIPPING>GRIP_ERROR LOST bottom_vacuum; GRIP_ERROR>RELEASING; off bottom_vacuum"),
        (7.5, "RELEASING>STAND_BY"),
    )  # fmt: skip
    assert story.verdict == "Grip ABORTED, released"
    assert story.grips[0].culprit is None


def test_an_activation_that_is_refused_aborts_without_a_time_out():
    refused = "GRIPPING>GRIP_ERROR REFUSED cylinder; off cylinder; GRIP_ERROR>RELEASING; off bottom_vacuum"
    story = told(*GRIP, (1.6, refused), (2.0, "RELEASING>STAND_BY"))
    assert story.verdict == "Grip ABORTED while Cylinder was pending, released in reverse order"
    assert story.timeouts == ()


def test_a_cancelled_grip():
    story = read_story(CANCELLED)
    assert story.verdict == "Grip CANCELLED while Cylinder was pending, released in reverse order"
    assert attempts(story)[1] == ("cylinder", 1, AttemptOutcome.DEACTIVATED, 0.75)
    assert moments(story) == [(1.0, "GRIP"), (2.25, "CANCEL")]
    assert story.timeouts == ()
    assert story.releases[0].cause is ReleaseCause.CANCEL


def test_what_an_ending_leaves_active_ends_the_unwinding_and_a_drop_is_another_one():
    cancelled = [
        *GRIP,
        (3.0, "cancel; GRIPPING>RELEASING CANCELLED; off cylinder"),
        (3.2, "RELEASING>GRIP_ERROR KEPT"),
    ]
    story = told(*cancelled, end=2)
    assert story.verdict == "Grip CANCELLED while Cylinder was pending, partly released: GRIP_ERROR"
    dropped = [(5.0, "drop; GRIP_ERROR>RELEASING; off bottom_vacuum"), (6.0, "RELEASING>STAND_BY")]
    assert [(each.cause, each.ended) for each in told(*cancelled, *dropped).releases] == [
        (ReleaseCause.CANCEL, EndEffectorState.GRIP_ERROR),
        (ReleaseCause.DROP, EndEffectorState.STAND_BY),
    ]
    held = [*GRIP, (3.0, "cancel; GRIPPING>GRIP_ERROR CANCELLED")]
    story = told(*held, end=2)
    assert story.verdict == "Grip CANCELLED while Cylinder was pending, outputs held"
    assert (story.releases, story.final) == ((), EndEffectorState.GRIP_ERROR)
    assert told(*held, *dropped).verdict == f"{story.verdict}, then dropped"
    aborted = told(*GRIP, (4.5, "late cylinder 1; GRIPPING>GRIP_ERROR TIMED_OUT cylinder"), *dropped)
    assert aborted.verdict == (
        "Cylinder never confirmed: grip ABORTED after 1 attempt, outputs held, then dropped"
    )


def test_a_grip_that_is_lost_says_by_whom():
    lost = (6.0, "lost top_vacuum; GRIPPED>GRIP_ERROR LOST top_vacuum")
    story = told(*GRIPPED, lost, end=2)
    assert story.verdict == "GRIPPED, then Top vacuum LOST: outputs held"
    assert [(loss.time_s, loss.actuator) for loss in story.losses] == [(6.0, "top_vacuum")]
    assert moments(story)[-1] == (6.0, "grip lost: Top vacuum")
    assert told(*GRIPPED, lost, *DROP).verdict == f"{story.verdict}, then dropped"
    resumed = told(*GRIPPED, lost, (7.0, "resume; GRIP_ERROR>GRIPPED"), end=3)
    assert resumed.verdict == f"{story.verdict}, then resumed"
    assert (moments(resumed)[-1], resumed.losses) == ((7.0, "RESUME"), story.losses)
    refused = told(*GRIPPED, (6.0, "GRIPPED>GRIP_ERROR REFUSED"), end=2)
    assert refused.verdict == "GRIPPED, then LOST: outputs held"
    assert moments(refused)[-1] == (6.0, "grip lost")


def test_what_is_released_because_of_a_loss_is_no_drop():
    lost = "lost cylinder; GRIPPED>GRIP_ERROR LOST cylinder; GRIP_ERROR>RELEASING; off top_vacuum"
    story = told(*GRIPPED, (6.0, lost), (6.5, "off cylinder"), (7.0, "RELEASING>GRIP_ERROR KEPT"), end=2)
    assert story.verdict == "GRIPPED, then Cylinder LOST, partly released: GRIP_ERROR"
    assert [release.cause for release in story.releases] == [ReleaseCause.LOSS]


def test_what_is_released_at_the_start_is_no_drop():
    start = [(0.1, "OFF>RELEASING RELEASED_AT_START; off cylinder"), (0.5, "RELEASING>STAND_BY")]
    (release,) = told(*start).releases
    assert (release.cause, release.deactivated) == (ReleaseCause.START, ("cylinder",))
    stopped = told(*GRIP, (1.6, "GRIPPING>OFF"), (1.7, "OFF>RELEASING RELEASED_AT_START"))
    assert stopped.verdict == "Grip STOPPED while Cylinder was pending, still releasing at the end"


def test_a_release_that_fails_and_the_drop_that_succeeds():
    failed = [*GRIPPED, *DROP[:3], (13.75, "RELEASING>RELEASE_ERROR STILL_PRESENT")]
    story = told(*failed, end=5)
    assert story.verdict == "GRIPPED, then release failed: RELEASE_ERROR"
    assert moments(story)[-1] == (13.75, "release error")
    story = told(*failed, (20.0, "drop; RELEASE_ERROR>RELEASING"), (20.5, "RELEASING>STAND_BY"))
    assert story.verdict == "GRIPPED, then release failed: RELEASE_ERROR, then dropped"
    assert [release.ended for release in story.releases] == [
        EndEffectorState.RELEASE_ERROR,
        EndEffectorState.STAND_BY,
    ]


def test_another_order_of_release_is_told():
    story = told(
        *GRIPPED, (11.0, "drop; GRIPPED>RELEASING; off bottom_vacuum"), (11.5, "off cylinder"),
        (11.7, "off top_vacuum"), DROP[-1],
    )  # fmt: skip
    assert not story.releases[0].in_reverse(NAMES)
    assert story.verdict == "Nominal: GRIPPED, then dropped in the order Bottom vacuum, Cylinder, Top vacuum"


def test_several_grips():
    events = [
        replace(event, time_s=start + event.time_s)
        for start, recording in ((0.0, NOMINAL), (20.0, NEVER), (40.0, FAILS_ONCE))
        for event in recording.events
    ]
    story = read_story(replace(NOMINAL, events=tuple(events)), INFO)
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
    ("rows", "events", "verdict"),
    [
        ([], [], "Nothing was recorded"),
        ([(0, 6, -1, 0, 0, 0)], [], "No grip, stays in STAND_BY"),
        (
            [(0, 6, 1, 0, 0, 0), (1, 6, -1, 0, 0, 0)],
            [(0, "unlock"), (2, "lock"), (3, "lock")],
            "UNLOCK, LOCK: no grip, ends in STAND_BY",
        ),
        ([(0, 0, -1, 0, 0, 0), (0, 3, -1, 2, 2, 2)], [(0, "OFF>GRIPPED")], "Adopted as GRIPPED"),
        ([(0, 3, -1, 2, 2, 2)], [], "Adopted as GRIPPED"),
        (
            [(0, 2, -1, 2, 0, 0), (2, 6, -1, 0, 0, 0)],
            [(1, "drop; GRIP_ERROR>RELEASING; off bottom_vacuum"), (2, "RELEASING>STAND_BY")],
            "Adopted as GRIP_ERROR, then dropped",
        ),
        ([(0, 1, 2, 2, 1, 0)], [(0, "began cylinder 2")], "Grip UNFINISHED: Cylinder still pending at the end"),
        ([(0, 1, 2, 2, 1, 0)], [(0, "late cylinder 2"), (1, "GRIPPING>GRIPPED")], "Nominal: GRIPPED"),
        (
            [(0, 1, 2, 2, 1, 0)],
            [(1, "late cylinder 2; GRIPPING>GRIP_ERROR TIMED_OUT cylinder")],
            "Grip ABORTED, outputs held",
        ),
    ],
)  # fmt: skip
def test_other_recordings(rows, events, verdict):
    assert read_story(log(*rows, events=events)).verdict == verdict


def test_rows_of_grips_whose_events_were_removed_are_no_grip():
    """Old segments are removed of each table for itself."""
    rows = ((1.0, 1, 2, 1, 0, 0), (2.0, 5, 2, 1, 0, 0), (3.0, 6, -1, 0, 0, 0), (50.0, 1, 2, 1, 0, 0))
    events = [(50.0, "STAND_BY>GRIPPING; began bottom_vacuum 1"), (51.0, "GRIPPING>GRIPPED")]
    (grip,) = read_story(log(*rows, events=events)).grips
    assert (grip.start_s, grip.decided_s, grip.decision) == (50.0, 51.0, GripDecision.GRIPPED)


def test_events_from_before_the_first_state_are_told_in_their_order():
    events = [(0.2, "OFF>STAND_BY"), (1.0, "STAND_BY>GRIPPING"), (2.0, "GRIPPING>GRIPPED")]
    (grip,) = read_story(log((1.6, 1, 2, 1, 0, 0), (2.0, 3, -1, 2, 2, 2), events=events)).grips
    assert (grip.start_s, grip.decided_s) == (1.0, 2.0)


def test_a_grip_whose_end_is_not_recorded_is_not_the_next_one():
    found = told((1.0, "STAND_BY>GRIPPING"), (9.0, "STAND_BY>GRIPPING"), (10.0, "GRIPPING>GRIPPED")).grips
    assert [(grip.start_s, grip.decided_s, grip.decision) for grip in found] == [
        (1.0, 9.0, GripDecision.STOPPED),
        (9.0, 10.0, GripDecision.GRIPPED),
    ]


def test_a_recording_that_begins_in_a_grip_begins_with_it():
    events = [(0.5, "confirmed bottom_vacuum 1"), (2.0, "GRIPPING>GRIPPED")]
    (grip,) = read_story(log((0.0, 1, 2, 1, 0, 0), (2.0, 3, -1, 2, 2, 2), events=events)).grips
    assert (grip.start_s, grip.decided_s) == (0.0, 2.0)


def test_names_come_from_the_columns():
    events = [
        (0, "began left_needle_cup 1"),
        (5, "late left_needle_cup 1; GRIPPING>GRIP_ERROR TIMED_OUT left_needle_cup"),
    ]
    story = read_story(log((0, 1, 2, 1), (6, 2, -1, 0), names=["left_needle_cup"], events=events))
    assert story.verdict == "Left needle cup never confirmed: grip ABORTED after 1 attempt, outputs held"


def test_time_outs_of_several_actuators_are_named():
    story = told(
        (1, "grip; STAND_BY>GRIPPING; began bottom_vacuum 1"), (6, "late bottom_vacuum 1"),
        (7, "began bottom_vacuum 2"), (8, "confirmed bottom_vacuum 2; began cylinder 1"), (13, "late cylinder 1"),
    )  # fmt: skip
    assert [m.text for m in story.moments][1:] == ["Bottom vacuum time-out 1", "Cylinder time-out 1"]
    assert [grip.decision for grip in story.grips] == [GripDecision.UNFINISHED]


def test_it_needs_nothing_but_the_tables(tmp_path):
    path = tmp_path / "states.csv"
    lines = [
        ",".join(NEVER.columns),
        *(",".join(map(str, (r.time_s, *map(int, r.states)))) for r in NEVER.rows),
    ]
    path.write_text("\n".join(lines) + "\n")
    with EventsWriter(tmp_path / "events.csv", NAMES) as writer:
        writer.write(NEVER.events)
    assert read_story(read_states(path)) == read_story(NEVER)


STATES = st.sampled_from(EndEffectorState)
EVENTS = st.lists(
    st.one_of(
        st.builds(
            EventRow, st.integers(0, 50), st.just(EventKind.STATE_CHANGED), st.sampled_from(("", *NAMES)),
            old=STATES, new=STATES, cause=st.sampled_from(Cause),
        ),
        st.builds(
            EventRow, st.integers(0, 50),
            st.sampled_from([each for each in EventKind if "changed" not in each]), st.sampled_from(("", *NAMES)),
            st.integers(0, 20), command=st.sampled_from(("", *COMMANDS)),
        ),
    ),
    max_size=30,
)  # fmt: skip


@settings(max_examples=examples(50, 3000))
@given(st.lists(STATES, max_size=2), EVENTS, st.booleans())
def test_any_recording_has_a_story(states, events, informed):
    rows = tuple(StatesRow(at, state, Command.NONE, (0, 0, 0)) for at, state in enumerate(states))
    ordered = tuple(sorted(events, key=lambda event: event.time_s))
    story = read_story(StatesLog(NAMES, rows, events=ordered), INFO if informed else RunInfo())
    assert story.verdict
    assert list(story.moments) == sorted(story.moments, key=lambda moment: moment.time_s)
    for grip in story.grips:
        for attempt in grip.attempts:
            assert (attempt.end_s is None) == (attempt.outcome is AttemptOutcome.PENDING)
            assert attempt.length_s is None or attempt.length_s >= 0
            assert attempt.outcome is not AttemptOutcome.PENDING or grip.decision is GripDecision.UNFINISHED
