"""Channels of other quantities than pressure, as evidence and wherever their values are shown."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.cli.listen._channel_view import scaled
from end_effector_hal.cli.listen._listen import print_words
from end_effector_hal.codecs import carrier_of, codec_of, match_codec
from end_effector_hal.description import QUANTITIES, Description, examine_text, measures_of
from end_effector_hal.kinds.conditions import shown
from end_effector_hal.recording import Recording, pressure_channels, read_pressures, read_run
from end_effector_hal.sensing import Readings
from end_effector_hal.signals import Frame, Kind
from end_effector_hal.vocabulary import Evidence
from end_effector_lab.figures._panels import panels_of
from end_effector_lab.testbench import Bench, SensorBoard
from end_effector_lab.virtual import VirtualTool

TOOL = """\
name: pusher
link: {port: /dev/a, frame: {text: {start: "$"}}}
channels:
  gap: {text: {field: 1, decimals: 2}, unit: mm, range: [0, 60], invalid: [99]}
  fill: {text: {field: 2}, unit: "%", scale: 0.1, offset: -10}
  cup: {text: {field: 3}, unit: kPa}
sequence: [jaw]
actuators:
  jaw:
    kind: gripper
    line: A
    evidence:
      confirmed: {all: [{channel: gap, between: [12.25, 14], for_ms: 60}, {channel: fill, above: 40}]}
      gone: {channel: gap, above: 50, for_ms: 60}
      empty: {channel: gap, below: 2, for_ms: 60}
supply: {channel: none}
"""


@pytest.fixture(scope="module")
def tool() -> Description:
    found = examine_text(TOOL, "tool.yaml").description
    assert found
    assert not match_codec(found).faults
    return found


def faults(text: str) -> list[str]:
    examined = examine_text(text, "tool.yaml")
    found = list(examined.faults)
    if examined.description:
        found += match_codec(examined.description).faults
    return [str(each.diagnostic("tool.yaml")) for each in found]


def test_a_value_is_in_thousandths_of_its_unit_and_comes_back(tool: Description) -> None:
    codec = codec_of(tool)
    assert codec.channels["gap"] is Kind.QUANTITY
    (frame,) = codec.decoder().feed(b"$12.30,523,-70\n", 1000)
    assert frame.values == {"gap": 12_300, "fill": 42_300, "cup": -70_000}
    (again,) = codec.decoder().feed(codec.encode(frame), 1000)
    assert again.values == frame.values
    (beyond,) = codec.decoder().feed(b"$60.01,523,-70\n$99,523,-70\n", 1000)[:1]
    assert beyond.values["gap"] is None


def test_a_grip_in_virtual_time_is_proven_by_a_distance(tool: Description) -> None:
    bench = VirtualTool(tool)
    bench.run(1.0)
    assert bench.status.evidence == (Evidence.GONE,)
    assert bench.command("grip").accepted
    bench.run(2.0)
    assert (bench.status.ee.name, bench.status.evidence) == ("GRIPPED", (Evidence.CONFIRMED,))
    assert bench.command("drop").accepted
    bench.run(2.0)
    assert bench.status.ee.name == "STAND_BY"


def test_no_part_is_empty_by_a_distance(tool: Description) -> None:
    bench = VirtualTool(tool, "no-part:jaw")
    bench.run(1.0)
    assert bench.command("grip").accepted
    bench.run(30.0)
    assert "closed on nothing" in bench.status.reason or "gripped nothing" in bench.status.reason


def test_the_testbench_sends_what_its_conditions_ask_for(tool: Description) -> None:
    board = SensorBoard(tool, Bench(tool), 0)
    (frame,) = codec_of(tool).decoder().feed(board.frame(20_000).data, 20_000)
    assert 50_000 < (frame.values["gap"] or 0) <= 60_000


def test_it_is_shown_in_its_unit_with_the_decimals_of_its_thresholds(
    tool: Description, capsys: pytest.CaptureFixture[str]
) -> None:
    measures = measures_of(tool)
    assert measures["gap"] == ("mm", 2)
    assert scaled(12_304, Kind.QUANTITY, measures["gap"]) == "12.30 mm"
    readings = Readings(tool, carrier_of(tool))
    readings.take(Frame(1000, None, None, {"gap": 12_304, "fill": 42_000, "cup": -70_000}))
    said = shown(["gap", "fill", "cup"], readings, 1000)
    assert said == "gap is at 12.30 mm, fill is at 42.0 %, cup is at -70.0 kPa"
    event = {
        "event": "channel",
        "time_s": 1.0,
        "channel": "gap",
        "raw": 12.304,
        "value": 12.304,
        "unit": "mm",
    }
    print_words(measures.__getitem__, event | {"state": "fresh"})
    assert capsys.readouterr().out.endswith(" gap 12.30 mm (raw 12.304)\n")


def test_a_threshold_that_is_finer_than_a_tenth_of_a_kilopascal_shows(tool: Description) -> None:
    fine = TOOL.replace(
        "gone: {channel: gap, above: 50, for_ms: 60}", "gone: {channel: cup, above_kpa: -0.02}"
    )
    description = examine_text(fine, "tool.yaml").description
    assert description
    assert measures_of(description)["cup"] == ("kPa", 2)


def _record(description: Description, folder: Path) -> None:
    clock = [1_000_000]
    recording = Recording(folder, description, now=lambda: clock[0])
    recording.state(1_000_000, 0, -1, (0,))
    for number in range(10):
        clock[0] += 20_000
        recording.values(clock[0], {"gap": 12_304, "fill": 42_000 + number, "cup": -70_000})
    recording.close()


def test_the_table_and_the_wide_table_name_the_unit(tool: Description, tmp_path: Path) -> None:
    assert pressure_channels(tool) == ("gap", "fill")
    _record(tool, tmp_path)
    header, first, *_ = (tmp_path / "pressures.csv").read_text().splitlines()
    assert header == "time_s,gap_mm,fill_percent"
    assert first.endswith(",12.304,42.000")
    log = read_pressures(tmp_path / "pressures.csv")
    assert (log.channels, log.units) == (("gap", "fill"), {"gap": "mm", "fill": "%"})


def test_the_figure_has_a_panel_for_each_unit(tool: Description, tmp_path: Path) -> None:
    _record(tool, tmp_path)
    log = read_pressures(tmp_path / "pressures.csv")
    panels = panels_of(log, read_run(tmp_path), tool.sequence)
    assert [(each.title, [curve.title for curve in each.curves]) for each in panels] == [
        ("measured\n[mm]", ["Gap"]),
        ("measured\n[%]", ["Fill"]),
    ]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("above: 50", "above_kpa: 50", "'gap' is measured in mm (above_kpa), expected above: …, in mm"),
        ("gap, above: 50", "cup, above: 50", "'cup' is a pressure (above), expected above_kpa: …, gauge kPa"),
        (
            "supply: {channel: none}",
            "supply: {channel: gap}",
            "'gap' is measured in mm (gap), expected a pressure",
        ),
        ("kind: gripper", "kind: gripper\n    part_bit: gap", "'gap' is a quantity"),
        ("between: [12.25, 14]", "between: [14, 12]", "'between' is no range"),
        ("unit: mm", "unit: cm", "mm"),
        (
            "confirmed: {all: [{channel: gap, between",
            "confirmed: {all: [{channel: gapp, between",
            "carries no 'gapp'",
        ),
        ("above: 50", "above: 70", "can never hold"),
    ],
)
def test_what_cannot_be_meant_is_said_where_it_stands(old: str, new: str, said: str) -> None:
    assert old in TOOL
    found = faults(TOOL.replace(old, new, 1))
    assert any(said in each for each in found), found


def test_a_vacuum_judges_no_distance() -> None:
    text = TOOL[: TOOL.index("actuators:")] + (
        "actuators: {jaw: {kind: vacuum, line: A, channel: gap}}\nsupply: {channel: none}\n"
    )
    (said,) = [each for each in faults(text) if "gap" in each]
    assert "'gap' is measured in mm" in said


@pytest.mark.parametrize("unit", QUANTITIES)
def test_each_unit_has_a_column_that_is_read_back(unit: str, tool: Description, tmp_path: Path) -> None:
    text = TOOL.replace("unit: mm", f'unit: "{unit}"')
    description = examine_text(text, "tool.yaml").description
    assert description
    _record(description, tmp_path)
    log = read_pressures(tmp_path / "pressures.csv")
    assert (log.channels, log.units["gap"]) == (("gap", "fill"), unit)
