"""What is played follows from the description."""

from __future__ import annotations

import pytest

from end_effector_hal.description import Description
from end_effector_hal.runtime import read_script
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_lab.demo import DemoScenario, scenarios, unplayable
from end_effector_lab.demo._scenario import culprit_of
from end_effector_lab.testbench import parse_scenario
from tests.support.declared import declared

NAMES = ["nominal", "fails-once", "never-confirms", "cancel", "stuck-release", "unlock-lock"]


def of(description: Description, name: str) -> DemoScenario:
    return next(each for each in scenarios(description, everything=True) if each.name == name)


def without_changer(description: Description) -> Description:
    return description.model_copy(update={"tool_changer": None})


def test_the_paper_has_three_and_all_are_six(verdin: Description) -> None:
    assert [scenario.name for scenario in scenarios(verdin)] == NAMES[:3]
    assert [scenario.name for scenario in scenarios(verdin, everything=True)] == NAMES
    assert [scenario.figure for scenario in scenarios(verdin)] == ["Fig. 7", "Fig. 8", "Fig. 9"]


def test_the_failing_actuator_is_the_cylinder(verdin: Description) -> None:
    assert culprit_of(verdin) == "cylinder"
    assert of(verdin, "never-confirms").bench == "never-confirms:cylinder"


@pytest.mark.parametrize(
    ("sequence", "culprit"),
    [
        (("cylinder", "bottom_vacuum"), "bottom_vacuum"),
        (("bottom_vacuum", "top_vacuum"), "top_vacuum"),
        (("top_vacuum",), "top_vacuum"),
    ],
)
def test_another_sequence_has_another_culprit(
    verdin: Description, sequence: tuple[str, ...], culprit: str
) -> None:
    assert culprit_of(verdin.model_copy(update={"sequence": sequence})) == culprit


def test_the_attempts_expected_are_those_of_the_description(verdin: Description) -> None:
    cylinder = verdin.actuators["cylinder"].model_copy(update={"attempts": 5})
    other = verdin.model_copy(update={"actuators": {**verdin.actuators, "cylinder": cylinder}})
    assert of(other, "never-confirms").expected.attempts == {"bottom_vacuum": 1, "cylinder": 5}
    assert of(other, "never-confirms").expected.timeouts == {"cylinder": 5}


def test_a_single_attempt_cannot_recover(verdin: Description) -> None:
    cylinder = verdin.actuators["cylinder"].model_copy(update={"attempts": 1})
    other = verdin.model_copy(update={"actuators": {**verdin.actuators, "cylinder": cylinder}})
    assert EndEffectorState.GRIP_ERROR in of(other, "fails-once").expected.states
    assert [order.command for order in of(other, "fails-once").orders] == [Command.LOCK, Command.GRIP]


def test_a_tool_without_changer_is_not_locked(verdin: Description) -> None:
    found = scenarios(without_changer(verdin), everything=True)
    assert [scenario.name for scenario in found] == NAMES[:5]
    for scenario in found:
        assert Command.LOCK not in [order.command for order in scenario.orders]
        assert Command.LOCK not in scenario.expected.commands


def test_supervisor_and_testbench_understand_every_scenario(verdin: Description) -> None:
    for scenario in scenarios(verdin, everything=True):
        orders = [order for order in read_script(scenario.script) if order.command is not None]
        assert [order.command for order in orders] == [
            *(order.command for order in scenario.orders),
            Command.QUIT,
        ]
        assert [order.background for order in orders[:-1]] == [order.background for order in scenario.orders]
        parse_scenario(scenario.bench, verdin)


def test_the_script_of_the_cancel(verdin: Description) -> None:
    assert of(verdin, "cancel").script == ("wait 0.5; lock; wait 0.5; grip &; wait 3; cancel; wait 0.5; quit")


@pytest.mark.parametrize(
    ("holds", "after"),
    [
        (("bottom_vacuum", "cylinder"), [EndEffectorState.GRIP_ERROR]),
        (("cylinder",), [EndEffectorState.RELEASING, EndEffectorState.GRIP_ERROR]),
        (("top_vacuum",), [EndEffectorState.RELEASING, EndEffectorState.STAND_BY]),
    ],
)
def test_the_declared_endings_are_expected(holds: tuple[str, ...], after: list[EndEffectorState]) -> None:
    own = {name: {"gripping": {"cancel": "hold", "abort": "hold"}} for name in holds}
    expected = of(declared(**own), "cancel").expected
    assert list(expected.states[2:]) == after
    assert expected.commands[-1] is Command.CANCEL
    aborted = of(declared(**own), "never-confirms").expected
    error = EndEffectorState.GRIP_ERROR
    assert list(aborted.states[2:]) == (after if after == [error] else [error, *after])


def with_codec(description: Description, codec: str) -> Description:
    link = description.link.model_copy(update={"codec": codec})
    return description.model_copy(update={"link": link})


def test_an_unlock_is_armed_where_no_sensor_shows_the_stand(verdin: Description) -> None:
    assert "arm" not in of(verdin, "unlock-lock").script
    nibble = with_codec(verdin, "legacy-nibble")
    scenario = of(nibble, "unlock-lock")
    assert "; arm; unlock; wait 0.25; lock; " in scenario.script
    assert [order.arm for order in read_script(scenario.script)].count(True) == 1
    free = nibble.model_copy(update={"interlocks": nibble.interlocks.model_copy(update={"il_02": False})})
    assert "arm" not in of(free, "unlock-lock").script


@pytest.mark.parametrize(("longest_s", "waits_s"), [(3.0, 1.0), (1.0, 0.23), (0.3, 0.0)])
def test_it_is_locked_again_before_il_03_ends_the_unlock(
    verdin: Description, longest_s: float, waits_s: float
) -> None:
    changer = verdin.tool_changer
    assert changer
    other = changer.model_copy(update={"unlock_max_s": longest_s})
    orders = of(verdin.model_copy(update={"tool_changer": other}), "unlock-lock").orders
    assert orders[0].wait_s == pytest.approx(waits_s)


def test_what_no_sensor_could_prove_is_not_played_and_why(verdin: Description) -> None:
    blind = with_codec(verdin, "modbus-rtu-transmitters")
    assert [each.name for each in scenarios(blind, everything=True)] == NAMES[:5]
    why = "modbus-rtu-transmitters carries no locked_bit and no unlocked_bit, so that no unlock is accepted."
    assert unplayable(blind) == {"unlock-lock": why}
    assert unplayable(without_changer(blind)) == unplayable(verdin) == {}
