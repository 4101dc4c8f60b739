"""The list itself: long enough, and every difference that it knows is a row of the table and is named by a check."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from tests.acceptance.contract.differences import Difference
from tests.support.places import DOCS

FILES = sorted(each for each in Path(__file__).parent.glob("test_*.py") if each.name != Path(__file__).name)


def test_the_table_of_the_docs_has_these_rows_and_no_others() -> None:
    page = (DOCS / "reference/ros2.md").read_text(encoding="utf-8")
    text = page.partition("## What differs from ROS 1\n")[2]
    rows = re.findall(r"^\| (.+?) \| (.+?) \| (.+?) \| (.*?) ?\|$", text.partition("\n## ")[0], re.MULTILINE)
    assert [name for name, *_ in rows] == [each.value for each in Difference]
    assert all(one != two and why for _, one, two, why in rows), "in words, with a reason"


def test_every_difference_is_named_by_a_check() -> None:
    used = {
        name for each in FILES for name in re.findall(r"Difference\.(\w+)", each.read_text(encoding="utf-8"))
    }
    assert used == {each.name for each in Difference}


def test_there_are_sixty_checks_and_each_once() -> None:
    """A check that is tried with several values counts as one."""
    names = [
        node.name
        for each in FILES
        for node in ast.parse(each.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    ]
    assert len(names) == len(set(names)) >= 60


def test_no_check_imports_ros() -> None:
    for each in (
        *FILES,
        *(Path(__file__).with_name(name) for name in ("driver.py", "hal.py", "conftest.py")),
    ):
        assert not re.search(
            r"^\s*(import|from) (rospy|rclpy|actionlib|\w+_msgs|\w+_srvs)\b", each.read_text(), re.MULTILINE
        )
