"""The page's one HTML file, for a live tool or for a recording, served or as a file of its own."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from html import escape
from importlib.resources import files
from typing import Any

from pydantic_core import to_json

_STATIC = files("end_effector_hal") / "page" / "static"
_IMPORT = re.compile(r'^import (\{[^}]*\}) from "/static/([\w.]+)";$', re.MULTILINE)
_EXPORT = re.compile(r"^export (class|function|const) (\w+)", re.MULTILINE)
_NAME = re.compile(r"[A-Za-z][\w.-]*")


def static_file(name: str) -> bytes | None:
    """A file that the browser asks for; None: there is none of that name."""
    # looked up among the names that there are: the system refuses to look for one that is too long
    found = next((each for each in _STATIC.iterdir() if each.name == name), None)
    return found.read_bytes() if found is not None and found.is_file() and _NAME.fullmatch(name) else None


def page_html(title: str, *, recorded: bool, csrf: str = "") -> str:
    """The page for a live tool, or for recordings."""
    html = (_STATIC / "index.html").read_text()
    kept, left_out = ("recorded", "live") if recorded else ("live", "recorded")
    html = re.sub(rf"[ \t]*<!--{left_out}-->.*?<!--/{left_out}-->\n?", "", html, flags=re.DOTALL)
    html = re.sub(rf"<!--/?{kept}-->", "", html)
    return html.replace("{{csrf}}", csrf).replace("{{title}}", escape(title))


def report_html(
    title: str,
    contents: list[dict[str, Any]],
    verdicts: list[dict[str, Any]],
    differences: dict[str, Any] | None = None,
) -> str:
    """Recordings in one file that asks nobody for anything.

    Args:
        title: of the file.
        contents: documents of recordings.
        verdicts: what was said of each by `judge_recording`.
        differences: of two, by `compare_recordings`.
    """
    return _one_file(title, {"recordings": report_data(contents, verdicts, differences)})


def report_data(
    contents: list[dict[str, Any]],
    verdicts: list[dict[str, Any]],
    differences: dict[str, Any] | None = None,
) -> bytes:
    """Documents with their verdicts, as a file holds them."""
    return to_json({"contents": contents, "verdicts": verdicts, "differences": differences}, fallback=dict)


def runs_html(title: str, rows: list[dict[str, Any]], runs: Mapping[int, bytes]) -> str:
    """Many runs in one file: a table of them, and behind a row the run as `report_html` has it.

    Args:
        title: of the file.
        rows: ``name, started, tool, story, length_s, ok, replay`` of each.
        runs: `report_data` by the number of the row; what is not among them is in the table only.
    """
    data = {f"run-{number}": each for number, each in runs.items()}
    return _one_file(title, {"index": to_json(rows), **data})


def _one_file(title: str, data: Mapping[str, bytes]) -> str:
    script = _one_script("recording.js")
    plot, style = _text("uPlot.iife.min.js"), _text("uPlot.min.css") + _text("style.css")
    licence = _text("uPlot.LICENSE.txt").replace("*/", "* /")
    plot = f"/*\n{licence}*/\n{plot}"
    policy = (
        f"default-src 'none'; script-src {_hash(plot)} {_hash(script)}; style-src {_hash(style)}; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )
    html = page_html(title, recorded=True)
    head = re.compile(r"<link rel=\"icon\".*?(?=</head>)", re.DOTALL)
    inside = (
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n<link rel="icon" href="data:,">\n'
        f"<style>{style}</style>\n<script>{plot}</script>\n"
    )
    html = head.sub(lambda _: inside, html, count=1)
    # what stands in a script element ends at the first </script>, whatever it is: no < is left in the data
    texts = {name: each.decode().replace("<", "\\u003c") for name, each in data.items()}
    kept = "".join(
        f'<script type="application/json" id="{name}">{text}</script>\n' for name, text in texts.items()
    )
    return html.replace("</body>", f"{kept}<script>{script}</script>\n</body>")


def _text(name: str) -> str:
    return (_STATIC / name).read_text()


def _one_script(first: str) -> str:
    """A module with all that it imports, in one script that imports nothing."""
    done: dict[str, str] = {}

    def add(name: str) -> None:
        if name in done:
            return
        text = _text(name)
        for found in _IMPORT.finditer(text):
            add(found[2])
        names = ", ".join(found[2] for found in _EXPORT.finditer(text))
        text = _EXPORT.sub(r"\1 \2", _IMPORT.sub(r'const \1 = modules["\2"];', text))
        done[name] = f'modules["{name}"] = (() => {{\n{text}\nreturn {{ {names} }};\n}})();\n'

    add(first)
    return f'"use strict";\nconst modules = {{}};\n{"".join(done.values())}'


def _hash(content: str) -> str:
    return f"'sha256-{b64encode(sha256(content.encode()).digest()).decode()}'"
