"""What the doctor says of the lines."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from end_effector_hal.cli.doctor import _lines
from end_effector_hal.cli.doctor._lines import look_at_inputs
from end_effector_hal.description import Description, examine_text, load, profile_path
from end_effector_hal.wires import Claim
from end_effector_hal.wires.lines import VirtualChip, VirtualLines
from end_effector_hal.wires.lines import _gpiod as module
from tests.support.input_kernel import InputKernel
from tests.unit.cli.doctor.parts import LINES, Machine


def test_a_chip_of_another_tool(machine: Machine) -> None:
    VirtualChip.create(machine.chip, [name.replace("MM_208", "M_208") for name in LINES])
    level, what, _ = machine.finding("lines")
    assert (level, what) == (
        "missing",
        f"{machine.chip} has no line SODIMM_208 (did you mean 'SODIM_208'?)",
    )


def test_what_is_active_is_told_and_stays_so(machine: Machine) -> None:
    machine.make_chip()
    lines = VirtualLines(machine.chip)
    lines.request(LINES)
    lines.set({"SODIMM_208": True})
    lines.close()
    before = machine.chip.read_bytes()
    assert machine.finding("lines")[:2] == (
        "ok",
        f"virtual chip {machine.chip}; active: SODIMM_208; held by nobody",
    )
    assert machine.chip.read_bytes() == before


class Kernel:
    """What the doctor asks of gpiod 2; a request is not among it."""

    api_version = "2.3"

    def __init__(self, **chips: list[SimpleNamespace] | OSError) -> None:
        self._chips = chips

    def is_gpiochip_device(self, path: str) -> bool:
        return Path(path).name in self._chips

    def Chip(self, path: str) -> Any:
        lines = self._chips[Path(path).name]
        if isinstance(lines, OSError):
            raise lines

        class Chip:
            def __enter__(self) -> Chip:
                return self

            def __exit__(self, *_: object) -> None:
                pass

            def get_info(self) -> SimpleNamespace:
                return SimpleNamespace(label="", num_lines=len(lines))

            def get_line_info(self, offset: int) -> SimpleNamespace:
                return lines[offset]

        return Chip()


def gpio(name: str, consumer: str | None = None, *, used: bool = False) -> SimpleNamespace:
    return SimpleNamespace(
        name=name, used=used or bool(consumer), consumer=consumer, direction="Direction.OUTPUT"
    )


def look_at(kernel: object, folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setitem(sys.modules, "gpiod", kernel)  # type: ignore[arg-type]
    found = _lines.look_at_lines(load(profile_path()), LINES, f"{folder}/chip*")
    return [f"{finding.level.value}: {finding.what}" for finding in found]


def test_lines_of_the_kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("chip0", "chip1", "chip2", "chip3"):
        (tmp_path / name).touch()
    kernel = Kernel(
        chip0=[gpio("SODIMM_206"), gpio(""), gpio("SODIMM_208", "end-effector-hal")],
        chip1=[gpio("SODIMM_206"), gpio("SODIMM_210", "wifi"), gpio("SODIMM_21")],
        chip2=PermissionError(13, "Permission denied"),
        chip3=OSError(19, "No such device"),
    )
    assert look_at(kernel, tmp_path, monkeypatch) == [
        f"missing: {tmp_path}/chip2: the GPIO chip cannot be opened: permission denied",
        f"missing: {tmp_path}/chip3: the GPIO chip cannot be opened: No such device",
        "missing: no line SODIMM_212 (did you mean SODIMM_21?) on "
        + ", ".join(f"{tmp_path}/chip{number}" for number in range(4)),
        f"ok: SODIMM_208 = {tmp_path}/chip0 line 2, output, held by the line arbiter",
        f"missing: SODIMM_210 = {tmp_path}/chip1 line 1 is held by wifi",
        f"missing: SODIMM_206 is ambiguous: {tmp_path}/chip0 line 0 and {tmp_path}/chip1 line 0",
    ]


def test_no_chip_and_the_wrong_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert look_at(Kernel(), tmp_path, monkeypatch) == [
        f"missing: there is no GPIO chip on this machine ({tmp_path}/chip* matches none)"
    ]
    debian = SimpleNamespace(__version__="1.6.3")
    assert look_at(debian, tmp_path, monkeypatch) == ["missing: gpiod has the API 1, needed is 2"]
    assert look_at(None, tmp_path, monkeypatch)[0].startswith("missing: gpiod cannot be imported: ")


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
