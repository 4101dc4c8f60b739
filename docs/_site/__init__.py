"""Pages that are written by what the program knows: some each time that the site is built, some committed.

A line ``<!-- written by docs/_site: NAME -->`` of a page becomes the Markdown of that name. Those that are committed
are in `COMMITTED`, and a test holds them against what the program says. Sphinx is needed by the first ones only.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from ._api import stands_elsewhere
from ._automata import automata
from ._committed import COMMITTED, committed_page
from ._interlocks import interlock_tests
from ._requirements import requirements
from ._ros import messages

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.environment import BuildEnvironment

__all__ = ["COMMITTED", "committed_page", "setup", "with_levels"]

PARTS: dict[str, Callable[[], str]] = {
    "automata": automata,
    "interlock-tests": interlock_tests,
    "messages": messages,
    "requirements": requirements,
}
_MARK = re.compile(r"^<!-- written by docs/_site: ([a-z-]+) -->$", re.MULTILINE)


def setup(app: Sphinx) -> dict[str, bool]:
    """What Sphinx calls."""
    app.connect("source-read", _write)
    app.connect("autodoc-skip-member", stands_elsewhere)
    app.connect("env-get-outdated", _outdated)
    app.connect("html-page-context", with_levels, priority=900)  # when the theme has made its own
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _write(app: Sphinx, name: str, source: list[str]) -> None:
    from sphinx.errors import ExtensionError

    def written(mark: re.Match[str]) -> str:
        if mark[1] not in PARTS:
            raise ExtensionError(f"{name}: nothing in docs/_site writes {mark[1]!r}.")
        return PARTS[mark[1]]()

    source[0] = _MARK.sub(written, source[0])


def _outdated(
    app: Sphinx, env: BuildEnvironment, added: object, changed: object, removed: object
) -> list[str]:
    """What they are written from is anywhere in the source: they are never up to date."""
    return [name for name in env.found_docs if _MARK.search(env.doc2path(name).read_text(encoding="utf-8"))]


def with_levels(app: Sphinx, name: str, template: str, context: dict[str, object], tree: object) -> None:
    """Sphinx writes the captions of a toctree as headings without a level, which a screen reader needs."""
    for key, html in context.items():
        if isinstance(html, str) and 'role="heading"' in html:
            context[key] = html.replace('role="heading"', 'role="heading" aria-level="2"')
