"""What is generated from the program, or from tables of the tests, and committed: pages of the reference.

``EEHAL_UPDATE=1 pytest tests/unit/docs/test_committed.py`` writes them.
"""

from __future__ import annotations

import os
import sys

import pytest

from tests.support.fmea import fmea_page
from tests.support.places import DOCS
from tests.unit.trials.mutants.page import wrong_products

sys.path.insert(0, str(DOCS))
from _site import COMMITTED, committed_page, with_levels

UPDATE = bool(os.environ.get("EEHAL_UPDATE"))
OF_TESTS = {"fmea": fmea_page, "wrong_products": wrong_products}


@pytest.mark.parametrize("name", [*COMMITTED, *OF_TESTS])
def test_a_page_says_what_the_program_says(name: str) -> None:
    path = DOCS / "reference" / f"{name}.md"
    page = committed_page(name, OF_TESTS.get(name))
    if UPDATE:
        path.write_text(page, encoding="utf-8")
    assert path.read_text(encoding="utf-8") == page, "see the head of this file"


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("alarms", "`grip.leak`"),
        ("commands", "## `eehal arbiter`"),
        ("devices", "## robotiq-2f85"),
        ("errors", "### EE-205"),
        ("interlocks", "## IL-09"),
        ("mutants", "| edge deleted |"),
        ("ros", "`EndEffectorState`"),
        ("wrong_products", "a journal that is not written"),
    ],
)
def test_what_is_generated_is_there(name: str, written: str) -> None:
    assert written in (DOCS / "reference" / f"{name}.md").read_text(encoding="utf-8")


def test_the_captions_of_the_site_are_headings_with_a_level() -> None:
    context: dict[str, object] = {"furo_navigation_tree": '<p class="caption" role="heading">', "title": None}
    with_levels(None, "", "", context, None)  # type: ignore[arg-type]
    assert context == {
        "furo_navigation_tree": '<p class="caption" role="heading" aria-level="2">',
        "title": None,
    }
