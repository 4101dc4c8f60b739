"""The table of what rests on D and on the message delay is what is computed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.support.nightly import NIGHTLY
from tests.unit.verification.proof.rests_on import ASSUMED, Assumption, failing, first_failing, row, table

pytestmark = pytest.mark.thinned  # long

PAGE = Path(__file__).parents[4] / "docs/explanation/verification.md"


def written(assumed: Assumption) -> str:
    return next(
        line
        for line in PAGE.read_text(encoding="utf-8").splitlines()
        if line.startswith(f"| {assumed.words} |")
    )


def ends(line: str) -> dict[str, int]:
    """The requirements of a row, each with the first value with which it does not hold."""
    return {
        id_: int(value)
        for ids, value in re.findall(r"((?:`[a-z-]+`(?:, )?)+) from (\d+) ms on", line)
        for id_ in re.findall(r"`([a-z-]+)`", ids)
    }


@pytest.mark.parametrize("assumed", ASSUMED, ids=[assumed.constant for assumed in ASSUMED])
def test_the_first_that_stops_to_hold_is_where_the_table_says(assumed: Assumption) -> None:
    id_, first_ms = min(ends(written(assumed)).items(), key=lambda each: each[1])
    assert failing(assumed.constant, first_ms - 1) == frozenset()
    assert failing(assumed.constant, first_ms) == {id_}


@pytest.mark.skipif(not NIGHTLY, reason="takes minutes: `make nightly` computes it")
@pytest.mark.timeout(3600)
def test_the_table_is_what_is_computed() -> None:
    assert [written(assumed) for assumed in ASSUMED] == list(table())


def test_each_requirement_ends_where_it_stops_to_hold() -> None:
    asked: list[int] = []

    def fails(ms: int) -> frozenset[str]:
        asked.append(ms)
        return frozenset(id_ for id_, first in {"a": 56, "b": 467, "c": 1}.items() if ms >= first)

    assumed = Assumption("D", "reaction bound D", (1, 50, 100, 500))
    found = first_failing(assumed.tried, fails)
    assert found == {"a": 56, "b": 467, "c": 1}
    assert len(asked) < 30
    line = row(assumed, found)
    assert line.endswith("| 1 ms to 0.5 s | `c` from 1 ms on; `a` from 56 ms on; `b` from 467 ms on |")
    assert ends(line) == found
