"""Thresholds from a recording: between what was seen at rest and while a part was held, or a refusal in words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from end_effector_hal.cli.listen._suggest import SHARES, SeenLevel, Suggestion, print_suggestions, suggestions
from end_effector_hal.description import Description, examine_text, load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import PressuresLog, StatesLog, StatesRow
from end_effector_hal.vocabulary import Command, EndEffectorState

SHIPPED = profile_path().read_text(encoding="utf-8")
REST, HELD = EndEffectorState.STAND_BY, EndEffectorState.GRIPPED
NAMES = ("bottom_vacuum", "cylinder", "top_vacuum")


def recorded(rest_kpa: float, held_kpa: float, *states: EndEffectorState) -> tuple[StatesLog, PressuresLog]:
    """Four seconds of each state; at its begin a pressure is on its way."""
    rows, samples = [], []
    for number, state in enumerate(states):
        active, begin = state is HELD, 4.0 * number
        rows.append(StatesRow(begin, state, Command.NONE, (2 if active else 0,) * 3))
        for at in range(40):
            kpa = held_kpa if active else rest_kpa
            value = -50.0 if at < 10 else -kpa - 0.1 * (at % 3)
            samples.append((begin + at / 10, (value, 0.0, value, 600.0)))
    channels = ("bottom", "cylinder", "top", "supply")
    return StatesLog(NAMES, tuple(rows)), PressuresLog(channels, tuple(samples))


def only(tool: Description, states: StatesLog, pressures: PressuresLog) -> Suggestion:
    found = {
        each.actuator: each for each in suggestions(tool, states, pressures) if isinstance(each, Suggestion)
    }
    assert set(found) == {"bottom_vacuum", "top_vacuum"}
    return found["bottom_vacuum"]


@pytest.mark.parametrize(("rest_kpa", "held_kpa"), [(0.5, 80.5), (8.0, 45.0), (0.0, 100.0), (-2.0, 30.0)])
def test_they_lie_between_the_levels_and_a_description_takes_them(
    verdin: Description, rest_kpa: float, held_kpa: float
) -> None:
    found = only(verdin, *recorded(rest_kpa, held_kpa, REST, HELD, REST))
    # what is still on its way counts for neither level
    assert (found.rest.low, found.rest.high) == pytest.approx((rest_kpa, rest_kpa + 0.2))
    assert (found.held.low, found.held.high) == pytest.approx((held_kpa, held_kpa + 0.2))
    assert (found.rest.spans, found.held.spans) == (2, 1)
    values = found.thresholds
    assert rest_kpa + 0.2 < values["gone_kpa"] < values["lost_kpa"] < values["confirmed_kpa"] < held_kpa
    keys = "".join(f"\n    {key}: {value}" for key, value in values.items())
    written = SHIPPED.replace("    confirmed_kpa: 55.0", "    #").replace("    gone_kpa: 10.0\n", "")
    written = written.replace("    lost_kpa: 50.0", keys.lstrip("\n"))
    assert examine_text(written, "tool.yaml").lines() == []


def test_each_has_its_evidence_in_words(verdin: Description) -> None:
    found = only(verdin, *recorded(1.0, 81.0, REST, HELD, REST))
    assert found.why("confirmed_kpa") == "75% of the way from at most 1.2 at rest to at least 81.0 held"
    assert {key for key in SHARES if found.why(key)} == set(found.thresholds)


@pytest.mark.parametrize(
    ("recording", "said"),
    [
        (recorded(0, 80, REST), "does not show it held (GRIPPED) for a while: record a grip and a drop."),
        (recorded(0, 80, HELD), "does not show it at rest (STAND_BY) for a while: record a grip and a drop."),
        (recorded(30, 40, REST, HELD), "for 1.8 s: closer than 15 kPa, no threshold fits between."),
    ],
)  # fmt: skip
def test_what_is_not_shown_is_refused_in_words(
    verdin: Description, recording: tuple[StatesLog, PressuresLog], said: str
) -> None:
    found = list(suggestions(verdin, *recording))
    assert not [each for each in found if isinstance(each, Suggestion)]
    assert str(found[0]).startswith("bottom_vacuum: ")
    assert str(found[0]).endswith(said)


def test_a_recording_of_another_tool_and_an_empty_one(verdin: Description) -> None:
    states, pressures = recorded(0, 80, REST, HELD)
    other = replace(pressures, channels=("a", "b", "c", "d"))
    assert "bottom_vacuum: the recording has no pressure 'bottom' of it." in list(
        suggestions(verdin, states, other)
    )
    assert list(suggestions(verdin, states, replace(pressures, samples=()))) == ["The recording is empty."]


def test_a_tool_of_switches_has_no_thresholds(tmp_path: Path) -> None:
    tool = load(Path("examples/tools/six_cups/end_effector.yaml"))
    with pytest.raises(UsageError, match=r"^Switches have no thresholds: this tool has no pressure"):
        print_suggestions(tool, tmp_path, as_json=False)


def test_nothing_is_minus_zero() -> None:
    assert str(SeenLevel(-0.04, 0.2, 1, 1.0)) == "0.0 to 0.2 kPa for 1.0 s"
