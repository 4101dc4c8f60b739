"""A tool with two parts, in a namespace of its own: which one a goal is for, and which one a state names."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from end_effector_lab.demo._world import World
from tests.acceptance.contract.hal import Hal, quick
from tests.support.parts import with_parts

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def running_parts(running: Hal, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hal]:
    with World(with_parts(quick()), "nominal", tmp_path_factory.mktemp("parts")) as world:
        hal = Hal(world, running.ros, running.layout, running.driver, "/parts")
        hal.start_all()
        hal.connect()
        yield hal
        hal.end_all()


@pytest.fixture
def parts(running_parts: Hal) -> Hal:
    running_parts.rest()
    return running_parts


def test_a_part_is_gripped_by_its_actuators_and_named_until_it_is_released(parts: Hal) -> None:
    begun, edges = parts.since, parts.edges()
    result = parts.do("TriggerGrip", part="lid")
    assert [step["confirmed"] for step in result["steps"]] == [False, False, True]
    state = parts.wait_for("GRIPPED")
    assert (state["part"], state["outputs"], state["held"]) == ("lid", [False, False, True], True)
    assert parts.edges()[len(edges) :] == [("SODIMM_212", 1)]
    parts.sees("the lift is allowed", lambda each: each["lift_allowed"])
    assert parts.refused("Drop", part="panel") == "Only a grip is for a part: Drop needs an empty `part`."
    parts.do("Drop")
    assert parts.wait_for("STAND_BY")["part"] == ""
    busy = [each["part"] for each in parts.after(begun) if each["state_name"] not in ("STAND_BY", "OFF")]
    assert set(busy) == {"lid"}


def test_without_a_name_the_first_part_is_gripped(parts: Hal) -> None:
    parts.do("TriggerGrip")
    state = parts.wait_for("GRIPPED")
    assert (state["part"], state["outputs"]) == ("panel", [True] * 3)
    parts.do("Drop")


def test_an_unknown_part_is_refused_with_those_that_there_are(parts: Hal) -> None:
    edges = parts.edges()
    assert parts.refused("TriggerGrip", part="lod") == "There is no part 'lod'; there are: panel, lid."
    assert parts.refused("TriggerGrip", part="l\nid" * 1000).startswith("There is no part 'l idl id")
    assert (parts.edges(), parts.state["state_name"]) == (edges, "STAND_BY")
