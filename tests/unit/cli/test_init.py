"""``eehal init``: what it writes is valid, proven as it stands and touches nothing, or it refuses in a sentence."""

from __future__ import annotations

import json
from importlib.machinery import ModuleSpec
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli import _check
from end_effector_hal.cli._main import eehal
from end_effector_hal.cli.init._init import command
from end_effector_hal.codecs import codec_of, line_of
from end_effector_hal.control import model_constants
from end_effector_hal.description import Description, load, schema_text
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.verification.proof import prove
from tests.support.nightly import first_of
from timed_automata import load_network

TOOLS = [
    ("cup:vacuum", ()),
    ("cups:vacuum,rod:cylinder", ()),
    ("a:vacuum,rod:cylinder,b:vacuum", ("--link", "binary", "--no-tool-changer")),
    ("a:vacuum,rod:cylinder,jaw:gripper", ("--link", "json")),
    ("jaw:gripper,m:magnet,cup:vacuum", ("--link", "none", "--no-tool-changer")),
    ("a:vacuum,rod:cylinder", ("--link", "modbus", "--virtual")),
    (",".join(f"v{n}:vacuum" for n in range(6)), ("--link", "modbus", "--no-tool-changer")),
    (",".join(f"g{n}:gripper" for n in range(12)), ("--link", "none", "--no-tool-changer")),
    ("on:vacuum,locked:vacuum", ("--link", "text")),
]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def written(actuators: str, options: tuple[str, ...]) -> Description:
    """The tool as `eehal init` describes it."""
    result = CliRunner().invoke(
        eehal, ["init", "My 2nd Tool", "--actuators", actuators, *options], catch_exceptions=False
    )
    assert result.exit_code == 0
    return load(Path("My 2nd Tool/end_effector.yaml"))


@pytest.mark.parametrize("link", ["text", "json", "binary", "modbus"])
def test_the_baud_rate_that_it_writes_is_the_one_without_the_key(link: str) -> None:
    tool = written("cup:vacuum", ("--link", link, "--no-tool-changer"))
    without = tool.model_copy(update={"link": tool.link.model_copy(update={"baudrate": None})})
    assert tool.link.baudrate == line_of(without.links[""], codec_of(without, ""))[0]


@pytest.mark.parametrize("number", first_of(range(len(TOOLS)), 6, 4))
def test_it_is_checked_without_an_edit(number: int) -> None:
    actuators, options = TOOLS[number]
    tool = written(actuators, options)
    assert _check.check(tool.source).faults == ()
    assert (tool.name, tool.source.parent.name) == ("my_2nd_tool", "My 2nd Tool")
    assert [f"{name}:{actuator.kind}" for name, actuator in tool.ordered] == actuators.split(",")
    assert (tool.tool_changer is None) is ("--no-tool-changer" in options)
    assert (tool.lines.backend == "virtual") is ("--virtual" in options)


@pytest.mark.parametrize("number", first_of([0, 1, 8, *sorted({*range(len(TOOLS))} - {0, 1, 8})], 1, 2))
def test_it_is_proven_without_an_edit(number: int) -> None:
    tool = written(*TOOLS[number])
    proof = prove(load_network(tool.automata_path, model_constants(tool)))
    assert [finding.id for finding in proof.findings if not finding.holds] == []


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--actuators", "a:vacum"], "there is no kind of actuator 'vacum'. Did you mean vacuum? There are: "),
        (["--actuators", "a"], "'a' is not an actuator. Write NAME:KIND, such as cups:vacuum,rod:cylinder."),
        (["--actuators", ""], "'' is not an actuator. Write NAME:KIND"),
        (["--actuators", "A:vacuum"], "'A' is not a valid name of an actuator. Write lower-case letters"),
        (["--actuators", "a:vacuum,a:cylinder"], "Two actuators are named 'a'. Give each a name of its own."),
        (["--actuators", "null:vacuum"], "'null' has another meaning in a description and cannot"),
        (["--actuators", "a:vacuum,true:gripper"], "'true' has another meaning in a description and"),
        (
            ["--actuators", "supply:vacuum"],
            "The description would be invalid: topic 'PressureSupply' belongs to the nodes "
            "(topic: PressureSupply), expected another name. "
            "Name the actuator 'supply' otherwise.",
        ),
        (["--actuators", "time_s:vacuum"], "The description would be invalid: this name means something else"),
        (["--actuators", "a:vacuum:front"], "a: only a device of the library names a link. Write a:vacuum."),
        (["--virtual"], "No actuators are named. Give --actuators, such as"),
    ],
)  # fmt: skip
def test_what_cannot_be_described_is_one_sentence_and_no_folder(options: list[str], said: str) -> None:
    result = CliRunner().invoke(eehal, ["init", "tool", *options])
    assert isinstance(result.exception, ReportedError)
    assert str(result.exception).startswith(said)
    assert not Path("tool").exists()


@pytest.mark.parametrize(
    ("link", "installed", "said"),
    [("modbus", False, True), ("modbus", True, False), ("text", False, False)],
)
def test_the_extra_that_a_modbus_link_needs_is_named_where_it_is_missing(
    monkeypatch: pytest.MonkeyPatch, link: str, installed: bool, said: bool
) -> None:
    found = ModuleSpec("pymodbus", None) if installed else None
    monkeypatch.setattr("end_effector_hal.cli.init._init.find_spec", lambda name: found)
    options = ["init", "tool", "--actuators", "a:vacuum", "--link", link, "--no-tool-changer"]
    result = CliRunner().invoke(eehal, options, catch_exceptions=False)
    assert ("pip install '.[modbus]'" in result.stderr) is said


def test_a_folder_to_start_from(tmp_path: Path) -> None:
    folder = tmp_path / "my" / "tool"
    result = CliRunner().invoke(command, [str(folder), "--json"], catch_exceptions=False)
    assert result.exit_code == 0
    names = ["end_effector.yaml", "end_effector.schema.json"]
    assert json.loads(result.stdout)["files"] == [str(folder / name) for name in names]
    assert load(folder / "end_effector.yaml").name == "verdin_gripper"
    named = (
        (folder / "end_effector.yaml").read_text(encoding="utf-8").splitlines()[0].partition("$schema=")[2]
    )
    assert (folder / named).read_text(encoding="utf-8") == schema_text()


def test_what_is_there_is_not_touched(tmp_path: Path) -> None:
    (tmp_path / "end_effector.schema.json").write_text("mine")
    result = CliRunner().invoke(command, [str(tmp_path)])
    assert isinstance(result.exception, UsageError)
    assert str(result.exception).startswith(
        f"{tmp_path}/end_effector.schema.json: This file is there already."
    )
    assert [path.name for path in tmp_path.iterdir()] == ["end_effector.schema.json"]


def test_a_link_that_leads_nowhere_is_there_already(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere.yaml"
    (tmp_path / "tool").mkdir()
    (tmp_path / "tool" / "end_effector.yaml").symlink_to(elsewhere)
    result = CliRunner().invoke(command, [str(tmp_path / "tool")])
    assert isinstance(result.exception, UsageError)
    assert "end_effector.yaml: This file is there already." in str(result.exception)
    assert not elsewhere.exists()


@pytest.mark.parametrize("name", ["file", "file/below"])
def test_what_is_no_folder_is_a_sentence(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").touch()
    result = CliRunner().invoke(command, [str(tmp_path / name)])
    assert isinstance(result.exception, UsageError)
    assert "The folder cannot be made" in str(result.exception)


@pytest.mark.parametrize(
    "arguments", [["init", ""], ["demo", "--no-ros", "-o", ""], ["model", "export", "-o", ""]]
)
def test_an_empty_path_is_not_the_current_folder(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(eehal, arguments)
    assert result.exit_code == 2
    assert "It is empty. Write '.' for the current folder." in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_current_folder_is_a_point(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(eehal, ["init", "."]).exit_code == 0
    assert (tmp_path / "end_effector.yaml").exists()


def test_a_path_with_blanks_is_quoted_in_what_comes_next(tmp_path: Path) -> None:
    result = CliRunner().invoke(eehal, ["init", f"{tmp_path}/my tool"], catch_exceptions=False)
    file = f"'{tmp_path}/my tool/end_effector.yaml'"
    assert f"Next: edit {file}, then `eehal check {file}`." in result.output


@pytest.mark.parametrize(
    ("link", "port", "baudrate"),
    [("modbus", "tcp://192.168.1.20", None), ("text", "rfc2217://hand:4001", 115_200)],
)
def test_a_port_may_be_an_address(tmp_path: Path, link: str, port: str, baudrate: int | None) -> None:
    words = [str(tmp_path / "tool"), "--actuators", "cup:vacuum,jaw:gripper", "--link", link, "--port", port]
    assert CliRunner().invoke(command, words).exit_code == 0
    tool = load(tmp_path / "tool" / "end_effector.yaml")
    assert (tool.link.port, tool.link.baudrate) == (port, baudrate)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--link", "modbus", "--port", "192.168.1.20:502"], "expected tcp://192.168.1.20:502 for Modbus TCP"),
        (["--link", "text", "--port", "tcp://plc"], "expected socket://plc:PORT"),
        (["--link", "modbus", "--port", "x=tcp://plc"], "--port x=tcp://plc belongs to no link. Expected: --port PORT"),
        (["--link", "modbus", "--port", "tcp://a", "--port", "tcp://b"], "this link has a port already"),
        (["--link", "none", "--port", "tcp://a"], "belongs to no link. Expected: no --port."),
        (["--virtual", "--port", "tcp://a"], "--virtual has ports of its own"),
    ],
)  # fmt: skip
def test_a_port_that_cannot_be_is_refused(options: list[str], said: str, tmp_path: Path) -> None:
    refused = CliRunner().invoke(command, [str(tmp_path / "tool"), "--actuators", "cup:vacuum", *options])
    assert said in str(refused.exception)
    assert not (tmp_path / "tool").exists()
