"""What the doctor says of the inputs of a board."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from end_effector_hal.cli.doctor._lines import look_at_inputs
from end_effector_hal.description import Description, examine_text
from end_effector_hal.wires import Claim
from end_effector_hal.wires.lines import VirtualChip
from end_effector_hal.wires.lines import _gpiod as module
from tests.support.input_kernel import InputKernel

TOOL = """
schema: 2
name: mixed
lines: {lines}
inputs: {{iio: {folder}/iio}}
channels:
  switch: {{digital: {{line: GPIO17}}}}
  cup: {{analog: {{device: ads1015, channel: voltage0}}, unit: kPa, scale: 0.05, offset: -100, range: [-101, 10]}}
sequence: [one, two]
actuators:
  one: {{kind: vacuum, line: OUT1, channel: switch}}
  two: {{kind: vacuum, line: OUT2, channel: cup}}
supply: {{channel: none}}
"""


def said(folder: Path, lines: str, chips: str = "") -> list[tuple[str, str]]:
    description = examine_text(TOOL.format(folder=folder, lines=lines), folder / "tool.yaml").description
    assert description
    return [(each.level.value, each.what) for each in look_at_inputs(description, chips)]


def test_virtual_lines_and_who_reads_them(tmp_path: Path) -> None:
    chip = VirtualChip.create(tmp_path / "chip", ["GPIO17"], {"GPIO17": "up"}).path
    virtual = f"{{backend: virtual, path: {chip}}}"
    assert said(tmp_path, virtual)[0] == ("ok", f"virtual chip {chip}; high: GPIO17; read by nobody")
    claim = Claim(f"{chip}.inputs.lock", "an input line")
    assert "; read by " in said(tmp_path, virtual)[0][1]
    claim.release()
    VirtualChip.create(chip, ["GPIO18"])
    assert said(tmp_path, virtual)[0] == ("missing", f"{chip} has no line GPIO17")


def test_lines_of_a_real_chip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "dev").mkdir()
    kernel = InputKernel(tmp_path / "dev", gpiochip0=["", "GPIO17"])
    chip = kernel.chip_of("GPIO17")
    monkeypatch.setattr(module, "importlib", SimpleNamespace(import_module=lambda name: kernel))
    path = tmp_path / "dev/gpiochip0"
    for consumer, level, text in (
        ("", "ok", "free"),
        ("end-effector-hal inputs", "ok", "held by the reader of the sensors"),
        ("fan", "missing", "is held by fan"),
    ):
        chip.held_by = {1: consumer} if consumer else {}
        found = said(tmp_path, "{backend: gpiod}", kernel.pattern)[0]
        assert found[0] == level
        assert found[1].startswith(f"GPIO17 = {path} line 1")
        assert found[1].endswith(text)


@pytest.mark.parametrize(
    ("raw", "level", "text"),
    [
        ("1000", "ok", "cup: -50.0 kPa"),
        ("9000", "warning", "cup shows what its sensor cannot mean"),
        ("x", "missing", "contains 'x', which is not a number"),
    ],
)
def test_an_analog_input_is_read_once(tmp_path: Path, raw: str, level: str, text: str) -> None:
    VirtualChip.create(tmp_path / "chip", ["GPIO17"])
    device = tmp_path / "iio/iio:device0"
    device.mkdir(parents=True)
    (device / "name").write_text("ads1015\n")
    (device / "in_voltage0_raw").write_text(raw)
    found = said(tmp_path, f"{{backend: virtual, path: {tmp_path}/chip}}")[1]
    assert found[0] == level
    assert text in found[1]


def test_a_tool_without_inputs(verdin: Description) -> None:
    assert [each.what for each in look_at_inputs(verdin)] == ["none: all channels come over the link"]
