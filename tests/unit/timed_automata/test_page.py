"""docs/reference/timed_automata.md: each example of the page runs to the letter and prints what the page says."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

from tests.support.places import DOCS

PAGE = (DOCS / "reference/timed_automata.md").read_text(encoding="utf-8")
MODEL = re.search(r"```xml\n(.*?)```", PAGE, re.DOTALL)
EXAMPLES = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE, re.DOTALL)
PURPOSES = re.findall(r"^\*\*(\w+)\*\* ", PAGE, re.MULTILINE)


def test_the_page_shows_what_the_library_is_for() -> None:
    assert PURPOSES == [
        "Load", "Check", "Simulate", "Execute", "Explore", "Explain", "Find", "Monitor", "Compare",
    ]  # fmt: skip
    assert len(EXAMPLES) == len(PURPOSES) == PAGE.count("```python")


@pytest.mark.parametrize("number", range(len(EXAMPLES)), ids=PURPOSES)
def test_an_example_has_five_lines_at_most(number: int) -> None:
    assert len([line for line in EXAMPLES[number][0].splitlines() if line]) <= 5


def test_the_examples_run_to_the_letter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "lamp.xml").write_text(MODEL[1], encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}  # one example goes on from those before it
    for code, printed in EXAMPLES:
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            exec(compile(code, "docs/reference/timed_automata.md", "exec"), names)  # noqa: S102 - our own page
        assert output.getvalue() == printed, code
