"""The one session of a program: its last will while both halves of a tool are active, and records of two sessions."""

from __future__ import annotations

from dataclasses import replace

import pytest

from end_effector_hal.arbiter import SENSOR_FAULT
from end_effector_hal.arbiter.records import SessionStore
from end_effector_hal.arbiter.rules._session import SessionRecord
from end_effector_hal.vocabulary import ChangerFault, ChangerState, EndEffectorState
from end_effector_lab.virtual import VirtualTool
from tests.support.declared import declared
from tests.unit.virtual.test_tool import (
    BOTTOM,
    CYLINDER,
    TOP,
    UNLOCK,
    gripped,
    moved,
    pending_cylinder,
    ready,
    until,
)

GRIPPED, STAND_BY = EndEffectorState.GRIPPED, EndEffectorState.STAND_BY
LOCK, BOTTOM_OFF = (0, UNLOCK), (2_000_000, BOTTOM)
CYLINDER_OFF, TOP_OFF = (0, CYLINDER), (0, TOP)


def unlocked_while(moment: str, ending: str, grip: str, changer: str) -> VirtualTool:
    """A tool without IL-01 and IL-05 whose unlock output is active with those of the gripping."""
    tool = declared(
        {"gripping": {ending: grip}, "held": {ending: grip}}, changer={ending: changer}, il_09=False
    )
    locks = tool.interlocks.model_copy(update={"il_01": False, "il_05": False})
    played = ready(tool.model_copy(update={"interlocks": locks}))
    if moment == "maintenance":
        assert played._program
        assert played._program._drive("cylinder", None, active=True).accepted
        played.run(0.1)
    else:
        assert played.command("grip").accepted
        assert played.run_until(played.at + 10_000_000, lambda: played.levels[CYLINDER])
    if moment == "gripped":
        until(played, GRIPPED)
    assert played.command("unlock").accepted
    played.run(0.06)
    assert played.levels[UNLOCK]
    return played


@pytest.mark.parametrize(
    ("ending", "grip", "changer"),
    [
        ("process_death", "release", "release"),
        ("process_death", "release", "hold"),
        ("process_death", "hold", "release"),
        ("process_death", "leave", "leave"),
        ("sigterm", "release", "release"),
        ("sigterm", "hold", "release"),
        ("sigterm", "release", "leave"),
    ],
)
@pytest.mark.parametrize(
    ("moment", "released"),
    [
        ("gripping", [CYLINDER_OFF, BOTTOM_OFF]),
        ("gripped", [TOP_OFF, (2_000_000, CYLINDER), (4_000_000, BOTTOM)]),
        ("maintenance", [CYLINDER_OFF]),
    ],
)
def test_one_will_does_what_is_declared_for_each_half(
    moment: str, released: list[tuple[int, str]], ending: str, grip: str, changer: str
) -> None:
    """Maintenance ends at once in any case; it replaces what the gripping declares, and nothing of the tool changer."""
    tool = unlocked_while(moment, ending, grip, changer)
    before, at = len(tool.edges), tool.at
    (tool.kill if ending == "process_death" else tool.end)("hal")
    tool.run(2.9)
    expected = [LOCK] if changer == "release" else []
    expected += released if grip == "release" or moment == "maintenance" else []
    seen = [(edge.at - at, edge.line) for edge in tool.edges[before:] if not edge.level]
    assert seen == [each for each in expected if each[0] < 2_900_000]
    tool.run(4.0)
    assert [edge.level for edge in tool.edges[before:]].count(True) == 0
    left = {BOTTOM, CYLINDER, TOP} & {line for line, level in tool.levels.items() if level}
    assert bool(left) is (grip != "release" and moment != "maintenance")
    assert not tool.levels[UNLOCK], "IL-03 ends it in any case"


def recorded_as_two(tool: VirtualTool, *, sensor_fault: bool) -> None:
    """Both processes have died; their session record and their wills become those of two programs."""
    memories = tool.memories
    store = SessionStore(memories.sessions, memories.mark, memories.boot, lambda: tool.at)
    state = store.read()
    assert state
    (hal,) = state.clients
    names = (SENSOR_FAULT,) if sensor_fault else ()
    halves = (("grip", (BOTTOM, CYLINDER, TOP), ()), ("tool_change", (UNLOCK,), names))
    clients = tuple(
        SessionRecord(
            name, f"{number:032x}", lines, tuple(s for s in hal.will if s.line in lines), hal.ended, 7, faults
        )
        for number, (name, lines, faults) in enumerate(halves)
    )
    faults = {**state.faults, **dict.fromkeys(names, "IL-04: an old sentence.")}
    store.keep(replace(state, clients=clients, faults=faults, dead=(("grip", f"{0:032x}"),)))


@pytest.mark.parametrize("moment", ["gripped", "gripping", "unlocked", "fault"])
def test_a_record_of_two_programs_is_adopted_as_that_of_one(moment: str) -> None:
    tool = {"gripping": pending_cylinder, "unlocked": ready}.get(moment, gripped)()
    if moment == "unlocked":
        assert tool.command("unlock").accepted
        tool.run(0.3)
    tool.kill("arbiter")
    tool.kill("hal")
    tool.run(0.1)
    recorded_as_two(tool, sensor_fault=moment == "fault")
    before = len(tool.edges)
    tool.start("arbiter")
    tool.start("hal")
    tool.run(4.0)
    lets_go = {"gripping": [CYLINDER, BOTTOM], "unlocked": [UNLOCK]}.get(moment, [])
    assert moved(tool, before) == [(line, False) for line in lets_go]
    assert tool.status.ee == (GRIPPED if moment in ("gripped", "fault") else STAND_BY)
    assert tool.living == {"arbiter", "hal"}
    if moment == "fault":
        assert tool.status.changer_fault == ChangerFault.SENSOR
        assert tool.command("reset").accepted
        tool.run(3.0)
    assert not tool.latched
    assert tool.status.changer == ChangerState.LOCKED
