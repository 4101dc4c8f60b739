"""Evidence that no value of its channels can show is refused; what holds at once is warned of."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import match_codec
from end_effector_hal.description import examine_text

BITS = "p: {text: {field: 1}}, q: {text: {field: 2}}"
RANGED = "p: {text: {field: 1}, unit: kPa, range: [-40, 10]}"
PRESSURE = "p: {text: {field: 1}, unit: kPa}"
HIGH = "p: {text: {field: 1}, unit: bar, range: [0, 4]}"


def matched(channels: str, actuator: str) -> tuple[list[str], list[str]]:
    """Faults and warnings of a tool; the actuator stands in line 5, from column 11 on."""
    text = (
        f"name: tool\nlink: {{port: x, frame: {{text: {{}}}}}}\nchannels: {{{channels}}}\nsequence: [cup]\n"
        f"actuators: {{cup: {{{actuator}}}}}\nsupply: {{channel: none}}\n"
    )
    examination = examine_text(text, "tool.yaml")
    assert examination.description is not None, examination.lines()
    match = match_codec(examination.description)
    return [f"{each.line}:{each.column}: {each.message}" for each in match.faults], list(match.slow)


def cup(evidence: str) -> str:
    return f"kind: vacuum, line: A, channel: none, evidence: {{{evidence}}}"


@pytest.mark.parametrize(
    ("channels", "actuator", "said"),
    [
        (
            BITS,
            cup("confirmed: {all: [{on: p}, {not: {on: p}}]}, gone: {on: q}"),
            ["5:79: 'confirmed' of 'cup' can never hold, expected a condition that can hold"],
        ),
        (
            BITS,
            cup("confirmed: {on: p}, gone: {on: q}, empty: {on: p}"),
            ["5:79: 'confirmed' of 'cup' never holds without 'empty', expected what 'empty' does not show"],
        ),
        (
            RANGED,
            cup("confirmed: {channel: p, below_kpa: -55}, gone: {channel: p, above_kpa: -10}"),
            [
                "5:79: 'confirmed' of 'cup' can never hold, expected something between -40 and 10 kPa, the range of p"
            ],
        ),
        (
            PRESSURE,
            cup("confirmed: {channel: p, below_kpa: -55}, gone: {channel: p, below_kpa: -10}"),
            ["5:79: 'confirmed' of 'cup' never holds without 'gone', expected what 'gone' does not show"],
        ),
        (
            RANGED,
            "kind: vacuum, line: A, channel: p",
            [
                "5:51: 'cup' can never be confirmed: that takes -55 kPa, "
                "expected something between -40 and 10 kPa, the range of p"
            ],
        ),
        (
            HIGH,
            "kind: cylinder, line: A, channel: p, extended_bit: none, retracted_bit: none",
            [
                "5:53: 'cup' can never be confirmed: that takes 510 kPa, "
                "expected something between 0 and 400 kPa, the range of p"
            ],
        ),
        (PRESSURE, "kind: vacuum, line: A, channel: p", []),
        (BITS, cup("confirmed: {on: p}, gone: {on: q}, empty: {all: [{not: {on: p}}, {not: {on: q}}]}"), []),
    ],
)
def test_what_no_value_shows_is_refused(channels: str, actuator: str, said: list[str]) -> None:
    assert matched(channels, actuator)[0] == said


def test_one_sensor_that_shows_both_is_warned_of_and_two_are_not() -> None:
    both = cup("confirmed: {channel: p, below_kpa: -10}, gone: {channel: p, above_kpa: -50}")
    faults, warnings = matched(PRESSURE, both)
    assert faults == []
    (warning,) = warnings
    what = (
        "cup: evidence: 'confirmed' and 'gone' hold at once where p has -50 to -10 kPa: it is unknown there"
    )
    assert warning.startswith(f"{what} (")
    assert warning.endswith("tool.yaml:5:115)")
    assert matched(BITS, cup("confirmed: {on: p}, gone: {on: q}")) == ([], [])
