"""Where the Python API describes a name that several packages offer: in the nearest one above its definition."""

from __future__ import annotations

import re
import sys
from functools import cache
from typing import TYPE_CHECKING

from ._markdown import ROOT

if TYPE_CHECKING:
    from sphinx.application import Sphinx

PAGES = ROOT / "docs" / "reference" / "python"


@cache
def described() -> tuple[str, ...]:
    """The modules that the pages of the API describe."""
    texts = [path.read_text(encoding="utf-8") for path in sorted(PAGES.glob("*.md"))]
    return tuple(
        name for text in texts for name in re.findall(r"^\.\. automodule:: (\S+)$", text, re.MULTILINE)
    )


def stands_elsewhere(
    app: Sphinx, what: str, name: str, member: object, skip: bool, options: object
) -> bool | None:
    """For ``autodoc-skip-member``: whether a member of a module is described in another one."""
    here, made_in = app.env.temp_data.get("autodoc:module"), getattr(member, "__module__", None)
    if what != "module" or not isinstance(made_in, str):
        return None
    homes = [
        each for each in described()
        if f"{made_in}.".startswith(f"{each}.") and name in getattr(sys.modules.get(each), "__all__", (name,))
    ]  # fmt: skip
    return True if homes and max(homes, key=len) != here else None
