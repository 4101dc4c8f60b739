"""Analog inputs through Linux IIO: a folder with the same files as sysfs."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from end_effector_hal.description import Channel
from end_effector_hal.wires.inputs import AnalogReader


class Converter:
    """A device as the kernel shows it."""

    def __init__(self, folder: Path, number: int = 0, name: str = "ads1015") -> None:
        self.folder = folder / f"iio:device{number}"
        self.folder.mkdir(parents=True)
        (self.folder / "name").write_text(f"{name}\n")

    def put(self, **files: object) -> None:
        for name, text in files.items():
            (self.folder / f"in_{name}").write_text(f"{text}\n")


@pytest.fixture
def adc(tmp_path: Path) -> Converter:
    return Converter(tmp_path)


def channel(device: str = "ads1015", of: str = "voltage0", **keys: object) -> Channel:
    return Channel.model_validate(
        {"analog": {"device": device, "channel": of}, "unit": "kPa", "scale": 0.05, "offset": -100, **keys}
    )


def reader(adc: Converter, now: list[int] | None = None, **channels: Channel) -> AnalogReader:
    time = now or [0]
    return AnalogReader(adc.folder.parent, channels or {"cup": channel()}, lambda: time[0])


@pytest.mark.parametrize(
    ("files", "pascal"),
    [
        ({"voltage0_raw": 1000}, -50_000),  # a driver without a scale counts mV
        ({"voltage0_raw": 16000, "voltage_scale": 0.0625}, -50_000),  # shared by all channels
        ({"voltage0_raw": 16000, "voltage0_scale": 0.125, "voltage_scale": 9}, 0),  # its own comes first
        ({"voltage0_raw": 15900, "voltage0_offset": 100, "voltage0_scale": 0.0625}, -50_000),
        ({"voltage0_raw": -8, "voltage0_scale": 0.0625}, -100_025),
        ({"voltage0_input": 1000}, -50_000),  # in the unit of the driver already
    ],
)
def test_raw_scale_and_offset_of_the_driver(adc: Converter, files: dict[str, object], pascal: int) -> None:
    adc.put(**files)
    assert reader(adc).read("cup") == pascal


def test_a_differential_channel_and_its_shared_scale(adc: Converter) -> None:
    adc.put(**{"voltage0-voltage1_raw": 16000, "voltage-voltage_scale": 0.0625})
    assert reader(adc, cup=channel(of="voltage0-voltage1")).read("cup") == -50_000


def test_beyond_its_range_or_what_the_device_says_when_it_has_none(adc: Converter) -> None:
    adc.put(voltage0_raw=2500)
    assert reader(adc, cup=channel(range=[-101, 10])).read("cup") is None
    assert reader(adc, cup=channel(invalid=[2500])).read("cup") is None


@pytest.mark.parametrize("text", ["", "none", "nan", "inf", "1" * 400, "\x00\xff"])
def test_what_is_no_number_is_invalid_and_told(adc: Converter, text: str) -> None:
    (adc.folder / "in_voltage0_raw").write_bytes(text.encode("latin-1"))
    inputs = reader(adc)
    assert inputs.read("cup") is None
    if "1" not in text:
        assert "not a number" in inputs.errors["cup"]
    adc.put(voltage0_raw=1000)
    assert inputs.read("cup") == -50_000
    assert not inputs.errors


def test_a_file_that_is_gone_a_folder_and_a_pipe_in_its_place(adc: Converter) -> None:
    inputs, raw = reader(adc), adc.folder / "in_voltage0_raw"
    assert inputs.read("cup") is None
    assert "in_voltage0_raw: No such file" in inputs.errors["cup"]
    raw.mkdir()
    assert inputs.read("cup") is None
    assert "Is a directory" in inputs.errors["cup"]
    raw.rmdir()
    os.mkfifo(raw)
    assert inputs.read("cup") is None  # and nobody waits for its writer


def test_a_device_that_comes_back_under_another_number(adc: Converter) -> None:
    adc.put(voltage0_raw=1000)
    now = [0]
    inputs = reader(adc, now)
    assert inputs.read("cup") == -50_000
    adc.folder.rename(adc.folder.with_name("gone"))
    (adc.folder.with_name("gone") / "name").write_text("other\n")
    assert inputs.read("cup") is None
    again = Converter(adc.folder.parent, 3)
    again.put(voltage0_raw=2000)
    now[0] += 100_000
    inputs.read("cup")
    now[0] += 10_000_000
    assert inputs.read("cup") == 0


def test_a_device_that_is_missing_is_looked_for_more_and_more_seldom(
    adc: Converter, monkeypatch: pytest.MonkeyPatch
) -> None:
    from end_effector_hal.wires.inputs import _analog

    looked: list[int] = []
    now, find = [0], _analog.find_device
    monkeypatch.setattr(_analog, "find_device", lambda *given: (looked.append(now[0]), find(*given))[1])
    inputs = reader(adc, now, cup=channel("max1363"))
    for now[0] in range(0, 20_000_000, 20_000):
        assert inputs.read("cup") is None
    assert [round(at / 1e6, 1) for at in looked] == [0, 0.1, 0.3, 0.7, 1.5, 3.1, 6.3, 11.3, 16.3]
    assert "there is no analog device max1363" in inputs.errors["cup"]


def test_two_devices_of_one_name_are_told_apart_by_label_or_number(adc: Converter) -> None:
    second = Converter(adc.folder.parent, 1)
    second.put(voltage0_raw=2000)
    inputs = reader(adc)
    assert inputs.read("cup") is None
    assert "iio:device0 and iio:device1 are both called ads1015" in inputs.errors["cup"]
    (second.folder / "label").write_text("left\n")
    assert reader(adc, cup=channel("left")).read("cup") == 0
    assert reader(adc, cup=channel("iio:device1")).read("cup") == 0


def test_no_folder_at_all(tmp_path: Path) -> None:
    inputs = AnalogReader(tmp_path / "none", {"cup": channel()})
    assert inputs.read("cup") is None
    assert "there are no analog inputs: No such file" in inputs.errors["cup"]
