"""What samples the sensors: a board that sends frames, and sensors on inputs of the board."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from end_effector_hal.codecs import Decoder, asks, codec_names, codec_of
from end_effector_hal.description import Description, examine_text, load
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Frame
from end_effector_hal.wires.lines import VirtualChip, read_chip
from end_effector_lab.testbench import (
    Bench,
    BoardSensors,
    SensorBoard,
    open_ports,
    open_sensors,
    parse_scenario,
    write_virtual_copy,
)

PERIOD = 20_000
CHANNELS = {
    "modbus-rtu-epick": {"bottom_vacuum": "vacuum"},
    "modbus-rtu-onrobot-vg": {"bottom_vacuum": "vacuum_a", "top_vacuum": "vacuum_b"},
}


class Link:
    """A board and a decoder on one wire."""

    def __init__(self, description: Description, scenario: str, codec: str = "ees1-ascii") -> None:
        link = description.link.model_copy(update={"codec": codec})
        description = description.model_copy(update={"link": link})
        self.codec = codec_of(description)
        self.bench = Bench(description, scenario)
        self.board = SensorBoard(description, self.bench, 0)
        self.decoder: Decoder = self.codec.decoder()
        self.at = 0

    def run(self, seconds: float) -> list[Frame]:
        until = self.at + round(seconds * 1e6)
        return list(self._polled(until) if asks(self.decoder) else self._streamed(until))

    def _streamed(self, until: int) -> Iterator[Frame]:
        while self.at < until:
            yield from self.decoder.feed(self.board.frame(self.at).data, self.at)
            self.at += self.codec.period_us

    def _polled(self, until: int) -> Iterator[Frame]:
        decoder = self.decoder
        assert asks(decoder)
        while self.at < until:
            self.at = max(self.at, decoder.due)
            polled = decoder.poll(self.at)
            yield from polled.frames
            sent = self.board.answer(polled.data, self.at)
            if sent is not None:
                yield from decoder.feed(sent.data, self.at + 1_000)


@pytest.mark.parametrize("codec", codec_names())
def test_every_codec_can_be_spoken(verdin: Description, codec: str) -> None:
    actuators = {
        name: actuator.model_copy(update={"channel": CHANNELS.get(codec, {}).get(name, actuator.channel)})
        for name, actuator in verdin.actuators.items()
    }
    tool = verdin.model_copy(update={"actuators": actuators})
    link = Link(tool, "nominal", codec)
    frames = link.run(5.0)
    assert len(frames) >= 4
    assert sum(link.decoder.errors.values()) == link.decoder.lost == 0


@pytest.mark.parametrize("codec", ["ees1-ascii", "ees1-cobs"])
def test_a_reboot_is_a_silence_and_begins_anew(verdin: Description, codec: str) -> None:
    link = Link(verdin, "reboot-after:1", codec)
    frames = link.run(2.0)
    gap = [one.at for one, other in pairwise(frames) if other.at - one.at > PERIOD]
    assert gap == [980_000]
    after = [frame for frame in frames if frame.at > 1_000_000]
    assert (after[0].at, after[0].seq, after[0].device_ms) == (1_300_000, 0, 0)
    assert link.decoder.reboots == 1
    link.bench.choose("nominal", link.at)
    assert link.run(1.0)[0].seq == len(after)  # it goes on counting from there


def test_a_reboot_just_before_the_next_scenario_is_one_reboot(verdin: Description) -> None:
    link = Link(verdin, "reboot-after:1")
    link.run(1.1)
    link.bench.choose("nominal", link.at)
    assert link.run(1.0)[0].at == 1_300_000
    assert link.decoder.reboots == 1


def test_a_frozen_sensor_stays_and_its_number_goes_on(verdin: Description) -> None:
    frames = Link(verdin, "frozen-after:top_vacuum:0.5").run(1.0)
    assert len({frame.values["top"] for frame in frames[:25]}) > 10
    assert len({frame.values["top"] for frame in frames[25:]}) == 1
    assert len({frame.values["bottom"] for frame in frames[25:]}) > 10


def test_a_sensor_that_shows_what_is_not_there(verdin: Description) -> None:
    frames = Link(verdin, "shows:bottom_vacuum:300").run(0.1)
    assert frames[0].values["bottom"] == pytest.approx(300_000, abs=1000)


def test_swapped_sensors(verdin: Description) -> None:
    link = Link(verdin, "swapped:bottom_vacuum")
    link.bench.line("SODIMM_208", True, 0)
    last = link.run(2.0)[-1].values
    assert last["cylinder"] == pytest.approx(-82_000, abs=3000)
    assert last["bottom"] == pytest.approx(0, abs=1000)


@pytest.mark.parametrize(
    "fault", ["noise:0.02", "flips:0.003", "bursts:0.3", "lost-bytes:0.01", "doubled-bytes:0.01"]
)
@pytest.mark.parametrize("codec", ["ees1-ascii", "ees1-cobs"])
def test_what_comes_through_a_bad_cable_is_true(verdin: Description, codec: str, fault: str) -> None:
    good = {frame.seq: frame.values for frame in Link(verdin, "nominal", codec).run(10.0)}
    link = Link(verdin, fault, codec)
    frames = link.run(10.0)
    assert 50 < len(frames) < 480
    assert all(good[frame.seq] == frame.values for frame in frames)
    assert sum(link.decoder.errors.values()) > 0


@pytest.mark.parametrize("codec", ["ees1-ascii", "ees1-cobs", "modbus-rtu-transmitters"])
def test_babble_is_no_frame(verdin: Description, codec: str) -> None:
    link = Link(verdin, "babble-after:1", codec)
    frames = link.run(5.0)
    assert frames
    assert all(frame.at <= 1_000_000 for frame in frames)


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
