"""The program of the testbench: its commands, its mail, and the copy of a tool without hardware."""

from __future__ import annotations

import signal
import threading
from pathlib import Path
from queue import Queue

import pytest
from click.testing import CliRunner

from end_effector_hal.cli.doctor._lines import look_at_lines
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.wires import inputs as board
from end_effector_hal.wires.lines import VirtualLines, read_chip
from end_effector_lab.commands._testbench import command
from end_effector_lab.testbench import open_inputs, write_virtual_copy
from end_effector_lab.testbench._program import Commands, Events, Mail, Voice
from end_effector_lab.testbench.inputs import VirtualInputs
from tests.support.places import ROOT


class Told:
    def __init__(self, *, as_json: bool = False) -> None:
        self.scenarios: list[str] = []
        self.ended = False
        self.commands = Commands(Voice(as_json=as_json), self.choose, self.end)

    def choose(self, text: str) -> None:
        if text == "wrong":
            raise UsageError("no fault is named 'wrong'.")
        self.scenarios.append(text)

    def end(self) -> None:
        self.ended = True


def test_scenario_and_quit(capsys: pytest.CaptureFixture[str]) -> None:
    told = Told()
    for line in ("scenario  fails-once:cylinder", "", "scenario wrong", "scenario", "stop"):
        told.commands.obey(line)
    assert told.scenarios == ["fails-once:cylinder"]
    assert not told.ended
    out, err = capsys.readouterr()
    assert out == "scenario: fails-once:cylinder\n"
    assert err.splitlines() == [
        "refused: no fault is named 'wrong'.",
        "refused: there is no command 'scenario'. There are: scenario TEXT, quit.",
        "refused: there is no command 'stop'. There are: scenario TEXT, quit.",
    ]
    told.commands.obey("quit")
    assert told.ended


def test_json(capsys: pytest.CaptureFixture[str]) -> None:
    told = Told(as_json=True)
    told.commands.obey("scenario nominal")
    told.commands.obey("scenario wrong")
    assert capsys.readouterr().out.splitlines() == [
        '{"schema_version": 1, "scenario": "nominal"}',
        """{"schema_version": 1, "refused": "no fault is named 'wrong'."}""",
    ]


def test_nothing_is_done_before_it_is_delivered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    events = Events(tmp_path / "events")
    mail = Mail(Voice(), events)
    mail.line("SODIMM_208", True, 1_500_000, 1_500_100)
    mail.frame(1_520_000, 1, {"bottom": -5}, True)
    assert (tmp_path / "events").read_text() == ""
    mail.deliver()
    assert capsys.readouterr().out == "1.500000 SODIMM_208 active\n"
    assert len((tmp_path / "events").read_text().splitlines()) == 2
    events.close()


def test_what_is_posted_in_a_thread_is_done_in_its_order_until_the_end() -> None:
    mail, done = Mail(Voice(), None), list[int]()

    def post() -> None:
        for number in range(1000):
            mail.post(lambda number=number: done.append(number))
        mail.end()

    thread = threading.Thread(target=post)
    thread.start()
    mail.serve()
    mail.deliver()
    thread.join()
    assert done == list(range(1000))


def test_a_signal_ends_it_while_it_waits() -> None:
    mail = Mail(Voice(), None)
    before = signal.signal(signal.SIGUSR1, lambda *_: mail.end())
    main = threading.main_thread().ident
    assert main
    mail.post(lambda: signal.pthread_kill(main, signal.SIGUSR1))
    try:
        mail.serve()
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert mail.ended


TOOLS = ROOT / "examples/tools"


def test_the_copy_is_the_same_tool_with_its_own_wires_beside_it(tmp_path: Path) -> None:
    folder = tmp_path / "simulated"
    done = CliRunner().invoke(command, ["--prepare", str(folder)], catch_exceptions=False)
    path = Path(done.stdout.strip())
    copy, tool = load(path), load(profile_path())
    assert path == folder / "end_effector.yaml"
    assert (copy.lines.backend, copy.link.port) == ("virtual", str(folder / "uart"))
    assert copy.automata_path == tool.automata_path
    assert (copy.actuators, copy.sequence, copy.bounds) == (tool.actuators, tool.sequence, tool.bounds)
    # the line arbiter may start before the testbench
    (finding,) = look_at_lines(copy, copy.output_lines)
    assert finding.level.value == "ok", finding


def test_a_folder_that_cannot_be_made_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="Cannot be made: it is a link, or no directory"):
        write_virtual_copy(load(profile_path()), tmp_path / "file" / "folder")


@pytest.mark.parametrize("name", ["gripper_2f85", "double_acting_jaw", "diy_vacuum", "two_epick"])
def test_the_chip_of_the_copy_is_the_one_that_the_testbench_wants(name: str, tmp_path: Path) -> None:
    copy = load_tool(write_virtual_copy(load_tool(TOOLS / name / "end_effector.yaml"), tmp_path))
    inputs = open_inputs(None, copy)
    levels = inputs.start(lambda line, level, at: None)
    inputs.close()
    assert not any(levels.values())


EXPANDER = """
name: on_an_expander
channels: {part: {digital: {line: {chip: mcp23017, offset: 8}, poll_ms: 5, bias: pull_up}, invert: true}}
sequence: [jaw]
actuators:
  jaw: {kind: gripper, line: {chip: /dev/gpiochip3, offset: 0}, opposite: {line: "gpiochip3:1"}, part_bit: part}
supply: {channel: none}
"""


def test_a_copy_has_its_lines_by_chip_and_offset(tmp_path: Path) -> None:
    (tmp_path / "tool.yaml").write_text(EXPANDER)
    tool = load_tool(tmp_path / "tool.yaml")
    copy = load_tool(write_virtual_copy(tool, tmp_path / "copy"))
    assert (copy.actuators, copy.channels) == (tool.actuators, tool.channels)
    seen: Queue[tuple[str, bool]] = Queue()
    inputs = open_inputs(None, copy)
    inputs.start(lambda line, level, _at: seen.put((line, level)))
    lines, switches = VirtualLines(copy.lines.path or ""), board.lines_of(copy)
    assert lines.request(copy.wired_lines) == {"gpiochip3:0": False, "gpiochip3:1": False}
    switches.request(board.input_lines(copy))
    lines.set({"gpiochip3:1": True})
    assert seen.get(timeout=20) == ("gpiochip3:1", True)
    assert switches.levels() == {"mcp23017:8": True}
    switches.close()
    lines.close()
    inputs.close()


def test_the_sensors_show_their_levels_before_the_testbench_plays(tmp_path: Path) -> None:
    """The first reader of the chip finds an e-stop that is active low closed."""
    copy = load_tool(write_virtual_copy(load_tool(TOOLS / "double_acting_jaw/end_effector.yaml"), tmp_path))
    levels = {"GPIO17": False, "GPIO27": True, "GPIO22": False}  # open, not closed, no stop; inverted
    chip = read_chip(tmp_path / "chip").lines
    assert {line: chip[line] for line in levels} == {line: ("in", each) for line, each in levels.items()}
    opened = open_inputs(None, copy, power_cycle=True, scenario="estop-open")
    assert isinstance(opened, VirtualInputs)
    assert opened.make_chip().read().lines["GPIO22"].level
