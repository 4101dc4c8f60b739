"""Each page of a board has the same parts, and a description that `eehal check` accepts."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli import _check
from tests.support.places import DOCS

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
