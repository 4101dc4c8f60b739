"""What a switch says by itself, in the words of the conditions that prove its actuator."""

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.kinds import SwitchMeaning, switch_meanings
from end_effector_hal.kinds.stanza import EvidenceConditions

TOOLS = Path("examples/tools")


@pytest.mark.parametrize(
    ("tool", "actuator", "expected"),
    [
        ("six_cups", "cup_1", {"switch_1": ("confirmed", "gone")}),
        # neither open nor closed proves a part: no switch alone does
        ("double_acting_jaw", "jaw", {"jaw_open": ("gone", ""), "jaw_closed": ("empty", "")}),
        ("bistable_and_magnet", "cylinder", {"down": ("confirmed", ""), "up": ("retracted", "")}),
        ("bistable_and_magnet", "magnet", {"part": ("confirmed", "gone")}),
    ],
)
def test_of_the_examples(tool: str, actuator: str, expected: dict[str, tuple[str, str]]) -> None:
    description = load_tool(TOOLS / tool / "end_effector.yaml")
    assert switch_meanings(description.actuators[actuator]) == {
        name: SwitchMeaning(*words) for name, words in expected.items()
    }


def test_of_declared_evidence(verdin: Description) -> None:
    """Inverted, together with another, or only in a fault; a pressure is no switch."""
    conditions = {
        "confirmed": {"all": [{"on": "a"}, {"not": {"on": "b"}}, {"channel": "p", "above_kpa": 5}]},
        "gone": {"any": [{"not": {"on": "a"}}, {"on": "b"}]},
        "fault": {"on": "c"},
    }
    evidence = EvidenceConditions.model_validate(conditions)
    actuator = verdin.actuators["cylinder"].model_copy(update={"evidence": evidence})
    assert switch_meanings(actuator) == {
        "a": SwitchMeaning("confirmed", "gone"),
        "b": SwitchMeaning("gone", ""),
        "c": SwitchMeaning("", ""),
    }


def test_in_words() -> None:
    meaning = SwitchMeaning("confirmed", "")
    assert [meaning.words(level) for level in (True, False, None)] == ["on: confirmed", "off", "not known"]
