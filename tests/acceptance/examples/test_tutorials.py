"""Each command of the tutorials does what the page says, and prints what stands below it."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import pytest

from tests.support.places import DOCS

from .conftest import Environment

TUTORIALS, IMAGES = DOCS / "tutorials", DOCS / "images"
UPDATE = bool(os.environ.get("EEHAL_UPDATE"))
PICTURES = {
    "first-grip": {},
    "my-first-kind": {},
    "my-first-proof": {"runs/proof/grip-decided/timeline.svg": "counterexample.svg"},
    "my-own-model": {},
    "my-own-tool": {"mine.svg": "my-tool.svg"},
}
"""Of each tutorial, what it leaves and its page shows; ``EEHAL_UPDATE=1`` copies them."""
pytestmark = [pytest.mark.wall, pytest.mark.timeout(300)]


def commands(page: Path) -> list[tuple[str, list[str]]]:
    """Each command of a page, and the lines below it."""
    found: list[tuple[str, list[str]]] = []
    for block in re.findall(
        r"^```console\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    ):
        for line in block.splitlines():
            if line.startswith("$ "):
                found.append((line[2:], []))
            else:
                found[-1][1].append(line)
    return found


def printed(lines: list[str]) -> re.Pattern[str]:
    """What the lines of a page stand for: `…` is anything within a line, or any lines where it stands alone."""
    parts = [
        r"(?:.*\n)*?" if line == "…" else ".*?".join(map(re.escape, line.rstrip().split("…"))) + " *\n"
        for line in lines
    ]
    return re.compile("".join(parts))


@pytest.mark.thinned  # long
@pytest.mark.parametrize("name", PICTURES)
def test_the_commands_print_what_the_page_says(
    fresh: Environment, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(fresh.folder / "state"))
    monkeypatch.setenv("COLUMNS", "120")
    for command, expected in commands(TUTORIALS / f"{name}.md"):
        said = fresh.run("bash", "-c", f"exec 2>&1\n{command}").stdout
        page = "\n".join(expected)
        assert printed(expected).fullmatch(said), f"$ {command}\n{said}\nThe page says:\n{page}"
    for left, shown in PICTURES[name].items():
        assert (fresh.folder / left).read_text(encoding="utf-8").startswith("<?xml")
        if UPDATE:
            shutil.copy(fresh.folder / left, IMAGES / shown)


def test_every_tutorial_is_run() -> None:
    assert PICTURES.keys() == {path.stem for path in TUTORIALS.glob("*.md")} - {"index"}
