"""``eehal listen``: what arrives, as lines, as JSON and as a table; nothing is disturbed."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
from contextlib import suppress
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli.listen import _listen, why_no_frame
from end_effector_hal.errors import LinkBusyError, LinkError, UsageError
from end_effector_hal.sensing import SENT_INVALID
from end_effector_hal.wires.link import PtyPair, open_port
from end_effector_lab.processes import EEHAL
from tests.unit.cli.doctor.conftest import Machine, Sender, frame

pytestmark = pytest.mark.wall


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def listen(machine: Machine, *options: str, seconds: str = "0.4") -> Result:
    return CliRunner().invoke(
        _listen.command, [str(machine.path), "--seconds", seconds, *options], catch_exceptions=True
    )


def told(result: Result) -> list[dict[str, object]]:
    assert result.exit_code == 0, result.exception
    return [json.loads(line) for line in result.stdout.splitlines()]


def test_each_channel_and_each_evidence_is_told_once_while_nothing_changes(machine: Machine) -> None:
    with PtyPair(machine.port) as wire, Sender(wire, frame):
        events = told(listen(machine, "--json"))
    channels = {each["channel"]: each for each in events if each["event"] == "channel"}
    assert channels["bottom"] | {"time_s": 0, "rate_hz": 0} == {
        "schema_version": 1, "event": "channel", "time_s": 0, "channel": "bottom", "raw": -70_000,
        "value": -70.0, "unit": "kPa", "state": "fresh", "rate_hz": 0,
    }  # fmt: skip
    assert sum(each["event"] == "channel" for each in events) == len(channels)
    last = {each["actuator"]: each["evidence"] for each in events if each["event"] == "evidence"}
    assert last["bottom_vacuum"] == "CONFIRMED"
    assert last["top_vacuum"] == "GONE"


def test_what_is_invalid_and_what_cannot_be_read_is_told(machine: Machine) -> None:
    def message(number: int) -> bytes:
        whole = frame(number, top=None)
        return whole.replace(b"$EES1", b"$EES2") if number % 5 == 4 else whole

    with PtyPair(machine.port) as wire, Sender(wire, message):
        result = listen(machine)
    assert f" s  top is invalid ({SENT_INVALID})\n" in result.stdout
    assert " s  bottom -70.0 kPa (raw -70000)\n" in result.stdout
    assert " format (newest bytes " in result.stdout


ALARMING = """
schema: 2
name: tool
link: {{port: {port}, frame: {{text: {{}}}}}}
channels:
  vacuum: {{text: {{field: 1}}, unit: kPa}}
  pump: {{text: {{field: 2}}, alarm: [{{code: 8, text: it is too hot}}]}}
sequence: [cup]
actuators:
  cup: {{kind: vacuum, line: GPIO5, channel: vacuum}}
supply: {{channel: none}}
"""


def test_what_a_device_says_is_wrong_is_told_in_words_once_and_when_it_is_over(machine: Machine) -> None:
    machine.path.write_text(ALARMING.format(port=machine.port))

    def message(number: int) -> bytes:
        return f"-70.0,{8 if number < 30 else 0}\n".encode()

    with PtyPair(machine.port) as wire, Sender(wire, message):
        result = listen(machine, seconds="0.9")
    lines = [line.split(" s  ")[-1] for line in result.stdout.splitlines()]
    assert lines.count("pump 8 (raw 8)") == lines.count("alarm: Pump: it is too hot.") == 1
    assert lines.count("pump 0 (raw 0)") == lines.count("over: Pump: it is too hot.") == 1


def test_what_stops_is_stale_and_its_evidence_unknown(machine: Machine) -> None:
    def message(number: int) -> bytes:
        return frame(number) if number < 40 else b""

    with PtyPair(machine.port) as wire, Sender(wire, message):
        events = told(listen(machine, "--json", seconds="0.9"))
    bottom = [each for each in events if each.get("channel") == "bottom"]
    assert [each["state"] for each in bottom] == ["fresh", "stale"]
    assert bottom[-1]["value"] is None
    assert [each["evidence"] for each in events if each.get("actuator") == "bottom_vacuum"][-1] == "UNKNOWN"


def test_on_a_terminal_it_is_a_table_until_ctrl_c(machine: Machine) -> None:
    ours, theirs = pty.openpty()
    with PtyPair(machine.port) as wire, Sender(wire, frame), open(ours, "rb", buffering=0) as terminal:
        process = subprocess.Popen(
            ["env", "--default-signal=INT", *EEHAL, "listen", str(machine.path)],
            stdout=theirs,
            env={**os.environ, "TERM": "xterm", "COLUMNS": "100", "LINES": "50"},
        )
        os.close(theirs)
        shown = b""
        while not all(each in shown for each in (b"per second", b"-70.0 kPa", b"CONFIRMED")):
            shown += terminal.read(4096)
        process.send_signal(signal.SIGINT)
        with suppress(OSError):  # the other end is closed
            while terminal.read(4096):
                pass
        assert process.wait(30) == 0


def test_silence_and_another_codec_are_one_sentence(machine: Machine) -> None:
    with PtyPair(machine.port) as wire:
        silent = listen(machine, seconds="0.1").exception
        with Sender(wire, lambda number: b"\x05"):
            noise = listen(machine, seconds="0.5").exception
    assert isinstance(silent, LinkError)
    assert str(silent).startswith(f"{machine.port}, ees1-ascii, 115200 baud: silent. Is the device powered")
    assert isinstance(noise, LinkError)
    assert str(noise).endswith("they look like legacy-nibble. Set link.codec: legacy-nibble.")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b'1}\n{"p":-62.4,"part":true}\r\n{"p":', "lines of JSON. Write frame: {json: {}} for the link"),
        (b"{not json\n", "Baud rate, parity, link.frame and voltage levels: do they fit?"),
    ],
)
def test_lines_of_json_are_recognised(data: bytes, said: str) -> None:
    assert said in ". ".join(why_no_frame(data, ""))


def test_a_link_that_somebody_reads_is_left_alone(machine: Machine) -> None:
    with PtyPair(machine.port) as wire, open_port(str(machine.port), 115_200), Sender(wire, frame):
        done = subprocess.run(
            [*EEHAL, "listen", str(machine.path), "--seconds", "1"],
            capture_output=True,
            text=True,
            check=False,
        )
    assert (done.returncode, done.stdout) == (LinkBusyError.exit_code, "")
    assert "two readers would steal each other's bytes." in done.stderr


def test_a_port_that_is_not_there_is_one_sentence(machine: Machine) -> None:
    error = listen(machine).exception
    assert isinstance(error, LinkError)
    assert str(error).startswith(f"{machine.port}: the port does not exist.")


def test_a_recording_that_is_none(machine: Machine, tmp_path: Path) -> None:
    error = listen(machine, "--suggest", str(tmp_path)).exception
    assert isinstance(error, UsageError)
    assert str(error).startswith(f"{tmp_path}: There is no states.csv here. Record a grip and a drop: ")


def test_an_adapter_that_goes_away_and_comes_back_is_read_again(machine: Machine) -> None:
    process = None
    try:
        for life in range(2):
            with PtyPair(machine.port) as wire, Sender(wire, frame):
                process = process or subprocess.Popen(
                    [*EEHAL, "listen", str(machine.path)], stdout=subprocess.PIPE, text=True
                )
                assert process.stdout is not None
                assert any("bottom_vacuum is CONFIRMED" in line for line in process.stdout), f"life {life}"
            if not life:
                lost = next(line for line in process.stdout if "alarm: " in line)
                # it prints ten times a second; if the link has tried to open the port again by then, that is the error
                assert (
                    f"{machine.port}: the port was lost" in lost
                    or f"{machine.port}: the port does not exist" in lost
                )
    finally:
        if process is not None:
            process.terminate()
            process.communicate()
