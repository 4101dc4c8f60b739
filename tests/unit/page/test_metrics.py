"""The metrics of a tool: real controllers in virtual time, read with the parser of prometheus_client."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families

from end_effector_hal.control import EventKind
from end_effector_hal.description import Description
from end_effector_hal.page.web._metrics import ToolMetrics
from end_effector_hal.runtime.boundary import Published
from end_effector_hal.runtime.boundary._open import header_of
from end_effector_hal.runtime.stream import HEALTH, PUBLISHED
from end_effector_hal.vocabulary import Alarm
from end_effector_hal.wires.inputs import InputsHealth
from end_effector_hal.wires.link import LinkHealth, LinkState
from end_effector_hal.wires.sensors import SensorHealth
from tests.support.named_parts import gripper_with_parts
from tests.support.places import ROOT
from tests.unit.page.test_tool_view import Watched

Samples = dict[tuple[str, ...], float]


def samples(watched: Watched, name: str) -> Samples:
    """The samples of one name, by the values of their labels but the tool's, in alphabetical order of the labels."""
    found: Samples = {}
    text = ToolMetrics(watched.view, lambda: watched.now).text().decode()
    for family in text_string_to_metric_families(text):
        for sample in family.samples:
            labels = dict(sample.labels)
            assert labels.pop("tool") == watched.description.name
            if sample.name == f"eehal_{name}":
                found[tuple(labels[label] for label in sorted(labels))] = sample.value
    return found


def grip(watched: Watched, part: str = "", seconds: float = 4.0) -> None:
    assert watched.tool.command("grip", part).accepted
    watched.tool.run(seconds)


def drop(watched: Watched) -> None:
    watched.tool.play("drop", 3.0)


def test_grips_are_counted_by_outcome_and_attempts_by_actuator(verdin: Description) -> None:
    watched = Watched(verdin, "fails-once:cylinder")
    watched.tool.run(1.5)
    assert samples(watched, "grips_total")["GRIPPED", ""] == 0  # from 0 on: the first one is an increase
    grip(watched, seconds=9.0)
    drop(watched)
    grip(watched)
    assert samples(watched, "grips_total") == {
        ("GRIPPED", ""): 2, ("ABORTED", ""): 0, ("CANCELLED", ""): 0, ("STOPPED", ""): 0,
    }  # fmt: skip
    assert samples(watched, "first_attempt_grips_total") == {("",): 1}
    attempts = samples(watched, "attempts_total")
    assert attempts["cylinder", "timed out"] == 1
    assert {name: attempts[name, "confirmed"] for name in verdin.sequence} == dict.fromkeys(
        verdin.sequence, 2
    )
    assert samples(watched, "confirm_seconds_count") == {(name,): 2 for name in verdin.sequence}
    steps = {step.name: step.seconds for step in watched.tool.status.steps}
    mean_s = samples(watched, "confirm_seconds_sum")["bottom_vacuum",] / 2
    assert mean_s == pytest.approx(steps["bottom_vacuum"], abs=0.05)


def test_a_cancelled_and_an_aborted_grip_and_a_loss(verdin: Description) -> None:
    watched = Watched(verdin, "lost-after:top_vacuum:6")
    watched.tool.play(1.5, "grip", 0.1, "cancel", 3.0)
    grip(watched, seconds=10.0)
    assert samples(watched, "losses_total")["top_vacuum",] == 1
    counted = samples(watched, "grips_total")
    assert (counted["CANCELLED", ""], counted["GRIPPED", ""]) == (1, 1)
    never = Watched(verdin, "never-confirms:cylinder")
    never.tool.run(1.5)
    grip(never, seconds=25.0)
    assert samples(never, "grips_total")["ABORTED", ""] == 1
    assert samples(never, "attempts_total")["cylinder", "timed out"] == 3


def test_grips_are_counted_by_part(tmp_path: Path) -> None:
    watched = Watched(gripper_with_parts(tmp_path))
    watched.tool.run(1.5)
    for part in ("box", "box", "panel"):
        grip(watched, part)
        drop(watched)
    counted = samples(watched, "grips_total")
    assert (counted["GRIPPED", "box"], counted["GRIPPED", "panel"]) == (2, 1)


def test_the_margin_and_the_leak_are_those_of_the_cards_while_a_part_is_held(verdin: Description) -> None:
    watched = Watched(verdin, "leak-grows:bottom_vacuum:0.1")
    watched.tool.run(1.5)
    assert samples(watched, "margin_pascals") == {}
    assert samples(watched, "state")["STAND_BY",] == 1
    grip(watched, seconds=6.0)
    cards = watched.shown()["cards"]
    assert samples(watched, "held") == {(): 1}
    assert samples(watched, "margin_pascals") == {
        (name,): pytest.approx(card["margin_kpa"] * 1000)
        for name, card in zip(verdin.sequence, cards, strict=True)
    }
    leak = samples(watched, "leak_pascals_per_second")["bottom_vacuum",]
    assert leak == pytest.approx(cards[0]["hold"]["leak_kpa_s"] * 1000)
    assert leak > 100


def test_links_alarms_and_lateness(verdin: Description) -> None:
    watched = Watched(verdin)
    watched.faults = (
        Alarm("arbiter.fault", "journal", {"text": "the journal is full"}),
        Alarm("recording.failed", "hal", {"text": 'a "disk"\\ that is full\n'}, over=True),
    )
    watched.tool.run(1.5)
    assert samples(watched, "alarm") == {("journal", "arbiter.fault", "error"): 1}
    assert samples(watched, "missed_bounds_total") == {(): 0}
    assert samples(watched, "worst_lateness_seconds")[()] == watched.tool.status.worst_late_us / 1e6
    assert samples(watched, "link_up") == {}  # not reported yet
    link = LinkHealth(
        state=LinkState.DOWN, since=0, error="It is gone.", frames=70, lost=2, errors={"crc": 3}
    )
    watched.send(
        HEALTH, watched.now, SensorHealth({"valves": link}, InputsHealth(since=0, frames=5, opened=1))
    )
    assert samples(watched, "link_up") == {("valves",): 0, ("inputs",): 1}
    assert samples(watched, "link_frames_total") == {("valves",): 70, ("inputs",): 5}
    assert samples(watched, "link_lost_total")["valves",] == 2
    assert samples(watched, "link_errors_total") == {("crc", "valves"): 3}


def test_without_the_hal_only_the_counts_stay(verdin: Description) -> None:
    watched = Watched(verdin)
    watched.tool.run(1.5)
    grip(watched)
    assert samples(watched, "up") == {(): 1}
    watched.view.lose("The HAL has ended.", watched.now)
    assert samples(watched, "up") == {(): 0}
    assert samples(watched, "held") == samples(watched, "margin_pascals") == samples(watched, "state") == {}
    assert samples(watched, "grips_total")["GRIPPED", ""] == 1


def test_a_silent_hal_is_not_up(verdin: Description) -> None:
    watched = Watched(verdin)
    watched.tool.run(1.5)
    watched.now += 2_000_000
    assert samples(watched, "up") == {(): 0}
    assert samples(watched, "held") == {}


def test_a_grip_of_which_the_beginning_is_missing_is_not_counted(verdin: Description) -> None:
    """After a loss of records a new header comes; the first status has events of before."""
    watched = Watched(verdin)
    watched.tool.play(1.5, "grip", 0.6)
    watched.send("header", watched.now, header_of(verdin, watched.now))
    watched.tool.run(4.0)
    assert watched.tool.status.held
    assert samples(watched, "grips_total")["GRIPPED", ""] == 0
    drop(watched)
    grip(watched)
    assert samples(watched, "grips_total")["GRIPPED", ""] == 1


def test_the_events_of_the_first_status_were_counted_before(verdin: Description) -> None:
    """A client that connects gets the last status once more, with its events."""
    watched = Watched(verdin, "lost-after:top_vacuum:4")
    watched.tool.run(1.5)
    grip(watched, seconds=10.0)
    lost = next(each for each in watched.tool.statuses if any(e.kind == EventKind.LOST for e in each.events))
    assert samples(watched, "losses_total")["top_vacuum",] == 1
    watched.send("header", watched.now, header_of(verdin, watched.now))
    watched.send(PUBLISHED, watched.now, Published(watched.now, lost, {}))
    assert samples(watched, "losses_total")["top_vacuum",] == 1


def all_names(watched: Watched) -> set[str]:
    """Names of all samples of a tool that holds a part, with every source of readings; `_created` of none."""
    watched.faults = (Alarm("recording.failed", "hal", {"text": "The disk is full."}),)
    watched.tool.run(1.5)
    grip(watched, seconds=6.0)
    link = LinkHealth(state=LinkState.UP, since=0, errors={"crc": 3})
    watched.send(HEALTH, watched.now, SensorHealth({"valves": link}, InputsHealth(since=0)))
    text = ToolMetrics(watched.view, lambda: watched.now).text().decode()
    return {sample.name for family in text_string_to_metric_families(text) for sample in family.samples}


def test_the_dashboard_and_the_docs_name_the_metrics_that_exist(verdin: Description) -> None:
    there = all_names(Watched(verdin, "leak:bottom_vacuum:1"))
    dashboard = json.loads((ROOT / "examples/monitoring/grafana.json").read_text())
    expressions = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
    expressions += [each["query"] for each in dashboard["templating"]["list"]]
    assert len(expressions) > 8
    for each in expressions:
        names = set(re.findall(r"eehal_\w+", each))
        assert names
        assert names <= there, each
    assert set(re.findall(r"eehal_\w+", (ROOT / "docs/how-to/watch.md").read_text())) <= there
    table = (ROOT / "docs/reference/page.md").read_text()
    assert set(re.findall(r"eehal_\w+", table)) | {"eehal_confirm_seconds_count"} == there
