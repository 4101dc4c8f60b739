"""What the README shows works: its ten lines, its commands, its links."""

from __future__ import annotations

import re

from end_effector_hal.description import examine_text
from tests.support.places import ROOT

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
        for command in ("campaign", "matrix", "compare", "tune", "verify --sweep"):
            assert f"`eehal {command}`" in page
        assert "how-to/cluster.md" in page


def test_each_link_leads_to_a_file() -> None:
    links = {target.partition("#")[0] for target in re.findall(r"\]\(([^)]+)\)", README)}
    here = {target for target in links if "://" not in target}
    assert len(here) > 20
    assert [target for target in sorted(here) if not (ROOT / target).is_file()] == []
