"""The pages say what is so: README, glossary, boards, cases from the bench, FMEAs."""

from __future__ import annotations

import ast
import csv
import re
from collections.abc import Collection
from functools import cache
from io import StringIO
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

from end_effector_hal.cli import _check
from end_effector_hal.description import examine_text, load
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_lab.figures import timeline
from end_effector_lab.trials import fmea, play
from tests.support.fmea import EVERY, KEPT, chosen, rows_of
from tests.support.places import DOCS, ROOT
from tests.support.trace_recordings import INFO, NEVER, PRESSURES
from tools.first_picture import SPEED, STILL_S, save_moving

README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    """The one block of code in that language."""
    (found,) = re.findall(rf"^```{language}\n(.*?)^```", README, re.DOTALL | re.MULTILINE)
    return str(found)


def test_ten_lines_are_a_tool() -> None:
    assert block("yaml").count("\n") == 10
    assert examine_text(block("yaml"), "tool.yaml").lines() == []


def test_what_is_made_can_be_made() -> None:
    made = set(re.findall(r"\bmake ([a-z0-9-]+)", README))
    there = set(re.findall(r"^([a-z0-9-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert {"demo", "demo-ros2", "docs"} <= made <= there


def test_who_has_no_ros_and_who_has_ros_2_find_their_first_command() -> None:
    lines = block("sh").splitlines()
    first = {word: next(i for i, line in enumerate(lines) if word in line) for word in ("--no-ros", "ros2")}
    assert "git clone" in lines[0]
    assert first["--no-ros"] < 4
    assert lines[first["ros2"]].startswith("make demo-ros2")


def test_what_computes_at_length_is_found_from_the_first_pages() -> None:
    pages = (README, (ROOT / "docs/index.md").read_text(encoding="utf-8"))
    for page in pages:
        for command in ("campaign", "matrix", "compare", "tune"):
            assert f"`eehal {command}`" in page
        assert "how-to/cluster.md" in page


def test_each_link_leads_to_a_file() -> None:
    links = {target.partition("#")[0] for target in re.findall(r"\]\(([^)]+)\)", README)}
    here = {target for target in links if "://" not in target}
    assert len(here) > 20
    assert [target for target in sorted(here) if not (ROOT / target).is_file()] == []


# The integers of Table II in the glossary are those that are logged.


GLOSSARY = (DOCS / "reference/glossary.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("begins", "table"), [("States of the end-effector: ", EndEffectorState), ("Commands: ", Command)]
)
def test_table_ii_has_its_integers(begins: str, table: type[EndEffectorState] | type[Command]) -> None:
    sentence = " ".join(GLOSSARY.split()).partition(begins)[2].partition(".")[0]
    written = {name: int(number) for name, number in re.findall(r"(\w+) (-?\d+)", sentence)}
    assert written == {each.name: each.value for each in table}


# Each page of a board has the same parts, and a description that `eehal check` accepts.


PAGES = {path.stem.removeprefix("board-"): path for path in (DOCS / "how-to").glob("board-*.md")}


def test_every_page_is_of_a_known_board_and_the_index_names_it() -> None:
    assert PAGES.keys() == {"raspberry-pi", "verdin", "pc"}
    index = (DOCS / "how-to/board.md").read_text(encoding="utf-8")
    assert all(f"\n{path.stem}\n" in index for path in PAGES.values())


@pytest.mark.parametrize("board", PAGES)
def test_a_page_has_its_parts_and_a_description_that_the_check_accepts(board: str, tmp_path: Path) -> None:
    page = PAGES[board].read_text(encoding="utf-8")
    assert re.findall(r"^## (.*)", page, re.MULTILINE) == ["Lines", "Sensors", "Description", "Not confirmed"]
    (text,) = re.findall(r"^```yaml\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    (tmp_path / "tool.yaml").write_text(text, encoding="utf-8")
    result = CliRunner().invoke(_check.command, [str(tmp_path / "tool.yaml")])
    assert result.exit_code == 0, result.output


# The table of cases from the bench: each row names a test that exists, so that it is run.


PAGE = (DOCS / "explanation" / "bench.md").read_text(encoding="utf-8")
ROWS = [line for line in PAGE.splitlines() if line.startswith("| ") and not line.startswith("| what")]
NODE = re.compile(r"\| `(tests/[\w/]+\.py)::(test_\w+)` \|$")


@cache
def names_in(path: str) -> frozenset[str]:
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    return frozenset(
        each.name
        for each in ast.walk(tree)
        if isinstance(each, ast.FunctionDef) and each.name.startswith("test_")
    )


@pytest.mark.parametrize("row", ROWS)
def test_a_row_names_a_test_that_exists(row: str) -> None:
    found = NODE.search(row)
    assert found, "the last column is one test"
    assert found[2] in names_in(found[1])


def test_no_case_is_left_out_of_the_table() -> None:
    assert len(ROWS) >= 30
    assert len(set(ROWS)) == len(ROWS)


# The moving picture of the README: still where nothing moves, and of the tool that the README shows.


PICTURE = DOCS / "images/failed-grip.svg"
SVG = "{http://www.w3.org/2000/svg}"


def test_a_text_appears_when_its_time_has_come_and_the_verdict_at_the_end(tmp_path: Path) -> None:
    figure = timeline(NEVER, PRESSURES, INFO)
    save_moving(figure, tmp_path / "moving.svg")
    svg = (tmp_path / "moving.svg").read_text(encoding="utf-8")
    start_s, end_s = figure.axes[0].get_xlim()
    whole_s = (end_s - start_s) / SPEED + STILL_S
    appears = {
        name: float(at) / 100 * whole_s for name, at in re.findall(r"@keyframes (\w+)\{0%,([\d.]+)%", svg)
    }
    names = {
        each.get("id"): each[-1].text for each in ElementTree.fromstring(svg).iter(f"{SVG}g") if len(each)
    }
    abort = next(name for name in appears if "abort" in (names[name] or ""))
    assert 18.2 < appears[abort] * SPEED + start_s <= 18.5
    assert max(appears, key=appears.__getitem__) == "verdict"


def test_without_animation_the_whole_figure_is_seen() -> None:
    svg = PICTURE.read_text(encoding="utf-8")
    (style,) = re.findall(r"<style>(.*?)</style>", svg)
    assert style.startswith("@media(prefers-reduced-motion:no-preference){")
    assert [
        each.get("opacity") for each in ElementTree.fromstring(svg).iter(f"{SVG}g") if each.get("class")
    ] == ["0"]
    assert len(svg) < 80_000


def test_it_is_of_the_tool_of_the_readme(tmp_path: Path) -> None:
    (tmp_path / "tool.yaml").write_text(block("yaml"), encoding="utf-8")
    tool, svg = load(tmp_path / "tool.yaml"), PICTURE.read_text(encoding="utf-8")
    assert f"description {tool.name} " in svg
    for name, actuator in tool.actuators.items():
        assert f">{name.capitalize()}</text>" in svg
        assert f"confirmed ≤ −{actuator.confirmed_kpa:g}" in svg


# The FMEAs that are kept: of every tool, with nothing that is not explained, and the same wherever they are played.


TOOLS = ROOT / "examples" / "tools"


def test_every_tool_has_one() -> None:
    examples = {path.parent.name for path in TOOLS.glob("*/end_effector.yaml")}
    assert EVERY.keys() == {"verdin_gripper", *examples}
    assert {path.stem for path in KEPT.glob("*.csv")} == EVERY.keys()


def test_every_example_links_to_its_own() -> None:
    for path in TOOLS.glob("*/README.md"):
        assert f"docs/reference/fmea/{path.parent.name}.csv" in path.read_text(encoding="utf-8"), path


@pytest.mark.parametrize("name", EVERY)
def test_nothing_is_unexplained(name: str) -> None:
    rows = rows_of(name)
    assert [row for row in rows if row["unexplained"] != "0"] == []
    assert {row["function"] for row in rows} == {"begin a grip", "grip", "hold", "release"}


def again(name: str, faults: Collection[str]) -> tuple[list[dict[str, str]], list[dict[str, str]]]:
    """The rows of some failure modes: played now, and as they are kept. Virtual time from a seed: the same anywhere."""
    description, cells, _ = chosen(name)
    some = [cell for cell in cells if cell.fault in faults]
    played = {cell.id: play(description, cell) for cell in some}
    rows = list(csv.DictReader(StringIO(fmea(description, some, played))))
    modes = {(row["item"], row["failure mode"]) for row in rows}
    return rows, [row for row in rows_of(name) if (row["item"], row["failure mode"]) in modes]


@pytest.mark.timeout(600)
def test_two_failure_modes_are_the_same_when_they_are_played_again() -> None:
    """Of a tool of whose cells one in four is played: a second each."""
    rows, kept = again("diy_text", {"never-confirms:cups", "stuck-release:cups"})
    assert len(rows) >= 4
    assert rows == kept


@pytest.mark.nightly
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", EVERY)
def test_every_table_is_the_same_when_it_is_played_again(name: str) -> None:
    """A third of the failure modes where there are many."""
    faults = sorted({cell.fault for cell in chosen(name)[1]})
    rows, kept = again(name, faults if len(faults) < 30 else faults[::3])
    assert rows == kept
