"""The integers of Table II in the glossary are those that are logged."""

from __future__ import annotations

import re

import pytest

from end_effector_hal.vocabulary import Command, EndEffectorState
from tests.support.places import DOCS

GLOSSARY = (DOCS / "reference/glossary.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("begins", "table"), [("States of the end-effector: ", EndEffectorState), ("Commands: ", Command)]
)
def test_table_ii_has_its_integers(begins: str, table: type[EndEffectorState] | type[Command]) -> None:
    sentence = " ".join(GLOSSARY.split()).partition(begins)[2].partition(".")[0]
    written = {name: int(number) for name, number in re.findall(r"(\w+) (-?\d+)", sentence)}
    assert written == {each.name: each.value for each in table}
