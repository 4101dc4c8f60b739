"""The table of cases from the bench: each row names a test that exists, so that it is run."""

from __future__ import annotations

import ast
import re
from functools import cache

import pytest

from tests.support.places import DOCS, ROOT

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
    assert len(ROWS) >= 40
    assert len(set(ROWS)) == len(ROWS)
