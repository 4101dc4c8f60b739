"""What the board is made of is built once, and what becomes of what it left; without the board."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import RosError, UsageError
from end_effector_hal.recording import StatesWriter, run_info
from end_effector_lab.demo import scenarios
from end_effector_lab.testbench import edges_of
from end_effector_lab.testbench._program import Events
from tools.board import BoardError, Ended, _parts, _play, board_parts, need_its_wires, play_on_board
from tools.board.__main__ import command
from tools.board._cpio import write_archive
from tools.board._parts import keep
from tools.board._root import write_root

EEHAL = (sys.executable, "-c", "from end_effector_hal.cli import main; main()")


@pytest.fixture
def recipe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A build that is quick: its script is what the test writes."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = tmp_path / "recipe"
    folder.mkdir()
    (folder / "packages.txt").write_text("python3\n")
    (folder / "_cpio.py").write_text("")
    (folder / "build.sh").write_text('echo once >>"$(dirname "$0")/count"; touch "$1/root.cpio"\n')
    monkeypatch.setattr(_parts, "HERE", folder)
    return folder


def test_built_once(recipe: Path, tmp_path: Path) -> None:
    said: list[str] = []
    place = board_parts(said.append)
    assert place == board_parts(said.append)
    assert (recipe / "count").read_text() == "once\n"
    assert place.is_relative_to(tmp_path / "cache" / "end-effector-hal" / "board")
    assert [text.split()[0] for text in said] == ["building", "built"]


def test_built_anew_when_it_is_made_of_something_else(recipe: Path) -> None:
    place = board_parts()
    (recipe / "packages.txt").write_text("python3\nbash\n")
    assert board_parts() != place
    assert (place / "root.cpio").exists()


def older(tmp_path: Path, name: str) -> Path:
    place = tmp_path / "cache" / "end-effector-hal" / "board" / name
    (place / "qemu").mkdir(parents=True)
    (place / "root.cpio").touch()
    return place


IN_USE = """
import pathlib, sys
from tools.board._parts import keep

print(keep(pathlib.Path(sys.argv[1])), flush=True)
input()
"""


def test_a_new_one_removes_those_before_it_but_not_one_in_use(recipe: Path, tmp_path: Path) -> None:
    unused, used = older(tmp_path, "0000000000aa"), older(tmp_path, "0000000000bb")
    cut_off = older(tmp_path, "0000000000cc.new")
    said: list[str] = []
    user = [sys.executable, "-c", IN_USE, str(used)]
    with subprocess.Popen(user, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout
        assert other.stdout.readline() == "True\n"
        place = board_parts(said.append)
        assert sorted(place.parent.iterdir()) == sorted([used, place, place.parent / "lock"])
        other.communicate("\n")
    assert not unused.exists()
    assert not cut_off.exists()
    assert said[-2:] == [f"removed {each.name}, an older one" for each in (unused, cut_off)]
    (recipe / "packages.txt").write_text("python3\nbash\n")
    newer = board_parts()
    assert [path.is_dir() for path in (used, place, newer)] == [False, True, True], "this process uses both"


def test_a_build_that_fails_removes_nothing(recipe: Path, tmp_path: Path) -> None:
    before = older(tmp_path, "0000000000aa")
    (recipe / "build.sh").write_text("exit 1\n")
    with pytest.raises(BoardError):
        board_parts()
    assert (before / "root.cpio").exists()


def test_what_was_removed_meanwhile_is_not_there(tmp_path: Path) -> None:
    place = older(tmp_path, "0000000000aa")
    (place / "root.cpio").unlink()
    assert not keep(place)
    assert not keep(tmp_path / "none")


def test_a_build_that_was_cut_off_is_begun_anew(recipe: Path) -> None:
    place = board_parts()
    (place / "root.cpio").unlink()
    place.rename(place.with_name(f"{place.name}.new"))
    assert (board_parts() / "root.cpio").exists()


def test_what_is_missing_is_one_sentence(recipe: Path) -> None:
    (recipe / "build.sh").write_text("echo 'apt-get is missing: apt install apt' >&2; exit 3\n")
    with pytest.raises(BoardError) as caught:
        board_parts()
    assert str(caught.value) == "The emulated board cannot be built: apt-get is missing: apt install apt"
    (recipe / "build.sh").write_text("echo 'E: no route to host' >&2; exit 1\n")
    with pytest.raises(BoardError, match=r"no route to host All of it: .*/build.log"):
        board_parts()


def test_a_cache_that_cannot_be_written(
    recipe: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(BoardError, match="Set XDG_CACHE_HOME"):
        board_parts()


def test_the_board_has_the_same_versions_and_nothing_that_draws() -> None:
    requirements = _parts._requirements("end-effector-hal")
    names = {each.partition("==")[0] for each in requirements}
    assert f"pydantic=={version('pydantic')}" in requirements
    assert {"pydantic-core", "gpiod", "ruamel-yaml", "click"} <= names
    assert not {"matplotlib", "numpy", "pillow", "pytest"} & names


def test_on_a_machine_without_apt(tmp_path: Path) -> None:
    for name in ("bash", "dirname", "mkdir"):
        (tmp_path / name).symlink_to(
            next(Path(place) / name for place in ("/usr/bin", "/bin") if (Path(place) / name).exists())
        )
    env = {**os.environ, "PATH": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    ended = subprocess.run(
        [sys.executable, "-m", "tools.board"], env=env, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 3
    assert (
        ended.stderr.splitlines()[-1]
        == "The emulated board cannot be built: apt-get is missing: apt install apt"
    )


def test_a_scenario_that_is_not_there(recipe: Path) -> None:
    with pytest.raises(UsageError, match=r"there is no scenario nonsense\. There are: nominal"):
        command.main(["--only", "nonsense"], standalone_mode=False)
    assert not (recipe / "count").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("SODIMM_208", "GPIO_9", r"has no line GPIO_9. It has SODIMM_206"),
        ("/dev/verdin-uart1", "/dev/ttyUSB0", r"no port /dev/ttyUSB0. Its sensor link is /dev/verdin-uart1"),
        ("backend: gpiod", "backend: virtual\n  path: /tmp/chip", r"this tool uses virtual lines"),
    ],
)
def test_a_tool_on_other_wires(tmp_path: Path, old: str, new: str, said: str) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(profile_path().read_text().replace(old, new))
    with pytest.raises(UsageError, match=said):
        need_its_wires(load(path))
    need_its_wires(load(profile_path()))


def test_the_root_is_what_was_built_and_the_project_and_the_job(tmp_path: Path) -> None:
    parts = tmp_path / "parts"
    parts.mkdir()
    (parts / "root.cpio").write_bytes(b"12345")
    root = write_root(parts, tmp_path, "echo done", {"opt/more": "text"}, ros=False).read_bytes()
    assert root.startswith(b"12345\0\0\0" + b"070701")
    for part in (
        b"job\0",
        b"echo done",
        b"opt/more\0",
        b"site/end_effector_lab/commands/_demo.py\0",
        f"site/end_effector_hal-{version('end-effector-hal')}.dist-info/entry_points.txt\0".encode(),
        b"RNDADDENTROPY",
    ):
        assert part in root
    assert b"/ros/end_effector" not in root
    assert sorted(path.name for path in tmp_path.iterdir()) == ["parts", "root.cpio"]


def test_nodes_are_not_put_on_the_board_where_they_are_not_built(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [place for place in sys.path if "catkin" not in place])
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    monkeypatch.delitem(sys.modules, "end_effector_msgs", raising=False)
    with pytest.raises(RosError, match=r"make board.*--no-ros"):
        write_root(tmp_path, tmp_path, "true", {}, ros=True)


def test_an_archive(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    (folder / "deep").mkdir(parents=True)
    (folder / "deep" / "program").write_text("content")
    (folder / "deep" / "program").chmod(0o750)
    (folder / "link").symlink_to("deep/program")
    archive = io.BytesIO()
    write_archive(folder, archive)
    entries = list(unpacked(archive.getvalue()))
    assert entries == [
        ("deep", 0o40755, b""),
        ("deep/program", 0o100750, b"content"),
        ("link", 0o120777, b"deep/program"),
        ("TRAILER!!!", 0, b""),
    ]


def unpacked(data: bytes) -> list[tuple[str, int, bytes]]:
    """By the format as the kernel documents it (Documentation/driver-api/early-userspace/buffer-format.rst)."""
    entries, at = [], 0
    while at < len(data):
        assert data[at : at + 6] == b"070701"
        fields = [int(data[at + 6 + 8 * n : at + 14 + 8 * n], 16) for n in range(13)]
        mode, size, name_size = fields[1], fields[6], fields[11]
        assert fields[2:4] == [0, 0], "owned by root"
        name = data[at + 110 : at + 110 + name_size - 1].decode()
        begin = -(-(at + 110 + name_size) // 4) * 4
        entries.append((name, mode, data[begin : begin + size]))
        at = -(-(begin + size) // 4) * 4
    return entries


def test_what_a_testbench_saw_of_the_lines(tmp_path: Path) -> None:
    events = Events(tmp_path / "events")
    events.line("A", True, 100, 120)
    events.frame(200, 1, {"bottom": 0.0}, True)
    events.line("A", False, 300, 310)
    events.close()
    with (tmp_path / "events").open("a") as file:
        file.write('{"at":400,"li')  # cut off
    assert [(edge.at, edge.line, edge.level) for edge in edges_of(tmp_path / "events")] == [
        (100, "A", True),
        (300, "A", False),
    ]


# What becomes of what the board left; without the board.


TOOL = load(profile_path())
NOMINAL = scenarios(TOOL)[0]
Left = Callable[[Path], Ended]


@pytest.fixture
def play(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[Left], Any]:
    """Plays the first scenario on a board that leaves what the test says."""

    def play(left: Left) -> Any:
        def run_board(parts: Path, folder: Path, job: str, **options: Any) -> Ended:
            assert f"--own-wires --no-figures --only {NOMINAL.name} --no-ros -o /run/results" in job
            assert options["testbench"] == [str(TOOL.source), "--scenario", "nominal"]
            assert set(options["files"]) == {
                "opt/end-effector/tool/end_effector.yaml",
                "opt/end-effector/tool/end_effector.xml",
            }
            return left(folder)

        monkeypatch.setattr(_play, "run_board", run_board)
        return play_on_board(NOMINAL, TOOL, tmp_path, tmp_path / "run", ros=False, figures=False)

    return play


def at_rest(folder: Path) -> Ended:
    """A recording in which nothing happens."""
    recorded = folder / "results" / NOMINAL.name
    (recorded / "ros").mkdir(parents=True)
    (recorded / "ros" / "latest").symlink_to("/run/results/nominal/ros/1")
    run_info(TOOL, scenario="nominal", ros=False).write(recorded)
    writer = StatesWriter(recorded / "states.csv", TOOL.sequence)
    writer.write(0.0, 0, -1, [0, 0, 0])
    writer.write(1.0, 6, -1, [0, 0, 0])
    writer.close()
    events = Events(folder / "events")
    events.line("SODIMM_208", True, 100, 100)
    events.close()
    return Ended(1, "it said this", 12.5)


def test_a_recording_comes_home_and_is_judged_by_the_pins(
    play: Callable[[Left], Any], tmp_path: Path
) -> None:
    played = play(at_rest)
    assert (played.seconds, played.folder) == (12.5, tmp_path / "run")
    faults = [fault.partition(":")[0] for fault in played.faults]
    assert faults == ["states", "commands", "attempts", "wires", "answers", "replay"]
    names = {path.name for path in (tmp_path / "run").iterdir()}
    assert {"states.csv", "run.json", "events", "end_effector.yaml", "ros"} <= names
    assert (tmp_path / "run" / "ros" / "latest").is_symlink()


def test_the_same_folder_again(play: Callable[[Left], Any], tmp_path: Path) -> None:
    play(at_rest)
    (tmp_path / "run" / "old").write_text("")
    play(at_rest)
    assert not (tmp_path / "run" / "old").exists()


def test_a_folder_of_somebody_else(play: Callable[[Left], Any], tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "thesis.txt").write_text("")
    with pytest.raises(UsageError, match="did not write"):
        play(at_rest)


@pytest.mark.parametrize("code", [None, 2, 3, 0])
def test_a_board_that_leaves_no_recording(play: Callable[[Left], Any], code: int | None) -> None:
    with pytest.raises(BoardError, match=r"left no recording in .*/run; it said:\n    kernel panic"):
        play(lambda folder: Ended(code, "kernel panic\n", 1.0))
