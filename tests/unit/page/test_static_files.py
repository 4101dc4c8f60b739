"""Files of the page: those that there are, and no traceback for a name that no file can have."""

from __future__ import annotations

import pytest

from end_effector_hal.page._html import static_file


def test_a_file_of_the_page() -> None:
    assert b"import" in (static_file("recording.js") or b"")


@pytest.mark.parametrize(
    "name",
    ["a" * 60_000 + ".js", "no.js", "", ".", "..", "../_html.py", "a\0.js", "\udcff.js", "recording.js/"],
)
def test_there_is_no_such_file(name: str) -> None:
    assert static_file(name) is None
