"""The table of the interlocks: each row names requirements, files and tests that exist."""

from __future__ import annotations

import re
import sys

import pytest

from end_effector_hal.page.view._interlocks import RULES
from tests.support.places import DOCS, ROOT

sys.path.insert(0, str(DOCS))
from _site import _interlocks

PAGE = (DOCS / "reference" / "interlocks.md").read_text(encoding="utf-8")
ROWS = {row[0]: row[1:] for line in PAGE.splitlines() if (row := line.strip("| ").split(" | "))[0] in RULES}


def test_each_interlock_has_a_row() -> None:
    assert list(ROWS) == list(RULES)


@pytest.mark.parametrize("name", RULES)
def test_a_row_names_what_exists(name: str) -> None:
    proven, enforced, tested = ROWS[name]
    ids = re.findall(r"`([a-z-]+)`", proven)
    assert set(ids) <= _interlocks.required().keys()
    assert bool(ids) is not proven.startswith("none: ")
    for place in re.findall(r"\[(src/[^]]+)\]", enforced):
        assert (ROOT / place).is_file(), place
    for file, function in re.findall(r"`([\w/.]+)::(\w+)`", tested):
        assert f"def {function}(" in (ROOT / "tests" / file).read_text(encoding="utf-8")
    assert enforced
    assert tested


def test_an_interlock_that_no_requirement_names_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_interlocks, "required", lambda: {"accepted": "A grip is accepted (IL-05)."})
    assert _interlocks.proven_by("IL-05") == "`accepted`"
    with pytest.raises(LookupError, match="IL-06: proven by"):
        _interlocks.proven_by("IL-06")
