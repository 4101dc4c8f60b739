"""What `eehal run` says: paced, timed on a terminal, and a result only after the states that led to it."""

from __future__ import annotations

import json
import threading
from dataclasses import replace

import pytest

from end_effector_hal.cli.run._voices import SCENARIO, Changes, JsonLines, Words, status_lines
from end_effector_hal.control import Answer, EventKind, Status, StepReport, ToolEvent
from end_effector_hal.control.goals import Outcome
from end_effector_hal.description import Description
from end_effector_hal.nodes.process import BURST
from end_effector_hal.runtime import Refused, Result
from end_effector_hal.vocabulary import WEAK, Alarm, Command, EndEffectorState, received_alarms
from tests.support.virtual_tool import VirtualTool


class Screen:
    def __init__(self) -> None:
        self.lines: list[tuple[str, bool]] = []

    def __call__(self, text: str, *, err: bool = False) -> None:
        self.lines.append((text, err))

    @property
    def out(self) -> list[str]:
        return [text for text, err in self.lines if not err]


@pytest.fixture
def screen() -> Screen:
    return Screen()


def test_a_flood_is_cut_and_counted_and_an_alarm_gets_through(
    screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [0.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr("end_effector_hal.nodes.process.Allowance.__init__.__defaults__", (lambda: now[0],))
    words = Words(screen)
    for _ in range(500):
        words.event(0, "a line")
    assert len(screen.out) == BURST
    words.alarm(0, *received_alarms(["It burns."]), over=False)
    assert screen.lines[-1] == ("alarm: It burns.", False)
    now[0] += 1.0
    words.event(0, "later")
    assert screen.out[-2:] == [
        f"{500 - BURST} lines were left out: there were more than 5 a second.",
        "later",
    ]


def test_words_for_each_end_of_a_command(screen: Screen) -> None:
    words, state = Words(screen), EndEffectorState.STAND_BY
    for result in (
        Result(Outcome.SUCCEEDED, state, seconds=1.5),
        Result(Outcome.CANCELLED, state, "The grip was cancelled.", seconds=1.5),
        Result(Outcome.FAILED, state, "Why.", seconds=1.5),
        Result(Outcome.UNREACHABLE, state, "This process is ending.", seconds=1.5),
        Refused(Outcome.REJECTED, state, "Not now."),
        Refused(Outcome.UNREACHABLE, state, "The line arbiter is lost."),
    ):
        words.result(Command.GRIP, result)
    assert screen.out == [
        "GRIP: succeeded",
        "GRIP: cancelled. The grip was cancelled.",
        "GRIP: failed. Why.",
        "GRIP: outcome unknown. This process is ending.",
        "refused: grip. Not now.",
        "unreachable: grip. The line arbiter is lost.",
    ]


def test_on_a_terminal_a_line_has_its_time_and_a_grip_the_times_of_its_steps(screen: Screen) -> None:
    words = Words(screen, timed=True, begun=1_000_000)
    words.event(3_250_000, "STAND_BY -> GRIPPING (GRIP)")
    steps = (
        StepReport("bottom_vacuum", 1, 0.4, True),
        StepReport("cylinder", 2, 6.5, True),
        StepReport("top"),
    )
    words.result(Command.GRIP, Result(Outcome.SUCCEEDED, EndEffectorState.GRIPPED, "", steps, 7.0))
    assert screen.out[0] == "    2.250 s  STAND_BY -> GRIPPING (GRIP)"
    assert "GRIP: succeeded after 7.00 s. Bottom vacuum 0.40 s; Cylinder 6.50 s, attempt 2." in screen.out[1]


def test_json_says_the_outcome_and_the_time(capsys: pytest.CaptureFixture[str]) -> None:
    JsonLines(0).result(Command.GRIP, Refused(Outcome.REJECTED, EndEffectorState.GRIPPED, "Not now."))
    told = json.loads(capsys.readouterr().out)
    assert (told["schema_version"], told["event"], told["outcome"], told["reason"]) == (
        1, "result", "REJECTED", "Not now.",
    )  # fmt: skip
    assert told["at_s"] > 0


def entered(before: Status, at: int, state: EndEffectorState) -> Status:
    """A status of another state, with the event of the change."""
    event = ToolEvent(at, EventKind.STATE_CHANGED, old=before.ee, new=state)
    return replace(before, at=at, ee=state, events=(event,), count=before.count + 1)


def test_a_transition_is_one_line_and_a_change_of_an_actuator_another(
    verdin: Description, screen: Screen
) -> None:
    tool, changes = VirtualTool(verdin, "nominal"), Changes(verdin, Words(screen))
    tool.play(1.0, "grip", 5.0)
    for status in tool.statuses:
        changes.status(status)
    assert screen.out[:5] == [
        "OFF: Bottom vacuum OFF, Cylinder RETRACTED, Top vacuum OFF",
        "OFF -> STAND_BY",
        "tool changer: UNKNOWN -> LOCKED",
        "STAND_BY -> GRIPPING (GRIP)",
        "GRIPPING: Bottom vacuum PENDING ON, Cylinder RETRACTED, Top vacuum OFF",
    ]
    assert screen.out[-1] == "GRIPPING -> GRIPPED"


def test_a_state_that_changes_without_an_event_is_one_line(verdin: Description, screen: Screen) -> None:
    """A HAL that is back begins with the state that it has adopted."""
    status, changes = VirtualTool(verdin, "nominal").status, Changes(verdin, Words(screen))
    changes.begin(status)
    changes.status(replace(status, ee=EndEffectorState.GRIPPED))
    assert screen.out == ["GRIPPED: Bottom vacuum OFF, Cylinder RETRACTED, Top vacuum OFF"]


def test_what_is_waited_for_is_told_before(verdin: Description, screen: Screen) -> None:
    tool, changes = VirtualTool(verdin, "nominal"), Changes(verdin, Words(screen))
    status = entered(tool.status, 5_000, EndEffectorState.STAND_BY)
    threading.Timer(0.1, changes.status, [status]).start()
    changes.catch_up(status)
    assert "OFF -> STAND_BY" in screen.out


def test_nothing_is_waited_for_that_was_told_before_an_older_state(
    verdin: Description, screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A status about a listener has the present time and the number of the status that it repeats."""
    monkeypatch.setattr("end_effector_hal.cli.run._voices.CAUGHT_UP_S", 60.0)
    tool, changes = VirtualTool(verdin, "nominal"), Changes(verdin, Words(screen))
    for at in (5_000, 4_000):
        changes.status(replace(tool.status, at=at, count=7))
    returns_at_once(changes, replace(tool.status, at=5_000, count=7))


def test_the_status_that_changes_begin_with_is_not_waited_for(
    verdin: Description, screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`eehal do` connects, and its first command may be refused, which publishes no status."""
    monkeypatch.setattr("end_effector_hal.cli.run._voices.CAUGHT_UP_S", 60.0)
    tool, changes = VirtualTool(verdin, "nominal"), Changes(verdin, Words(screen))
    status = replace(tool.status, begun=1_000, count=7)
    changes.begin(status)
    returns_at_once(changes, status)


def returns_at_once(changes: Changes, status: Status) -> None:
    waiting = threading.Thread(target=changes.catch_up, args=(status,), daemon=True)
    waiting.start()
    waiting.join(10.0)
    assert not waiting.is_alive()


def test_a_result_waits_for_the_last_of_several_states_of_one_time(
    verdin: Description, screen: Screen
) -> None:
    """A reaction has several statuses at the same microsecond: its first one is not its last one."""
    tool, changes = VirtualTool(verdin, "nominal"), Changes(verdin, Words(screen))
    gripping = entered(tool.status, 5_000, EndEffectorState.GRIPPING)
    gripped = entered(gripping, 5_000, EndEffectorState.GRIPPED)
    changes.status(gripping)
    threading.Timer(0.1, changes.status, [gripped]).start()
    changes.catch_up(gripped)
    assert screen.out[-1] == "GRIPPING -> GRIPPED"


def test_no_line_has_a_time_before_that_of_the_line_above(
    verdin: Description, capsys: pytest.CaptureFixture[str]
) -> None:
    tool = VirtualTool(verdin)
    changes = Changes(verdin, JsonLines(0))
    for at, ee in ((5_000, EndEffectorState.GRIPPING), (4_000, EndEffectorState.GRIPPED)):
        changes.status(entered(tool.status, at, ee))
    times = [json.loads(line)["at_s"] for line in capsys.readouterr().out.splitlines()]
    assert len(times) >= 4
    assert times == sorted(times)


@pytest.mark.parametrize("as_json", [False, True])
def test_a_reader_who_has_gone_worries_nobody(as_json: bool, verdin: Description) -> None:
    """As behind `| head -1`, or a terminal that was closed: the tool goes on, and no listener of it has failed."""

    def broken(*_: object, **__: object) -> None:
        raise BrokenPipeError

    voice = JsonLines(write=broken) if as_json else Words(broken)
    tool = VirtualTool(verdin)
    Changes(verdin, voice).status(tool.status)
    voice.alarm(0, DOWN, over=False)
    voice.help("A text.")


def test_an_alarm_is_told_where_nobody_reads_the_rest(screen: Screen) -> None:
    """Behind `| head -1`, or with a file on a disk that is full."""

    def half_broken(text: str, *, err: bool = False) -> None:
        if not err:
            raise BrokenPipeError
        screen(text, err=err)

    words = Words(half_broken)
    words.event(0, "GRIPPED")
    words.alarm(0, *received_alarms(["It burns."]), over=False)
    words.ending("What is held stays held.")
    assert screen.lines == [("alarm: It burns.", True), ("What is held stays held.", True)]


WEAK_CUPS = Alarm(WEAK, "cups", {"kpa": 52.0, "least_kpa": 60.0}, 0)
SECURE_AGAIN = Alarm(WEAK, "cups", {"kpa": 62.0}, 0, over=True)
WEAK_TEXT = "Weak grip: Cups fell to 52.0 kPa; minimum for a secure grip: 60 kPa."
AGAIN_TEXT = "Cups was not secure for a while; it is again (62 kPa)."
DOWN = Alarm("link.down", "", {"sensors": "sensor link is down"}, 0)


def alarmed(changes: Changes, *rounds: tuple[Alarm, ...]) -> None:
    status = VirtualTool(changes._description).status
    for at, alarms in enumerate(rounds):
        changes.status(replace(status, at=at, alarms=alarms))


def test_what_is_over_is_said_once_and_not_as_an_alarm(verdin: Description, screen: Screen) -> None:
    changes = Changes(verdin, Words(screen))
    alarmed(changes, (), (DOWN, WEAK_CUPS), (SECURE_AGAIN,), ())
    assert [text for text in screen.out if text.startswith(("alarm: ", "over: "))] == [
        "alarm: The sensor link is down.",
        f"alarm: {WEAK_TEXT}",
        "over: The sensor link is down.",
        f"over: {AGAIN_TEXT}",
    ]
    (line,) = (
        each
        for each in status_lines(verdin, replace(VirtualTool(verdin).status, alarms=(SECURE_AGAIN,)))
        if "secure" in each
    )
    assert line.startswith("over: Cups was")


def test_json_has_the_identity_of_each_alarm(verdin: Description, capsys: pytest.CaptureFixture[str]) -> None:
    alarmed(Changes(verdin, JsonLines(0)), (), (WEAK_CUPS,), (SECURE_AGAIN,), ())
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    common = {"schema_version": 1, "event": "alarm", "id": WEAK, "about": "cups", "severity": "warning"}
    assert [each for each in told if each["event"] == "alarm"] == [
        {**common, "at_s": 1e-6, "text": WEAK_TEXT, "over": False},
        {**common, "at_s": 2e-6, "text": AGAIN_TEXT, "over": True},
    ]


def test_a_scenario_is_said_by_its_name(verdin: Description, screen: Screen) -> None:
    Words(screen).answer(SCENARIO, Answer(True, "leak:cups"))
    assert screen.out == ["scenario: leak:cups"]
