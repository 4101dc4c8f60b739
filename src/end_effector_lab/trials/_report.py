"""The report of a matrix: one self-contained HTML page, and its figures as JSON."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from html import escape
from typing import Any

from ._effects import PHASES
from ._grid import COMMANDS, Cell
from ._run_grid import Played

MOST_SHOWN = 500
"""Largest number of unexplained cells that the page shows in detail."""
STYLE = """
:root { color-scheme: light dark; font: 15px/1.45 system-ui, sans-serif; }
body { margin: 2rem auto; max-width: 80rem; padding: 0 1rem; }
table { border-collapse: collapse; font-size: 0.9em; }
th, td { border: 1px solid #8886; padding: 0.2rem 0.5rem; text-align: left; vertical-align: top; }
thead th { position: sticky; top: 0; background: Canvas; }
.wrong { background: #c003; }
"""


def figures(cells: Sequence[Cell], played: Collection[Played], left_out: int) -> dict[str, Any]:
    """Return the figures of a matrix: dimensions, number of each outcome, unexplained cells."""
    return {
        "cells": len(played),
        "dropped": sum(each.dropped for each in played),
        "let_go": sum(each.let_go for each in played),
        "unexplained": sum(bool(each.objections) for each in played),
        "left_out": left_out,
        "not_played": len(cells) - len(played),
        "outcomes": dict(Counter(each.outcome.value for each in played).most_common()),
        "dimensions": {
            "faults": len({cell.fault for cell in cells}),
            "moments": len({cell.moment.name for cell in cells}),
            "commands": len({cell.command for cell in cells}),
        },
    }


def let_go(found: Mapping[str, Any]) -> str:
    """Return a phrase about parts that devices released as declared; "" if there are none."""
    return f"{found['let_go']} let go by a device that hears nothing, " if found["let_go"] else ""


def page(name: str, found: Mapping[str, Any], cells: Sequence[Cell], played: Mapping[str, Played]) -> str:
    """Return the report as HTML; ``played`` has the results by id."""
    wrong = [each for each in played.values() if each.objections]
    groups: dict[tuple[str, str], list[Played]] = {}
    for cell in cells:
        if cell.id in played:
            groups.setdefault((cell.fault, cell.moment.phase), []).append(played[cell.id])
    parts = [
        f"<!doctype html><html lang=en><meta charset=utf-8><title>Matrix of {escape(name)}</title>",
        f"<style>{STYLE}</style>",
        f"<h1>Matrix of {escape(name)}</h1>",
        f"<p>{found['cells']} cells, {found['dropped']} dropped, {let_go(found)}{found['unexplained']} unexplained; "
        f"{found['left_out']} left out, {found['not_played']} not played.</p>",
        f"<p>{escape(json.dumps(found['dimensions']))}, {escape(', '.join(COMMANDS))}.</p>",
        _table(groups),
        f"<h2>Not explained</h2><p>{len(wrong)} cells; the first {min(len(wrong), MOST_SHOWN)} are here. "
        "<code>eehal matrix TOOL --cell ID -o FOLDER</code> plays one, with its figure.</p>",
        *map(_details, wrong[:MOST_SHOWN]),
        "<h2>One cell of each fault and phase</h2>",
        *(_details(group[0]) for group in groups.values()),
    ]
    return "\n".join(parts) + "\n"


def _table(groups: Mapping[tuple[str, str], Sequence[Played]]) -> str:
    head = "".join(f"<th scope=col>{phase}" for phase in ("fault", *PHASES))
    lines = [f"<table><caption>Outcomes by fault and phase</caption><thead><tr>{head}</thead><tbody>"]
    for fault in dict.fromkeys(fault for fault, _ in groups):
        row = "".join(_field(groups.get((fault, phase), ())) for phase in PHASES)
        lines.append(f"<tr><th scope=row>{escape(fault)}{row}")
    return "\n".join([*lines, "</tbody></table>"])


def _field(group: Sequence[Played]) -> str:
    counts = Counter(each.outcome.value for each in group).most_common()
    mark = " class=wrong" if any(each.objections for each in group) else ""
    return f"<td{mark}>" + "<br>".join(f"{count} {escape(name)}" for name, count in counts)


def _details(each: Played) -> str:
    told = f"{each.told_after:g} s: {each.told}" if each.told_after is not None else "nothing"
    lines = [f"{at:+.3f} s {line} {'on' if level else 'off'}" for at, line, level in each.lines]
    rows = {
        "outcome": each.outcome,
        "told after": told, "lines after the fault": "; ".join(lines) or "none moved",
        "objections": "; ".join(each.objections) or "none",
    }  # fmt: skip
    items = "".join(f"<tr><th scope=row>{key}<td>{escape(value)}" for key, value in rows.items())
    mark = " class=wrong" if each.objections else ""
    return f"<details><summary{mark}>{escape(each.id)}</summary><table>{items}</table></details>"
