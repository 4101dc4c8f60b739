"""Values that somebody types instead of those that were recorded."""

from __future__ import annotations

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import DescriptionError, ReportedError, UsageError
from end_effector_hal.verification.whatif import MOST_TEXT, changed_description, in_short

TOOL = load(profile_path())


def test_values_are_put_into_what_was_recorded() -> None:
    text = (
        "# shorter\nactuators.cylinder.timeout_s: 2\nactuators.bottom_vacuum.confirmed_kpa = 60.5  # more\n"
    )
    changed = changed_description(text, TOOL)
    assert changed.actuators["cylinder"].timeout_s == 2
    assert changed.model_dump()["actuators"]["bottom_vacuum"]["confirmed_kpa"] == 60.5
    assert changed.automata_path.read_bytes() == TOOL.automata_path.read_bytes()
    kept = TOOL.actuators["top_vacuum"]
    assert changed.actuators["top_vacuum"] == kept


def test_a_whole_description_is_taken() -> None:
    text = profile_path().read_text().replace("timeout_s: 5.0", "timeout_s: 2.5")
    assert changed_description(text, TOOL).actuators["bottom_vacuum"].timeout_s == 2.5


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("actuators.cylinder.timeut_s: 2", "did you mean 'timeout_s'"),
        ("actuators.bottom_vacuum.lost_kpa: 60", "lost_kpa"),
        ("actuators.cylinder.timeout_s: soon", "timeout_s"),
        ("sequence.7: cylinder", "no sequence.7"),
        ("", "Nothing is said"),
        ("just words", "what-if.yaml"),
        ("a: " + "[" * 5000, "what-if.yaml"),
        ("x" * (MOST_TEXT + 1), "longer than"),
    ],
)
def test_what_makes_no_tool_is_refused_in_words(text: str, said: str) -> None:
    with pytest.raises(ReportedError) as caught:
        changed_description(text, TOOL)
    assert isinstance(caught.value, UsageError | DescriptionError)
    assert said in in_short(caught.value)
    assert "/eehal-what-if-" not in in_short(caught.value)


def test_no_other_file_is_read() -> None:
    text = f"{profile_path().read_text()}\nautomata:\n  file: /etc/hostname\n"
    with pytest.raises(ReportedError, match="automata are those of the recording"):
        changed_description(text, TOOL)
