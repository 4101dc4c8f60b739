"""What the doctor says of the lines and of the sensor link."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from end_effector_hal.cli.doctor import _lines, _link
from end_effector_hal.cli.doctor._lines import look_at_inputs
from end_effector_hal.description import Description, examine_text, load, profile_path
from end_effector_hal.wires import Claim
from end_effector_hal.wires.lines import VirtualChip, VirtualLines
from end_effector_hal.wires.lines import _gpiod as module
from end_effector_hal.wires.link import PtyPair
from tests.support.input_kernel import InputKernel
from tests.unit.cli.doctor.conftest import LINES, Machine, Sender, frame


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


# What the doctor says of the sensor link.


def test_frames_are_heard(machine: Machine) -> None:
    with PtyPair(machine.port) as pty, Sender(pty, frame):
        level, what, todo = machine.finding("link")
    assert (level, todo) == ("ok", "")
    assert what.startswith(f"{machine.port}, ees1-ascii, 115200 baud: ")


def test_what_is_wrong_with_the_frames_is_told(machine: Machine) -> None:
    def message(number: int) -> bytes:
        whole = frame(2 * number, top=None)
        return whole.replace(b"$EES1", b"$EES2") if number % 5 == 4 else whole

    with PtyPair(machine.port) as pty, Sender(pty, message):
        level, what, todo = machine.finding("link")
    assert level == "warning"
    assert " lost, " in what
    assert " format, no value of top" in what
    assert todo


def test_a_channel_that_the_tool_does_not_use_is_no_matter(machine: Machine) -> None:
    text = machine.path.read_text().replace("cylinder, top_vacuum]", "cylinder]")
    start, end = text.index("  top_vacuum:\n"), text.index("tool_changer:\n")
    machine.describe(text=text[:start] + text[end:])
    with PtyPair(machine.port) as pty, Sender(pty, lambda number: frame(number, top=None)):
        _, what, _ = machine.finding("link")
    assert " frames" in what
    assert "no value of" not in what


def test_silence_noise_and_another_codec(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:

    monkeypatch.setattr(_link, "LISTEN_US", 200_000)
    with PtyPair(machine.port) as pty:
        assert machine.finding("link")[:2] == (
            "missing",
            f"{machine.port}, ees1-ascii, 115200 baud: silent",
        )
        with Sender(pty, lambda number: b"\xa5"):
            level, what, todo = machine.finding("link")
        assert (level, what.endswith(" bytes and no frame")) == ("missing", True)
        assert todo.startswith("Baud rate")
        with Sender(pty, lambda number: b"\x05"):
            assert machine.finding("link")[2] == "Set link.codec: legacy-nibble."


@pytest.mark.parametrize("program", ["eehal-like", "other"])
@pytest.mark.wall
def test_a_reader_loses_no_byte(machine: Machine, program: str, tmp_path: Path) -> None:
    script = tmp_path / program
    script.write_text(
        "import os, select, sys\n"
        "fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)\n"
        "print('open', flush=True)\n"
        "data = b''\n"
        "while not data.endswith(b'!') and select.select([fd], [], [], 5)[0]:\n"
        "    data += os.read(fd, 4096)\n"
        "print(data.decode(), flush=True)\n"
    )
    with (
        PtyPair(machine.port) as pty,
        subprocess.Popen(
            [sys.executable, str(script), str(machine.port)], stdout=subprocess.PIPE, text=True
        ) as reader,
    ):
        assert reader.stdout
        assert reader.stdout.readline() == "open\n"
        pty.write(b"abc")
        started = time.monotonic()
        level, what, _ = machine.finding("link")
        assert time.monotonic() - started < 1.5, "it listened"
        pty.write(b"def!")
        assert reader.stdout.readline() == "abcdef!\n"
    called = f"{program} {machine.port}"
    called = called if len(called) <= 80 else f"{called[:79]}…"
    assert (
        what
        == f"{machine.port} is read by pid {reader.pid} ({called}); not listened to, its bytes are theirs"
    )
    assert level == ("ok" if program == "eehal-like" else "warning")


def test_a_passive_look_opens_nothing(machine: Machine) -> None:
    with PtyPair(machine.port) as pty:
        pty.write(b"abc")
        assert machine.finding("link", "--passive")[:2] == (
            "ok",
            f"{machine.port} exists and is free; not listened to",
        )


def test_ports_that_are_none(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    machine.port.symlink_to("/dev/pts/99999")
    assert machine.finding("link")[1] == f"{machine.port} leads to /dev/pts/99999, which is not there"
    machine.port.unlink()
    machine.port.touch()
    assert machine.finding("link")[1] == f"{machine.port}: this is not a serial port."
    of_all = os.access
    monkeypatch.setattr(os, "access", lambda path, *more: path != machine.port and of_all(path, *more))
    assert machine.finding("link")[1] == f"{machine.port} may not be opened: permission denied"
    assert "dialout" in machine.finding("link")[2]
