"""The demo without ROS, with real processes in wall time; and what it says when something is not as it should be."""

from __future__ import annotations

import importlib.util
import io
import json
import shutil
import uuid
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from rich.console import Console

from end_effector_hal.description import Description, profile_path
from end_effector_hal.errors import ArbiterError, ReportedError, RosError, UsageError
from end_effector_hal.recording import StatesLog, read_pressures, read_run, read_states
from end_effector_hal.wires.lines import read_chip
from end_effector_lab.commands._demo import command
from end_effector_lab.demo import Report, Ros1, WithoutRos, fresh_folder, print_table, run_demo, scenarios
from end_effector_lab.demo import _world as world_module
from end_effector_lab.demo._judge import judge
from end_effector_lab.testbench import Testbench, open_inputs, open_ports

FILES = {
    "alarms.csv", "events.csv", "arbiter.log", "end_effector.yaml", "hal.mcap", "lines.log", "paper.png", "paper.svg",
    "pressures.csv", "run.json", "states.csv", "switches.csv", "testbench.log", "timeline.png",
    "timeline.svg", "tool.log", "tool_changer.csv",
}  # fmt: skip


@pytest.fixture
def left(monkeypatch: pytest.MonkeyPatch) -> Callable[[], set[int]]:
    """Processes that this test started and that still run, whatever others do on the machine."""
    token = uuid.uuid4().hex
    monkeypatch.setenv("EEHAL_TEST", token)

    def found() -> set[int]:
        pids = set()
        for each in Path("/proc").iterdir():
            with suppress(OSError):
                if each.name.isdigit() and token.encode() in (each / "environ").read_bytes():
                    pids.add(int(each.name))
        return pids

    return found


@pytest.mark.wall
@pytest.mark.alone
def test_the_nominal_scenario_without_ros(
    verdin: Description, tmp_path: Path, left: Callable[[], set[int]]
) -> None:
    shown = io.StringIO()
    (report,) = run_demo(
        verdin,
        scenarios(verdin)[:1],
        tmp_path / "demo",
        drive=WithoutRos(),
        progress=Console(file=shown, width=120),
        seed=7,
    )
    assert report.faults == ()
    assert report.verdict == "Nominal: GRIPPED, then dropped"
    assert report.seconds < 40
    folder = tmp_path / "demo" / "nominal"
    assert report.folder == folder
    assert {path.name for path in folder.iterdir()} == FILES
    assert all((folder / name).stat().st_size > 10_000 for name in ("timeline.png", "paper.png"))
    log = read_states(folder / "states.csv")
    assert log.columns == ("time_s", "end_effector", "command", "bottom_vacuum", "cylinder", "top_vacuum")
    assert read_run(folder).scenario == "nominal"
    assert read_run(folder).ros is False
    assert read_run(folder).seed == 7
    assert "scenario nominal, seed 7, lines" in (folder / "testbench.log").read_text()
    bottom = [
        value for value in read_pressures(folder / "pressures.csv").curve("bottom") if value is not None
    ]
    assert min(bottom) < -55 < -10 < bottom[-1]
    assert shown.getvalue().startswith("[1/1] nominal: starting\n")
    assert "[1/1] nominal: GRIPPED, Bottom vacuum ON, Cylinder EXTENDED, Top vacuum ON\n" in shown.getvalue()
    assert left() == set()


@pytest.mark.nightly
@pytest.mark.wall
@pytest.mark.alone
def test_an_unlock_is_armed_first_where_the_codec_shows_no_stand(verdin: Description, tmp_path: Path) -> None:
    # a codec that shows more often than each second: it is not the times that are tried here
    assert verdin.tool_changer
    blind = verdin.tool_changer.model_copy(update={"stand_bit": "none"})
    tool = verdin.model_copy(update={"tool_changer": type(blind).model_validate(blind.model_dump())})
    (scenario,) = (each for each in scenarios(tool, everything=True) if each.name == "unlock-lock")
    (report,) = run_demo(
        tool, [scenario], tmp_path, drive=WithoutRos(), progress=Console(quiet=True), figures=False
    )
    assert report.faults == ()
    said = (tmp_path / "unlock-lock" / "tool.log").read_text()
    answers = [line for line in said.splitlines() if line.endswith(": succeeded")]
    assert answers == ["ARM: succeeded", "UNLOCK: succeeded", "LOCK: succeeded"]


@pytest.mark.wall
@pytest.mark.alone
def test_on_its_own_wires_the_testbench_is_somebody_elses(verdin: Description, tmp_path: Path) -> None:
    place, folder = tmp_path / "wires", tmp_path / "demo"
    place.mkdir()
    tool = verdin.with_virtual(place / "chip", str(place / "uart"))
    inputs, port = open_inputs(None, tool), open_ports(None, tool, None)
    with Testbench(tool, inputs, port):
        (report,) = run_demo(
            tool, scenarios(tool)[:1], folder, drive=WithoutRos(), progress=Console(quiet=True), own_wires=True,
            figures=False,
        )  # fmt: skip
        assert read_chip(place / "chip").lines["SODIMM_208"] == ("out", False)
    assert report.faults == ()
    assert {path.name for path in (folder / "nominal").iterdir()} == FILES - {
        "lines.log", "paper.png", "paper.svg", "testbench.log", "timeline.png", "timeline.svg",
    }  # fmt: skip


@pytest.mark.wall
def test_an_arbiter_that_does_not_start_is_one_sentence_and_nothing_is_left(
    verdin: Description,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    left: Callable[[], set[int]],
) -> None:
    real = world_module.EEHAL
    program = "import sys; args = sys.argv[1:]; sys.exit('no chip today') if args[0] == 'arbiter' else None; "
    monkeypatch.setattr(world_module, "EEHAL", (*real[:2], program + real[2]))
    with pytest.raises(ArbiterError) as raised:
        list(
            run_demo(
                verdin, scenarios(verdin)[:1], tmp_path, drive=WithoutRos(), progress=Console(quiet=True)
            )
        )
    assert str(raised.value).startswith("The line arbiter ended (exit code 1) before its socket.")
    assert str(raised.value).endswith("no chip today")
    assert left() == set()
    assert (tmp_path / "nominal" / "arbiter.log").read_text() == "no chip today\n"


def test_what_no_demo_wrote_is_not_thrown_away(tmp_path: Path) -> None:
    (tmp_path / "nominal").mkdir()
    (tmp_path / "nominal" / "thesis.txt").write_text("four years")
    with pytest.raises(UsageError, match="did not write"):
        fresh_folder(tmp_path / "nominal")
    assert (tmp_path / "nominal" / "thesis.txt").exists()


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot be made"):
        fresh_folder(tmp_path / "file" / "nominal")


def test_without_ros_it_names_the_packages_and_the_way_without(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(RosError) as raised:
        Ros1().check()
    text = str(raised.value)
    assert text.startswith("ROS is not installed: roscore, roslaunch, rosrun")
    assert "python3-rospy" in text
    assert text.endswith("Without ROS: `eehal demo --no-ros`.")


def test_messages_that_are_not_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if "msgs" in name else object())
    with pytest.raises(RosError, match="The ROS messages are not built, or not sourced"):
        Ros1().check()


@pytest.fixture
def reports(verdin: Description, recordings: dict[str, StatesLog]) -> list[Report]:
    return [judge(scenario, verdin, recordings[scenario.name]) for scenario in scenarios(verdin)]


def test_the_table(reports: list[Report]) -> None:
    shown = io.StringIO()
    print_table(Console(file=shown, width=120), reports)
    text = shown.getvalue()
    for words in (
        "Nominal: GRIPPED, then dropped", "Fig. 8", "Cylinder 2", "Cylinder time-out 1  5.000 (5) ok",
        "Cylinder reset 2  1.000 (1) ok",
    ):  # fmt: skip
        assert words in text
    assert "NOT OK" not in text
    assert max(len(line) for line in text.splitlines()) <= 120


@pytest.mark.parametrize("width", [80, 100])
def test_the_table_fits_into_a_narrow_terminal(reports: list[Report], width: int) -> None:
    shown = io.StringIO()
    print_table(Console(file=shown, width=width), reports)
    table = [line for line in shown.getvalue().splitlines() if line[:1] in "┏┃┡│├└"]
    assert max(len(line) for line in table) <= width
    assert all(line[-1] in "┓┃┩│┤┘" for line in table)
    assert "…" not in shown.getvalue()


def test_the_table_says_what_is_wrong(verdin: Description, recordings: dict[str, StatesLog]) -> None:
    cylinder = verdin.actuators["cylinder"].model_copy(update={"reset_s": 2.0})
    other = verdin.model_copy(update={"actuators": {**verdin.actuators, "cylinder": cylinder}})
    shown = io.StringIO()
    print_table(
        Console(file=shown, width=120), [judge(scenarios(verdin)[1], other, recordings["fails-once"])]
    )
    assert "Cylinder reset 1  1.000 (2) NOT OK" in shown.getvalue()
    assert (
        "NOT OK fails-once: cylinder reset 1: 1.000 s (expected 2 s): not within 100 ms after it"
        in shown.getvalue()
    )


class Played:
    """Reports in place of a demo."""

    def __init__(self) -> None:
        self.reports: list[Report] = []
        self.error: ReportedError | None = None
        self.asked: dict[str, Any] = {}

    def __call__(
        self, description: Description, chosen: Any, output: Path, **options: Any
    ) -> Iterator[Report]:
        self.asked = {"names": [scenario.name for scenario in chosen], "output": output, **options}
        if self.error:
            raise self.error
        yield from self.reports


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch, reports: list[Report]) -> Played:
    stand_in = Played()
    stand_in.reports = reports
    monkeypatch.setattr("end_effector_lab.demo.run_demo", stand_in)
    return stand_in


def test_the_command_ends_with_0_when_all_is_well(played: Played) -> None:
    done = CliRunner().invoke(command, ["--no-ros"])
    assert (done.exit_code, played.asked["drive"].ros, played.asked["names"]) == (
        0, False, ["nominal", "fails-once", "never-confirms"]
    )  # fmt: skip
    assert played.asked["output"] == Path("runs/demo")


def test_the_command_ends_with_1_when_a_story_is_not_told(
    verdin: Description, recordings: dict[str, StatesLog], played: Played
) -> None:
    played.reports = [judge(scenarios(verdin)[0], verdin, recordings["fails-once"])]
    done = CliRunner().invoke(command, [])
    assert done.exit_code == 1
    assert played.asked["drive"].ros == 1
    assert (
        "NOT OK nominal: attempts: expected bottom_vacuum 1, cylinder 1, top_vacuum 1, found" in done.output
    )


def test_all_and_json(played: Played) -> None:
    done = CliRunner().invoke(command, ["--all", "--json", "-o", "elsewhere"])
    content = json.loads(done.stdout)["reports"]
    assert [each["scenario"] for each in content] == ["nominal", "fails-once", "never-confirms"]
    assert all(each["ok"] for each in content)
    assert len(played.asked["names"]) == 6
    assert played.asked["progress"].quiet
    assert played.asked["output"] == Path("elsewhere")
    assert (played.asked["own_wires"], played.asked["figures"]) == (False, True)


def test_the_seed_is_handed_on(played: Played) -> None:
    assert CliRunner().invoke(command, ["--seed", "7"]).exit_code == 0
    assert played.asked["seed"] == 7
    assert CliRunner().invoke(command, []).exit_code == 0
    assert played.asked["seed"] == 0


def test_the_help_lists_the_scenarios(verdin: Description) -> None:
    names = ", ".join(scenario.name for scenario in scenarios(verdin, everything=True))
    text = CliRunner().invoke(command, ["--help"]).output
    assert f"Of{names}(withatoolchanger).".replace(" ", "") in "".join(text.split())


def test_one_scenario_on_its_own_wires(played: Played) -> None:
    done = CliRunner().invoke(command, ["--own-wires", "--only", "cancel", "--no-figures"])
    assert done.exit_code == 0, done.output
    assert played.asked["names"] == ["cancel"]
    assert (played.asked["own_wires"], played.asked["figures"]) == (True, False)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--only", "nominal", "--only", "x"], "there is no scenario x. There are: nominal, fails-once"),
        (
            ["--own-wires", "--only", "nominal", "--seed", "7"],
            "draws no random numbers. Give --seed to the testbench at their other end.",
        ),
        (["--own-wires"], "plays one scenario at a time. Give --only NAME."),
    ],
)
def test_refused_options(played: Played, options: list[str], message: str) -> None:
    done = CliRunner().invoke(command, options)
    assert message in str(done.exception)
    assert played.asked == {}


def test_what_cannot_be_played_is_told_and_the_rest_is_played(played: Played, tmp_path: Path) -> None:
    tool = tmp_path / "tool.yaml"
    text = profile_path().read_text().replace("ees1-ascii ", "modbus-rtu-transmitters ")
    none = {"channel: cylinder\n": ("extended", "retracted"),
            "service: SetToolChanger\n": ("locked", "unlocked", "stand", "present")}  # fmt: skip
    for key, bits in none.items():
        indent = text.partition(key)[0].rpartition("\n")[2]
        text = text.replace(key, key + "".join(f"{indent}{bit}_bit: none\n" for bit in bits))
    tool.write_text(text)
    why = "unlock-lock is not played: modbus-rtu-transmitters carries no locked_bit and no unlocked_bit"
    result = CliRunner().invoke(command, [str(tool), "--no-ros", "--all"])
    assert why in result.stderr
    assert "unlock-lock" not in played.asked["names"]
    result = CliRunner().invoke(command, [str(tool), "--no-ros", "--only", "unlock-lock"])
    assert isinstance(result.exception, UsageError)
    assert f"{tool}:13:10: " in str(result.exception)
    assert "unlock-lock cannot be played: modbus" in str(result.exception)
