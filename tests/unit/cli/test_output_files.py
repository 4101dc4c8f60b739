"""Where commands write: a file whole or not at all, no folder of its name, never in the place of what is no file."""

from __future__ import annotations

import errno
import os
import stat
import threading
import xml.etree.ElementTree as ET
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import eehal
from end_effector_hal.cli._options import PathName, write_whole
from end_effector_hal.cli.recorded import part_of
from end_effector_hal.description import SHIPPED_AUTOMATA, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.page.web import PageAddress
from end_effector_hal.page.web._serve import _listen
from end_effector_hal.recording import RunInfo, StatesWriter, read_run
from tests.support.refuted import REFUTED

SECOND = "<query><formula>A[] not P.B</formula><comment>[never] Never B.</comment></query></queries>"


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(eehal, arguments)


def is_drawing(name: str) -> bool:
    return ET.parse(name).getroot().tag.endswith("svg")


def test_a_template_is_drawn_into_a_file() -> None:
    drawn = run("model", "show", "--template", "Gripper", "-o", "x.svg")
    assert (drawn.exit_code, drawn.output) == (0, "Gripper: x.svg\n")
    assert is_drawing("x.svg")


def test_several_do_not_fit_into_one_file_and_a_wrong_name_is_guessed() -> None:
    error = str(run("model", "show", "-o", "x.svg").exception)
    assert error.startswith("x.svg: ")
    assert "drawings do not fit into one file. Name a folder, or one of them with --template: " in error
    wrong = run("model", "show", "--template", "Griper", "-o", "x.svg")
    assert str(wrong.exception) == "There is no template 'Griper'. Did you mean 'Gripper'?"
    assert not Path("x.svg").exists()


def test_a_run_of_the_model_is_drawn_into_a_file() -> None:
    assert run("model", "simulate", "--steps", "30", "-o", "x.svg").exit_code == 0
    assert is_drawing("x.svg")
    assert [path.name for path in Path().iterdir()] == ["x.svg"]


def test_a_counterexample_is_drawn_into_a_file_and_several_beside_it() -> None:
    Path("model.xml").write_text(REFUTED)
    result = run("verify", "--model", "model.xml", "-o", "x.svg")
    assert (result.exit_code, is_drawing("x.svg")) == (4, True)
    assert "\nx.svg\n" in result.output
    Path("model.xml").write_text(REFUTED.replace("</queries>", SECOND))
    assert run("verify", "--model", "model.xml", "-o", "y.svg").exit_code == 4
    assert sorted(path.name for path in Path().glob("y*")) == ["y-never.svg", "y-stays.svg"]


def test_a_folder_called_so_stays_one() -> None:
    Path("x.svg").mkdir()
    assert run("model", "show", "--template", "Gripper", "-o", "x.svg").exit_code == 0
    assert {path.suffix for path in Path("x.svg").iterdir()} == {".png", ".svg"}


def states_of_a_recording(folder: Path) -> bytes:
    """What a run of a real tool leaves: its states, and a run.json without a scenario."""
    folder.mkdir()
    with StatesWriter(folder / "states.csv", ("left",)) as writer:
        writer.write(0.0, 6, -1, (0,))
    RunInfo(description="two_cups", started="2026-11-23T12:00:00+00:00").write(folder)
    return (folder / "states.csv").read_bytes()


@pytest.mark.parametrize(
    "left", [["states.csv", "run.json"], ["states.csv"], ["run.json"], ["hal.mcap", "run.json"]]
)
def test_a_run_of_the_model_replaces_no_recording(left: list[str]) -> None:
    states_of_a_recording(Path("run"))
    (Path("run") / "hal.mcap").write_bytes(b"trace")
    for each in Path("run").iterdir():
        if each.name not in left:
            each.unlink()
    before = {each.name: each.read_bytes() for each in Path("run").iterdir()}
    for command in (("model", "simulate", "--steps", "3"), ("verify", "--model", "model.xml")):
        Path("model.xml").write_text(REFUTED)
        error = str(run(*command, "-o", "run").exception)
        assert error.startswith("run: This folder contains a recording")
        assert {each.name: each.read_bytes() for each in Path("run").iterdir()} == before


def test_a_run_of_the_model_replaces_another_one() -> None:
    for seed in ("1", "2"):
        assert run("model", "simulate", "--steps", "3", "--seed", seed, "-o", "sim").exit_code == 0
    assert read_run("sim").scenario == "run of the model, seed 2"
    (Path("sim") / "run.json").write_text('{"scenario": "nominal"}')
    assert run("model", "simulate", "--steps", "3", "-o", "sim").exit_code != 0


def test_a_counterexample_replaces_its_own_files_and_no_recording() -> None:
    Path("model.xml").write_text(REFUTED)
    for _ in range(2):
        assert run("verify", "--model", "model.xml", "-o", "found").exit_code == 4
    (place,) = Path("found").iterdir()
    (place / "hal.mcap").write_bytes(b"trace")
    assert "This folder contains a recording" in str(
        run("verify", "--model", "model.xml", "-o", "found").exception
    )


@pytest.mark.parametrize("command", [("export", "urdf"), ("model", "export")])
@pytest.mark.parametrize("output", ["tool.yaml", "end_effector.xml", "link.txt"])
def test_what_a_command_reads_is_not_replaced(command: tuple[str, ...], output: str) -> None:
    for name, path in (("tool.yaml", profile_path()), ("end_effector.xml", SHIPPED_AUTOMATA)):
        Path(name).write_bytes(path.read_bytes())
    Path("link.txt").symlink_to("tool.yaml")
    before = Path(output).read_bytes()
    error = str(run(*command, "tool.yaml", "-o", output).exception)
    assert error.startswith(f"{output}: The command reads this file")
    assert Path(output).read_bytes() == before
    assert run(*command, "tool.yaml", "-o", "new").exit_code == 0


@pytest.mark.parametrize(
    "output", ["run/hal.mcap", "run/states.csv", "other.yaml", "report", "linked.html", "hard.html"]
)
def test_a_report_replaces_nothing_of_a_recording(output: str) -> None:
    states_of_a_recording(Path("run"))
    (Path("run") / "hal.mcap").write_bytes(b"trace")
    Path("other.yaml").write_text("name: x")
    Path("linked.html").symlink_to("run/states.csv")
    Path("hard.html").hardlink_to("run/hal.mcap")
    before = {str(each): each.read_bytes() for each in Path().rglob("*.*") if each.is_file()}
    result = run("report", "run", "-o", output)
    assert isinstance(result.exception, UsageError)
    assert result.exception.where == output
    assert "A report is an HTML file." in str(result.exception) or "reads this file" in str(result.exception)
    assert {str(each): each.read_bytes() for each in Path().rglob("*.*") if each.is_file()} == before


def test_a_pipe_stays_a_pipe_and_gets_the_data(tmp_path: Path) -> None:
    pipe, got = tmp_path / "pipe", list[bytes]()
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write_whole(pipe, b"data")
    assert stat.S_ISFIFO(pipe.stat().st_mode), "as a device in /dev would be gone"
    reader.join(10.0)
    assert got == [b"data"]


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    link, file = tmp_path / "link", tmp_path / "there" / "file"
    link.symlink_to(file)
    for data in (b"new", b"newer"):
        write_whole(link, data)
        assert (link.is_symlink(), file.read_bytes()) == (True, data)
    assert [each.name for each in file.parent.iterdir()] == ["file"]


def test_what_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    for path, why in (
        (tmp_path, "Is a directory"),
        (tmp_path / "no" / "file", "No such file"),
        (Path("/dev/full"), "No space"),
    ):
        with pytest.raises(UsageError, match=f"The file cannot be written: {why}"):
            write_whole(path, b"data")
    assert not list(tmp_path.iterdir())


def test_a_path_that_leads_nowhere_is_a_sentence_in_every_command(tmp_path: Path) -> None:
    circle = tmp_path / "circle.mcap"
    circle.symlink_to(circle)
    for path, why in ((circle, "symbolic links"), (tmp_path / ("x" * 300), "too long")):
        with pytest.raises(click.BadParameter, match=f"cannot be reached: .*{why}"):
            PathName().convert(str(path), None, None)
    for fine in (tmp_path, tmp_path / "new", tmp_path / "new" / "below"):
        assert PathName().convert(str(fine), None, None) == fine


def test_a_folder_that_may_not_be_searched_is_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the kernel refuses it; root, who runs many tests, may search every folder."""
    folder, real = tmp_path / "folder", os.stat
    folder.mkdir()

    def refusing(path: str, *args: object, **options: object) -> os.stat_result:
        if str(path).startswith(f"{folder}/"):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)
        return real(path, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "stat", refusing)
    with pytest.raises(click.BadParameter, match="cannot be reached: Permission denied"):
        PathName().convert(str(folder), None, None)


@pytest.mark.parametrize("seconds", [float("nan"), float("inf")])
def test_a_part_of_a_recording_is_between_numbers(seconds: float) -> None:
    with pytest.raises(UsageError, match="are seconds"):
        part_of(seconds, None)
    with pytest.raises(UsageError, match="are seconds"):
        part_of(None, seconds)


@pytest.mark.parametrize("host", ["a..b", "192.0.2.1"])
def test_a_host_that_is_no_name_or_not_of_this_machine_is_a_sentence(host: str) -> None:
    with pytest.raises(UsageError, match=r"The page cannot be served: .* Give an address .* to --host\."):
        _listen(PageAddress(host, 0))


def test_a_port_that_is_taken_is_a_sentence() -> None:
    with (
        _listen(PageAddress("127.0.0.1", 0)) as taken,
        pytest.raises(UsageError, match=r"The page cannot be served: .* Name another --port"),
    ):
        _listen(PageAddress("127.0.0.1", taken.getsockname()[1]))
