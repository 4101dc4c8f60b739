"""The page of a tool in a browser: the state of its HAL, or a recording of it.

Packages: ``view`` computes the view from records; ``link`` has the sockets of the HAL and of a testbench;
``recorded`` makes the same view of a recording; ``web`` is the server with its access rules, and alone needs the extra
``page``; ``static`` has the browser's files.
"""

from __future__ import annotations

import re
from html import escape
from importlib.resources import files

_STATIC = files("end_effector_hal") / "page" / "static"
_NAME = re.compile(r"[A-Za-z][\w.-]*")


def static_file(name: str) -> bytes | None:
    """Return a file for the browser; None if no file has that name."""
    # looked up among the names that there are: the system refuses to look for one that is too long
    found = next((each for each in _STATIC.iterdir() if each.name == name), None)
    return found.read_bytes() if found is not None and found.is_file() and _NAME.fullmatch(name) else None


def page_html(title: str, *, recorded: bool, csrf: str = "") -> str:
    """Return the page for a live tool, or for recordings."""
    html = (_STATIC / "index.html").read_text()
    kept, left_out = ("recorded", "live") if recorded else ("live", "recorded")
    html = re.sub(rf"[ \t]*<!--{left_out}-->.*?<!--/{left_out}-->\n?", "", html, flags=re.DOTALL)
    html = re.sub(rf"<!--/?{kept}-->", "", html)
    return html.replace("{{csrf}}", csrf).replace("{{title}}", escape(title))
