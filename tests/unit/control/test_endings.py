"""Each ending with each of its values, actuator by actuator, in virtual time: exact states, exact lines."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from end_effector_hal.control import GripLastWill, Status
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import Cause
from tests.support.declared import declared
from tests.support.nightly import first_of
from tests.support.virtual_tool import VirtualTool

OFF, GRIPPING, GRIP_ERROR, GRIPPED, RELEASING, RELEASE_ERROR, STAND_BY = range(7)
NONE, GRIP, RELEASE, CANCEL = -1, 2, 3, 4
LINES = BOTTOM, CYLINDER, TOP = ("SODIMM_208", "SODIMM_210", "SODIMM_212")
NAMES = ("bottom_vacuum", "cylinder", "top_vacuum")
S = 1_000_000


def tool_of(description: Description, scenario: str = "nominal") -> VirtualTool:
    tool = VirtualTool(description, scenario)
    tool.run(1.0)
    assert tool.status.ee == STAND_BY
    assert tool.command("grip").accepted
    return tool


def ending(holds: tuple[bool, ...], phase: str, on: str) -> dict[str, Any]:
    """What each actuator does then: it holds, or it is released."""
    return {
        name: {phase: {on: "hold" if each else "release"}} for name, each in zip(NAMES, holds, strict=True)
    }


def switched(tool: VirtualTool, since: int) -> list[tuple[str, bool]]:
    return [(line, level) for at, line, level in tool.edges if at >= since]


def passed(tool: VirtualTool) -> list[tuple[int, int]]:
    pairs = [(ee, command) for ee, command, _ in tool.states()]
    return [pair for at, pair in enumerate(pairs) if at == 0 or pair != pairs[at - 1]]


def active(tool: VirtualTool) -> list[str]:
    return [line for line in LINES if tool.levels.get(line)]


def drop_releases_everything(tool: VirtualTool) -> None:
    before = active(tool)
    since = tool.at
    tool.play("drop", 8.0)
    assert switched(tool, since) == [(line, False) for line in reversed(before)]
    assert (tool.status.ee, tool.status.held, tool.status.reason) == (STAND_BY, False, "")


HOLDS = first_of(
    [
        (False, True, True),
        (True, False, False),
        (False, False, False),
        (True, True, True),
        (False, True, False),
    ],
    1,
    2,
)


@pytest.mark.parametrize("holds", HOLDS)
def test_cancel(holds: tuple[bool, ...]) -> None:
    """While the last step is pending: what holds stays, the rest is released in its order."""
    tool = tool_of(declared(**ending(holds, "gripping", "cancel")), "never-confirms:top_vacuum")
    tool.run(4.0)
    assert active(tool) == list(LINES)
    since = tool.at
    tool.play("cancel", 8.0)
    stays = [line for line, each in zip(LINES, holds, strict=True) if each]
    assert switched(tool, since) == [(line, False) for line in reversed(LINES) if line not in stays]
    assert (active(tool), tool.status.ee) == (stays, GRIP_ERROR if stays else STAND_BY)
    assert tool.status.cause == Cause.CANCELLED
    assert tool.status.held is bool(stays)
    assert ((RELEASING, CANCEL) in passed(tool)) is (len(stays) < 3)
    if stays:
        drop_releases_everything(tool)


def test_what_a_cancel_leaves_active_is_told() -> None:
    tool = tool_of(declared(bottom_vacuum={"gripping": {"cancel": "hold"}}), "never-confirms:top_vacuum")
    tool.play(4.0, "cancel")
    assert (tool.status.ee, tool.status.kept, tool.status.reason) == (
        RELEASING,
        (0,),
        "The grip was cancelled.",
    )
    tool.run(8.0)
    why = "The grip was cancelled. Bottom vacuum stays active, as declared."
    assert tool.status.reason == why
    assert f"GRIP_ERROR: {why} Active outputs stay active; only a Drop releases." in tool.status.alarm_texts
    assert not tool.command("grip").accepted
    assert not tool.command("cancel").accepted
    assert not tool.command("unlock").accepted


def test_a_cancel_with_nothing_engaged_that_holds_ends_in_stand_by() -> None:
    tool = tool_of(declared(top_vacuum={"gripping": {"cancel": "hold"}}), "never-confirms:cylinder")
    tool.play(2.0, "cancel", 8.0)
    assert (tool.status.ee, active(tool)) == (STAND_BY, [])


def test_a_cancel_in_the_pause_leaves_what_is_engaged() -> None:
    whole = {"gripping": {"cancel": "hold"}}
    tool = tool_of(declared(whole), "never-confirms:cylinder")
    tool.run(6.0)
    assert active(tool) == [BOTTOM]
    tool.play("cancel", 3.0)
    assert (tool.status.ee, active(tool)) == (GRIP_ERROR, [BOTTOM])
    assert (RELEASING, CANCEL) not in passed(tool)


@pytest.mark.parametrize("ending", ["release", "hold"])
def test_timeout(ending: str) -> None:
    """hold: no pause, no second activation; the attempts are counted all the same, and the third one aborts."""
    tool = tool_of(declared(cylinder={"gripping": {"timeout": ending}}), "never-confirms:cylinder")
    tool.run(30.0)
    edges = [(at / S, level) for at, line, level in tool.edges if line == CYLINDER]
    begun = edges[0][0]
    expected = [0, 5, 6, 11, 12, 17] if ending == "release" else [0, 15]
    assert [at - begun for at, _ in edges] == pytest.approx(expected)
    assert tool.status.steps[1].attempts == 3
    assert tool.status.ee == STAND_BY
    assert tool.status.reason == "Cylinder was not confirmed within 5 s in 3 attempts."


def test_what_is_late_is_confirmed_in_the_time_of_its_next_attempt() -> None:
    tool = tool_of(declared({"gripping": {"timeout": "hold"}}), "supply:410,leak:top_vacuum:60")
    tool.run(7.0)
    assert (tool.status.ee, tool.status.step, tool.status.attempt) == (GRIPPING, 2, 2)
    tool.bench.choose("nominal", tool.at)
    tool.run(3.0)
    assert tool.status.ee == GRIPPED
    assert [step.attempts for step in tool.status.steps] == [1, 1, 2]
    assert [line for _, line, _ in tool.edges] == list(LINES)


@pytest.mark.parametrize("holds", HOLDS)
def test_abort(holds: tuple[bool, ...]) -> None:
    """The last step is never confirmed; its own output is active at its last time-out."""
    tool = tool_of(declared(**ending(holds, "gripping", "abort")), "never-confirms:top_vacuum")
    tool.run(40.0)
    stays = [line for line, each in zip(LINES, holds, strict=True) if each]
    assert (active(tool), tool.status.ee) == (stays, GRIP_ERROR if stays else STAND_BY)
    assert (tool.status.cause, tool.status.cause_at) == (Cause.TIMED_OUT, 2)
    assert tool.status.reason.startswith("Top vacuum was not confirmed within 5 s in 3 attempts.")
    assert (GRIP_ERROR, RELEASE) in passed(tool)
    assert ((RELEASING, RELEASE) in passed(tool)) is (len(stays) < 3)
    if stays:
        drop_releases_everything(tool)


@pytest.mark.parametrize("holds", HOLDS)
def test_lost(holds: tuple[bool, ...]) -> None:
    """While GRIPPED; a release needs IL-09 switched off."""
    tool = tool_of(declared(il_09=False, **ending(holds, "held", "lost")), "lost-after:bottom_vacuum:6")
    tool.run(4.0)
    assert tool.status.ee == GRIPPED
    since = tool.at
    tool.run(16.0)
    stays = [line for line, each in zip(LINES, holds, strict=True) if each]
    assert switched(tool, since) == [(line, False) for line in reversed(LINES) if line not in stays]
    assert (active(tool), tool.status.ee) == (stays, GRIP_ERROR if stays else STAND_BY)
    assert (tool.status.cause, tool.status.cause_at) == (Cause.LOST, 0)
    if stays:
        drop_releases_everything(tool)


@pytest.mark.parametrize("engaged", [(TOP,), (BOTTOM, CYLINDER), LINES])
@pytest.mark.parametrize("ending", ["hold", "release"])
def test_power_up(ending: str, engaged: tuple[str, ...]) -> None:
    tool = VirtualTool(declared({"power_up": ending}, il_09=False), levels=dict.fromkeys(engaged, True))
    tool.run(9.0)
    if ending == "release":
        assert tool.edges
        assert [line for _, line, _ in tool.edges] == list(reversed(engaged))
        assert (active(tool), tool.status.ee) == ([], STAND_BY)
        assert tool.status.reason == "Outputs were active at the start; they are deactivated, as declared."
    else:
        assert tool.edges == []
        assert tool.status.ee == (GRIPPED if engaged == LINES else GRIP_ERROR)


def test_power_up_of_one_actuator() -> None:
    tool = VirtualTool(
        declared(il_09=False, cylinder={"power_up": "release"}), levels=dict.fromkeys(LINES, True)
    )
    tool.run(9.0)
    assert [(line, level) for _, line, level in tool.edges] == [(CYLINDER, False)]
    assert (active(tool), tool.status.ee) == ([BOTTOM, TOP], GRIP_ERROR)
    assert tool.status.reason.endswith("Bottom vacuum, Top vacuum stay active, as declared.")
    drop_releases_everything(tool)


ENGAGED = (True, True, True)
SITUATIONS = {
    "gripping": (GRIPPING, GRIP, False, ()),
    "held": (GRIPPED, NONE, True, ()),
    "latched": (GRIP_ERROR, NONE, True, ()),
    "releasing": (RELEASING, RELEASE, False, ()),
    "unwinding": (RELEASING, CANCEL, False, (0,)),
}


@pytest.mark.parametrize("on", ["sigterm", "process_death"])
@pytest.mark.parametrize("ending", ["hold", "release", "leave"])
@pytest.mark.parametrize("situation", SITUATIONS)
def test_the_end_of_a_program(situation: str, ending: str, on: str) -> None:
    """The will: of the bottom vacuum as declared here, of the others as they are by default."""
    own = {"gripping": {on: ending}, "held": {on: ending}}
    description = declared(il_09=False, bottom_vacuum=own)
    ee, command, held, kept = SITUATIONS[situation]
    status = Status(0, ee, command, (2, 2, 2), ENGAGED, (3, 3, 3), held=held, kept=kept)
    others = [] if held else [TOP, CYLINDER]
    # what is being released is released, whatever is declared; what an unwinding leaves active is held
    bottom = ending == "release" or situation == "releasing"
    expected = [*others, BOTTOM] if bottom else others
    will = GripLastWill(description).of(status, on=on)
    assert [step.line for step in will] == expected
    assert [step.after_us for step in will] == [2 * S * at for at in range(len(expected))]
    other = "process_death" if on == "sigterm" else "sigterm"
    assert [step.line for step in GripLastWill(description).of(status, on=other)] == (
        [] if held else [TOP, CYLINDER] if kept else [TOP, CYLINDER, BOTTOM]
    )


def test_a_will_names_only_what_is_active() -> None:
    description = declared(cylinder={"gripping": {"process_death": "hold"}})
    status = Status(0, GRIPPING, GRIP, (2, 1, 0), (True, True, False), (3, 2, 1))
    assert [step.line for step in GripLastWill(description).of(status)] == [BOTTOM]
    assert GripLastWill(description).of(replace(status, outputs=(False, True, False))) == ()
