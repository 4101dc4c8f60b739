"""Write recordings to one HTML file: the page of `eehal page RECORDING` with all data that the browser needs."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

from pydantic_core import to_json

from end_effector_hal.page import page_html, static_file

_IMPORT = re.compile(r'^import (\{[^}]*\}) from "/static/([\w.]+)";$', re.MULTILINE)
_EXPORT = re.compile(r"^export (class|function|const) (\w+)", re.MULTILINE)


def report_html(
    title: str,
    contents: list[dict[str, Any]],
    verdicts: list[dict[str, Any]],
    differences: dict[str, Any] | None = None,
) -> str:
    """Return recordings in one file that makes no network requests.

    Args:
        title: title of the file.
        contents: documents of recordings.
        verdicts: the result of `judge_recording` for each of them.
        differences: the result of `compare_recordings` for two recordings.
    """
    return _one_file(title, {"recordings": report_data(contents, verdicts, differences)})


def report_data(
    contents: list[dict[str, Any]],
    verdicts: list[dict[str, Any]],
    differences: dict[str, Any] | None = None,
) -> bytes:
    """Return documents with their verdicts, as JSON for a file."""
    return to_json({"contents": contents, "verdicts": verdicts, "differences": differences}, fallback=dict)


def runs_html(title: str, rows: list[dict[str, Any]], runs: Mapping[int, bytes]) -> str:
    """Return many runs in one file: a table whose rows open a run as in `report_html`.

    Args:
        title: title of the file.
        rows: ``name, started, tool, story, length_s, ok, replay`` of each run.
        runs: `report_data` by row number; a run that is missing here is in the table only.
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
    return (static_file(name) or b"").decode()


def _one_script(first: str) -> str:
    """Bundle a module with everything that it imports into one script without imports."""
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
