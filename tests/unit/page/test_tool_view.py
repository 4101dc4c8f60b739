"""What the page shows, in virtual time: the records of real controllers in, views out."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter
from pydantic_core import to_json

from end_effector_hal.codecs import carrier_of, load_tool, sources_of
from end_effector_hal.control import Status, load_automata
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import ReportedError
from end_effector_hal.nodes._hal_main import Aggregate
from end_effector_hal.page.view import ToolView
from end_effector_hal.page.view._tool_view import STALE_US
from end_effector_hal.runtime.boundary import STREAMED, Published, RecordedController, entry_of
from end_effector_hal.runtime.boundary._open import header_of
from end_effector_hal.runtime.stream import PUBLISHED
from end_effector_hal.signals import Frame
from end_effector_hal.verification.mutation import kept_record
from end_effector_hal.vocabulary import E_STOPPED, STOPPED, Alarm
from end_effector_hal.vocabulary import EndEffectorState as State
from tests.support.named_parts import gripper_with_parts
from tests.support.places import ROOT
from tests.support.virtual_tool import VirtualTool

UNTIL_RESET = "nothing is activated until the faults are reset"


def latched(why: str) -> dict[str, str]:
    return {"interlock": "IL-13", "why": why}


@cache
def adapter(kind: str) -> TypeAdapter[Any]:
    return TypeAdapter(STREAMED[kind])


class Watched:
    """A tool in virtual time with a page; each record goes through JSON, as on the socket."""

    def __init__(self, description: Description, scenario: str = "nominal") -> None:
        self.description = description
        self.view = ToolView(description, 0)
        self.views = [self.view]
        self.now, self.faults = 0, tuple[Alarm, ...]()
        self.send("header", 0, header_of(description, 0))

        def recorded(tool: Description, network: Any) -> RecordedController:
            return RecordedController(tool, network, lambda record: self.put(*entry_of(record)))

        self.tool = VirtualTool(description, scenario, controller=recorded)  # type: ignore[arg-type]

    def put(self, kind: str, at: int, content: object) -> None:
        self.send(kind, at, content)
        if isinstance(content, Status):
            told = replace(content, alarms=(*content.alarms, *self.faults))
            self.send(PUBLISHED, at, Published(at, told, {}))

    def send(self, kind: str, at: int, content: object) -> None:
        self.now = max(self.now, at)
        plain = json.loads(to_json(content, fallback=dict))
        for view in self.views:
            view.take(kind, at, adapter(kind).validate_python(plain), self.now)

    def shown(self) -> dict[str, Any]:
        """As the browser gets it."""
        found: dict[str, Any] = json.loads(to_json(self.view.now(self.now)))
        return found

    def texts(self, kind: str) -> list[str]:
        return [entry["text"] for entry in self.view.log.entries if entry["kind"] == kind]


def test_a_grip_is_shown_as_it_goes(verdin: Description) -> None:
    watched = Watched(verdin)
    watched.tool.run(1.5)
    ready = watched.shown()
    assert (ready["state"]["word"], ready["state"]["held"], ready["state"]["changer"]) == (
        "STAND_BY",
        False,
        "LOCKED",
    )
    assert ready["news"]["fresh"]
    (rate,) = ready["rates_hz"]
    assert 45 <= rate <= 51
    assert watched.view.drawn()["sources"] == [{"name": "", "hz": 50.0}]
    assert watched.view.drawn()["parts"] == []
    assert ready["buttons"]["grip"] == ""
    watched.tool.play("grip", 0.2)
    first = watched.shown()
    assert first["state"]["goal"]["name"] == "Grip"
    assert first["state"]["goal"]["at_most_s"] == verdin.durations.grip_ms / 1000
    card = first["cards"][0]
    assert (card["state"], card["phase"]) == ("PENDING ON", "pending")
    assert (card["attempt"]["number"], card["attempt"]["of"]) == (1, 3)
    assert card["timer"]["what"] == "time-out"
    assert 4.5e6 < card["timer"]["until"] - watched.now <= 5.0e6
    assert first["cancel"].startswith("Now: the grip ends")
    watched.tool.run(4.0)
    held = watched.shown()
    assert (held["state"]["word"], held["state"]["held"], held["state"]["lift_allowed"]) == (
        "GRIPPED",
        True,
        True,
    )
    assert held["cards"][0]["hold"]["secure"] is True
    assert held["cards"][0]["values"][0] > 75
    assert held["cards"][0]["margin_kpa"] == pytest.approx(held["cards"][0]["values"][0] - 50)
    assert held["automata"]["Gripper"]["location"] == "Gripped"
    assert held["automata"]["Changer"]["location"] == "Locked"
    assert "State GRIPPED" in watched.texts("transition")


def test_what_a_button_says_is_what_the_automata_answer(verdin: Description) -> None:
    """Asked before and after, in each state of a grip and a drop."""
    watched = Watched(verdin)
    states = set()
    for command, seconds in ((None, 1.5), ("grip", 0.2), (None, 4.0), ("drop", 0.1), (None, 4.0)):
        if command:
            assert watched.tool.command(command).accepted
        watched.tool.run(seconds)
        said = watched.shown()["buttons"]
        states.add(watched.tool.status.ee)
        for word in ("grip", "drop", "cancel", "lock", "unlock"):
            if said[word]:
                answer = watched.tool.command(word)
                assert (answer.accepted, answer.reason) == (False, said[word])
    assert states == {State.STAND_BY, State.GRIPPING, State.GRIPPED, State.RELEASING}


def test_a_failing_attempt_is_shown_with_its_time_out(verdin: Description) -> None:
    watched = Watched(verdin, "fails-once:cylinder")
    watched.tool.play(1.5, "grip")
    while not (timeouts := watched.texts("time-out")):
        watched.tool.run(0.1)
    entry = next(entry for entry in watched.view.log.entries if entry["kind"] == "time-out")
    assert "T_CONFIRM" in entry["detail"]["edges"][0]["guard"]
    assert entry["detail"]["readings"]["supply"] > 400
    failed = "Cylinder was not confirmed within 5 s: attempt 1 of 3"
    assert timeouts == [f"{failed}; Cylinder RETRACTED; Cylinder output off"]
    watched.tool.run(2.0)
    attempts = [card["attempt"] for card in watched.shown()["cards"] if card["attempt"]]
    assert max(attempt["number"] for attempt in attempts) == 2


def test_interlocks_say_why(verdin: Description) -> None:
    watched = Watched(verdin)
    watched.tool.run(1.5)
    rows = {row["id"]: row for row in watched.shown()["interlocks"]}
    assert list(rows) == [f"IL-{number:02}" for number in range(1, 14)]
    assert rows["IL-05"]["state"] == rows["IL-07"]["state"] == "fulfilled"
    assert rows["IL-13"]["state"] == "not fitted"
    watched.tool.play("grip", 4.0)
    rows = {row["id"]: row for row in watched.shown()["interlocks"]}
    assert (rows["IL-01"]["state"], rows["IL-01"]["blocks"]) == ("blocking", "unlock")
    assert rows["IL-01"]["why"] == "unlock only in STAND_BY; the end-effector is GRIPPED."


def test_what_became_of_the_last_command_stands_until_it_is_outdated(verdin: Description) -> None:
    watched = Watched(verdin)
    watched.tool.run(1.5)
    assert watched.shown()["state"]["last"] is None
    watched.tool.play("grip", 0.2)
    assert watched.shown()["state"]["last"] is None
    watched.tool.run(4.0)
    last = watched.shown()["state"]["last"]
    assert (last["outcome"], last["word"], last["reason"]) == ("SUCCEEDED", "Grip succeeded", "")
    assert 0 < last["seconds"] < 4
    watched.tool.play("drop", 0.05)
    assert watched.shown()["state"]["last"] is None
    watched.tool.run(5.0)
    assert watched.shown()["state"]["last"]["word"] == "Drop succeeded"


@pytest.mark.parametrize(
    ("cancelled", "word", "reason"),
    [
        (False, "Grip failed", "Cylinder was not confirmed within 5 s in 3 attempts."),
        (True, "Grip cancelled", "The grip was cancelled."),
    ],
)
def test_a_grip_that_ends_otherwise_is_said_with_its_reason_once_it_is_unwound(
    verdin: Description, cancelled: bool, word: str, reason: str
) -> None:
    watched = Watched(verdin, "never-confirms:cylinder")
    watched.tool.play(1.5, "grip", 3.0)
    if cancelled:
        assert watched.tool.command("cancel").accepted
    watched.tool.run(30.0)
    shown = watched.shown()["state"]
    assert (shown["name"], shown["goal"]) == ("STAND_BY", None)
    assert (shown["last"]["word"], shown["last"]["reason"]) == (word, reason)


@pytest.mark.parametrize(
    ("scenario", "word", "why"),
    [
        ("nominal", "CLOSED", ""),
        ("estop-open", "OPEN", "nothing is activated now"),
        ("silent-after:1", "NOT KNOWN", "nothing is activated now"),
    ],
)
def test_an_e_stop_has_a_card(tmp_path: Path, scenario: str, word: str, why: str) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(f"{profile_path().read_text()}\ne_stop: {{channel: estop_ok}}\n")
    watched = Watched(load(path), scenario)
    watched.tool.run(1.5)
    assert watched.shown()["state"]["e_stop"] == {"word": word, "why": why}
    if word == "CLOSED":
        watched.faults = (
            Alarm(E_STOPPED, "", latched("the emergency stop was opened; reset the faults first.")),
        )
        watched.tool.play("grip", 0.2)
        assert watched.shown()["state"]["e_stop"] == {"word": "STOPPED", "why": UNTIL_RESET}


def test_a_stop_is_shown_wherever_the_tool_stands(verdin: Description) -> None:
    """It can be given whatever the programs say, and needs no e-stop input."""
    watched = Watched(verdin)
    assert watched.shown()["buttons"]["stop"] == ""
    watched.tool.run(1.5)
    assert watched.shown()["stop"].startswith("Latched until a reset")
    assert watched.shown()["state"]["e_stop"] is None
    watched.faults = (
        Alarm(STOPPED, "", latched("the tool was stopped (pid 7): nothing is activated until a reset.")),
    )
    watched.tool.play("grip", 0.2)
    shown = watched.shown()
    assert shown["stop"].startswith("Stopped: nothing is activated")
    row = next(row for row in shown["interlocks"] if row["id"] == "IL-13")
    assert row["state"] == "blocking"
    assert row["why"].startswith("the tool was stopped")
    assert shown["state"]["e_stop"] == {"word": "STOPPED", "why": UNTIL_RESET}


def test_an_interlock_of_which_nothing_was_heard_is_not_fulfilled(verdin: Description) -> None:
    states = {row["id"]: row["state"] for row in ToolView(verdin, 0).now(0)["interlocks"]}
    assert [name for name, state in states.items() if state == "not fitted"] == ["IL-08", "IL-13"]
    assert set(states.values()) == {"not fitted", "not known"}


def test_a_fault_of_the_tool_changer_is_that_of_its_interlock(verdin: Description) -> None:
    watched = Watched(verdin, "locked-shows:tool_changer:0")
    watched.tool.run(10.0)
    shown = watched.shown()
    assert shown["state"]["changer"] == "FAULT"
    row = next(row for row in shown["interlocks"] if row["id"] == "IL-04")
    assert row["state"] == "blocking"
    assert row["why"].startswith("locked and unlocked were both on, or both off")


def test_without_news_nothing_counts_as_present(verdin: Description) -> None:
    watched = Watched(verdin)
    watched.tool.run(1.5)
    watched.now += STALE_US
    assert watched.shown()["news"]["fresh"]
    watched.now += 1
    stale = watched.shown()["news"]
    assert not stale["fresh"]
    assert "is silent" in stale["why"]
    gone = "The HAL has ended its connection."
    watched.view.lose(gone, watched.now)
    shown = watched.shown()
    assert shown["buttons"]["grip"] == shown["buttons"]["reset"] == gone
    assert shown["buttons"]["stop"] == ""
    assert shown["news"]["why"] == gone
    assert (shown["state"]["name"], shown["state"]["changer"]) == ("OFF", "UNKNOWN")


def test_a_page_that_comes_later_stands_where_the_program_stands(verdin: Description) -> None:
    early = Watched(verdin)
    early.tool.play(1.5, "grip", 0.9)
    late = ToolView(verdin, early.now)
    snapshot = json.loads(to_json(early.tool.controller.snapshot(), fallback=dict))
    for kind, content in (
        ("header", header_of(verdin, 0)),
        ("state", adapter("state").validate_python(snapshot)),
        (PUBLISHED, Published(early.now, early.tool.status, {})),
    ):
        late.take(kind, early.now, content, early.now)
    one, other = early.shown(), json.loads(to_json(late.now(early.now)))
    for key in ("cards", "buttons", "interlocks"):
        assert one[key] == other[key]
    assert {name: each["location"] for name, each in one["automata"].items()} == {
        name: each["location"] for name, each in other["automata"].items()
    }


def test_a_program_with_another_description_is_not_shown(verdin: Description) -> None:
    view = ToolView(verdin, 0)
    other = verdin.model_copy(update={"name": "another"})
    header = header_of(other, 0)
    with pytest.raises(ReportedError, match="runs another description") as refused:
        view.take("header", 0, header, 0)
    assert str(refused.value).endswith(f"Start: eehal page {header.source}")


def test_clocks_have_their_bounds_as_the_constants_say(verdin: Description) -> None:
    watched = Watched(verdin)
    watched.tool.play(1.5, "grip", 0.2)
    (clock,) = watched.shown()["automata"]["Gripper"]["clocks"]
    assert (clock["name"], clock["bound"], clock["limit_ms"]) == ("t", "T_CONFIRM[part][i] + D", 5050)
    assert 150_000 <= watched.now - clock["since"] <= 250_000


def test_an_edge_knows_the_requirements_that_name_its_ends_or_what_it_writes(verdin: Description) -> None:
    drawn = ToolView(verdin, 0).drawn()["automata"]
    gripper = next(each for each in drawn["templates"] if each["name"] == "Gripper")
    ids = [each["id"] for each in drawn["requirements"]]

    def spoken_of(source: str, target: str) -> set[str]:
        names = [each["name"] for each in gripper["locations"]]
        edges = [e for e in gripper["edges"] if (names[e["source"]], names[e["target"]]) == (source, target)]
        assert edges
        return {ids[number] for each in edges for number in each["requirements"]}

    assert "order-step" in spoken_of("StandBy", "Activate")  # it names Gripper.Activate
    assert "order-step" not in spoken_of("Unwind", "ReleaseError")
    assert "outputs" not in spoken_of("StandBy", "Activate")  # it speaks of the valves, which Actuator writes
    assert drawn["requirements"][0]["sentence"]


def test_an_edge_knows_the_requirements_that_need_it(verdin: Description) -> None:
    """By the record that comes with the automata."""
    drawn = ToolView(verdin, 0).drawn()["automata"]
    ids = [each["id"] for each in drawn["requirements"]]
    found = 0
    for template in load_automata(verdin).document.templates:
        name = template.name.content.strip()
        for shown in (each for each in drawn["templates"] if each["name"] == name):
            for number, edge in enumerate(shown["edges"]):
                needs = kept_record().of_edge(template, number)
                by = [ids[each] for each in edge["needed"]["by"]]
                assert (edge["needed"]["edits"], by) == (
                    (needs.edits, [*needs.needed_by]) if needs else (0, [])
                )
                found += bool(by)
    assert found > 10


@pytest.mark.parametrize("supply", ["supply", "none"])
def test_the_margin_of_a_cylinder_is_that_of_ros(verdin: Description, supply: str) -> None:
    """Also without a sensor of the supply: its nominal pressure counts, and no rod has a margin at 0 kPa."""
    stanza = verdin.supply.model_copy(update={"channel": supply})
    watched = Watched(verdin.model_copy(update={"supply": stanza}))
    watched.tool.run(1.5)
    card = watched.shown()["cards"][1]
    assert card["values"][0] < 5
    values = {"cylinder": round(card["values"][0] * 1000), supply: 600_000}
    aggregate = Aggregate(watched.description, 0)
    message = aggregate.message(watched.tool.status, values, 0, count=0, stamp_us=None)
    assert card["margin_kpa"] * 1000 == pytest.approx(message.margins[1], abs=200)
    assert card["margin_kpa"] == pytest.approx(card["values"][0] - 510, abs=5)


def test_nobody_says_no_leak_before_it_is_known(verdin: Description) -> None:
    """From the beginning of the grip, and after a gap, until the window of the trend is full again."""
    watched = Watched(verdin, "leak-grows:bottom_vacuum:2")
    watched.tool.play(1.0, "grip", 2.0)
    assert watched.tool.status.held
    before, unknown = 100.0, 0
    for moment in range(60):
        watched.tool.link = not 30 <= moment < 34
        watched.tool.run(0.1)
        hold, kpa = watched.shown()["cards"][0]["hold"], watched.shown()["cards"][0]["values"][0]
        if kpa is not None and kpa < before - 0.1:
            assert hold["leak_kpa_s"] is None or hold["leaks"]
        unknown += hold["leak_kpa_s"] is None
        before = kpa or before
    assert 25 < unknown < 35  # twice 1.6 s


def test_what_is_over_is_in_the_log_once_and_is_no_alarm(verdin: Description) -> None:
    watched = Watched(verdin)
    watched.tool.play(1.0, "grip", 4.0)
    watched.tool.link = False
    watched.tool.run(0.4)
    watched.tool.link = True
    watched.tool.run(1.0)
    again = "Top vacuum had no valid reading for a while; it is read again."
    assert f"Over: {again}" in [each["text"] for each in watched.shown()["state"]["alarms"] if each["over"]]
    watched.tool.play("drop", 4.0)
    assert watched.shown()["state"]["alarms"] == []
    assert watched.texts("over").count(again) == 1
    assert len(watched.texts("over")) == len(watched.texts("alarm")) == 4
    assert "No valid reading of locked, unlocked, in_stand, tool_present, supply." in watched.texts("over")
    assert not any(each.startswith("Over") for each in watched.texts("alarm"))


def test_the_log_is_in_the_order_of_time(verdin: Description) -> None:
    log = Watched(verdin).view.log
    number = log.newest
    log.add(59_590_000, "refusal", "of a write")
    log.add(59_420_000, "alarm", "of the status that it belongs to")
    assert [entry["kind"] for entry in log.since(number)] == ["alarm", "refusal"]


def test_each_of_several_sources_has_a_rate_of_its_own() -> None:
    """Two links and the inputs of a board were shown as one rate, against the period of the slowest."""
    tool = load_tool(ROOT / "examples/tools/two_links/end_effector.yaml")
    view = ToolView(tool, 0)
    view.take("header", 0, header_of(tool, 0), 0)

    def put(record: object) -> None:
        kind, at, content = entry_of(record)
        view.take(kind, at, content, at)

    controller = RecordedController(tool, load_automata(tool), put)
    controller.start({}, 0)
    frames = [
        Frame(at, None, None, dict.fromkeys(source.channels))
        for source in sources_of(carrier_of(tool))
        for at in range(source.period_us, 3_000_000, source.period_us)
    ]
    for frame in sorted(frames, key=lambda frame: frame.at):
        controller.frame(frame)
    assert view.drawn()["sources"] == [
        {"name": "cups", "hz": 25.0},
        {"name": "jaws", "hz": 50.0},
        {"name": "inputs", "hz": 50.0},
    ]
    assert view.now(3_000_000)["rates_hz"] == pytest.approx([25.0, 50.0, 50.0], rel=0.1)


def test_a_part_is_chosen_named_and_judged_by_its_own_values(tmp_path: Path) -> None:
    watched = Watched(gripper_with_parts(tmp_path), "fails:bottom_vacuum:9")
    drawn = watched.view.drawn()
    assert drawn["parts"] == [
        {"name": "panel", "summary": "600 × 400 mm, 4 kg"},
        {"name": "box", "summary": ""},
    ]
    marks = {
        part: {each["word"]: each["at"] for each in found}
        for part, found in drawn["cards"][0]["gauges"][0]["marks"].items()
    }
    assert (marks["panel"]["confirmed"], marks["box"]["confirmed"]) == (55.0, 40.0)
    watched.tool.run(1.5)
    rest = watched.shown()
    assert rest["parts"] == {"panel": "", "box": ""}
    assert (rest["state"]["word"], rest["state"]["judged"]) == ("STAND_BY", "panel")
    assert [card["unused"] for card in rest["cards"]] == [False] * 3
    watched.tool.play("grip box", 0.2)
    shown = watched.shown()
    assert (shown["state"]["word"], shown["state"]["judged"]) == ("GRIPPING: box", "box")
    assert shown["state"]["goal"]["name"] == "Grip box"
    assert [card["unused"] for card in shown["cards"]] == [False, True, True]
    assert shown["cards"][0]["attempt"]["of"] == 2
    assert shown["cards"][0]["timer"]["of_s"] == 2.0
    assert "Grip box accepted." in watched.texts("command")
    late = ToolView(watched.description, watched.now)
    snapshot = json.loads(to_json(watched.tool.controller.snapshot(), fallback=dict))
    late.take("header", watched.now, header_of(watched.description, 0), watched.now)
    late.take("state", watched.now, adapter("state").validate_python(snapshot), watched.now)
    watched.views.append(late)
    watched.tool.run(2.0)
    for view in watched.views:
        (timeout,) = [entry["text"] for entry in view.log.entries if entry["kind"] == "time-out"]
        assert timeout.startswith("Bottom vacuum was not confirmed within 2 s: attempt 1 of 2;")


def test_the_part_stays_on_the_page_until_it_is_released(tmp_path: Path) -> None:
    watched = Watched(gripper_with_parts(tmp_path))
    watched.tool.play(1.5, "grip box", 4.0)
    held = watched.shown()
    assert held["state"]["word"] == "GRIPPED: box"
    assert [card["unused"] for card in held["cards"]] == [False, True, True]
    assert [bool(card["hold"]) for card in held["cards"]] == [True, False, False]
    assert [card["margin_kpa"] is None for card in held["cards"]] == [False, True, True]
    assert held["cards"][0]["margin_kpa"] == pytest.approx(held["cards"][0]["values"][0] - 30)
    watched.tool.play("drop", 4.0)
    rest = watched.shown()
    assert (rest["state"]["word"], rest["state"]["judged"]) == ("STAND_BY", "panel")
    assert not any(card["unused"] for card in rest["cards"])
    assert rest["cards"][0]["attempt"]["of"] == 2
