"""What a command prints of an error is a sentence: it begins upper case, unless a place or a name begins it."""

from __future__ import annotations

import re

import pytest

from end_effector_hal.description import examine_text, profile_path
from end_effector_hal.errors import DescriptionError, UsageError
from tests.support.places import DOCS
from tests.unit.conftest import Whole


def test_every_text_that_is_listed_begins_upper_case() -> None:
    page = (DOCS / "reference" / "errors.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (.*?) \|", page.partition("## While a program runs")[2], re.MULTILINE)
    listed = sorted({*rows} - {"says", "---"})
    assert len(listed) > 200
    lower = [text for text in listed if re.match(r"[a-z]+\s", UsageError(text).sentence)]
    assert lower == []


def test_a_place_begins_as_it_is_written() -> None:
    assert UsageError("it cannot be written.", where="out.csv").sentence == "out.csv: it cannot be written."
    faulty = DescriptionError(examine_text("name: 1\n", "my tool.yaml").diagnostics)
    assert faulty.sentence.startswith("my tool.yaml:1:")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "--simulate", "--scenario", "leek", str(profile_path())), "No fault is named 'leek'."),
        (("testbench", "--lines", "nowhere"), "Lines cannot be read from 'nowhere'."),
        (("demo", "--only", "nominall", "--no-ros"), "There is no scenario"),
        (("arbiter", "--profile", "nobody"), "No profile is named 'nobody'."),
    ],
)
def test_what_a_command_refuses(words: tuple[str, ...], said: str, whole: Whole) -> None:
    code, _, error = whole(*words)
    assert code == 2
    assert error.startswith(said), error
