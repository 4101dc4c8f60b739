"""The testbench plays the sensors on a board's inputs: levels of a virtual chip, files of a converter."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.description import Description, examine_text, load
from end_effector_hal.errors import UsageError
from end_effector_hal.wires.lines import VirtualChip, read_chip
from end_effector_lab.testbench import (
    BoardSensors,
    open_ports,
    open_sensors,
    parse_scenario,
    write_virtual_copy,
)

TOOL = """
schema: 2
name: mixed
lines: {{backend: virtual, path: {folder}/chip}}
inputs: {{iio: {folder}/iio}}
channels:
  switch: {{digital: {{line: A, bias: pull_up}}, invert: true}}
  cup: {{analog: {{device: ads1015, channel: voltage0}}, unit: kPa, scale: 0.05, offset: -100}}
sequence: [one, two]
actuators:
  one: {{kind: vacuum, line: OUT1, channel: switch}}
  two: {{kind: vacuum, line: OUT2, channel: cup}}
supply: {{channel: none}}
"""


@pytest.fixture
def tool(tmp_path: Path) -> Description:
    description = examine_text(TOOL.format(folder=tmp_path), tmp_path / "tool.yaml").description
    assert description
    return description


@pytest.fixture
def sensors(tool: Description, tmp_path: Path) -> BoardSensors:
    VirtualChip.create(tmp_path / "chip", ["A", "OUT1", "OUT2"], {"A": "up"})
    sensors = BoardSensors(tool, tmp_path / "chip")
    sensors.start()
    return sensors


def high(folder: Path) -> bool:
    return read_chip(folder / "chip").lines["A"].level


def test_a_pressure_closes_the_switch_and_counts_at_the_converter(
    sensors: BoardSensors, tmp_path: Path
) -> None:
    adc = tmp_path / "iio/iio:device0"
    assert (adc / "name").read_text() == "ads1015\n"
    assert (adc / "in_voltage0_scale").read_text() == "0.0625\n"
    sensors.play({"switch": -10_000, "cup": -50_000}, silent=False)
    assert high(tmp_path)  # inverted: no vacuum
    assert (adc / "in_voltage0_raw").read_text() == "16000\n"  # 1000 mV
    sensors.play({"switch": -60_000, "cup": -100_000}, silent=False)
    assert not high(tmp_path)
    assert (adc / "in_voltage0_raw").read_text() == "0\n"


def test_what_shows_nothing_lets_its_line_go_and_has_no_file(sensors: BoardSensors, tmp_path: Path) -> None:
    raw = tmp_path / "iio/iio:device0/in_voltage0_raw"
    sensors.play({"switch": -60_000, "cup": -50_000}, silent=False)
    sensors.play({"switch": None, "cup": None}, silent=False)
    assert high(tmp_path)
    assert not raw.exists()
    sensors.play({"switch": -60_000, "cup": -50_000}, silent=False)
    assert not high(tmp_path)
    assert raw.exists()


def test_silence_leaves_the_lines_as_they_are(sensors: BoardSensors, tmp_path: Path) -> None:
    sensors.play({"switch": -60_000, "cup": -50_000}, silent=False)
    sensors.play({"switch": 0, "cup": 0}, silent=True)
    assert not high(tmp_path)
    assert not (tmp_path / "iio/iio:device0/in_voltage0_raw").exists()


def test_a_virtual_copy_has_its_chip_and_its_folder_beside_it(tool: Description, tmp_path: Path) -> None:
    copy = load(write_virtual_copy(tool, tmp_path / "copy"))
    assert copy.inputs
    assert copy.inputs.iio == str(tmp_path / "copy/iio")
    assert read_chip(tmp_path / "copy/chip").lines["A"].level


def test_where_inputs_cannot_be_played(tool: Description) -> None:
    assert open_ports(None, tool, None) == {}
    with pytest.raises(
        UsageError,
        match=r"mixed has no sensor link: there is nothing for --port /dev/ttyS0\. Leave out --port\.",
    ):
        open_ports("/dev/ttyS0", tool, None)
    with pytest.raises(UsageError, match=r"digital inputs .* cannot be simulated at 'rpi3'"):
        open_sensors("rpi3", tool)
    kernels = tool.model_copy(update={"inputs": None})
    with pytest.raises(UsageError, match="cannot be simulated in the kernel's own folder"):
        open_sensors(None, kernels)


def test_faults_of_a_link_are_refused_where_there_is_none(tool: Description, verdin: Description) -> None:
    for fault in ("noise:0.1", "babble-after:1", "reboot-after:1"):
        parse_scenario(fault, verdin)
        with pytest.raises(UsageError, match=f"'{fault}' is a fault of a sensor link, and mixed has none"):
            parse_scenario(fault, tool)
    parse_scenario("silent-after:1,shows:one:60", tool)


def test_a_tool_without_inputs_has_no_such_sensors(verdin: Description) -> None:
    assert open_sensors(None, verdin) is None
