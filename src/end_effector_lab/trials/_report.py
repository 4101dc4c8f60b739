"""The results of a matrix: its HTML page, its figures as JSON, and the failure modes and effects (FMEA) to sign."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from html import escape
from io import StringIO
from typing import Any

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import display_name
from end_effector_lab.testbench import FAULTS

from ._case import NOMINAL, Outcome
from ._effects import GRIP, HELD, PHASES, RELEASE, REST, Effects
from ._grid import COMMANDS, NOTHING, Cell
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


COLUMNS = (
    "item", "function", "failure mode", "cause", "local effect", "effect on the part", "detection", "reaction",
    "time_s", "severity", "occurrence", "cells", "unexplained",
)  # fmt: skip
FUNCTIONS = {REST: "begin a grip", GRIP: "grip", HELD: "hold", RELEASE: "release"}
ON_PART = {
    Outcome.AT_REST: "none is held",
    Outcome.REFUSED: "none is held",
    Outcome.SUCCESS: "held",
    Outcome.FAILED: "not picked up",
    Outcome.CANCELLED: "not picked up",
    Outcome.RELEASED: "put down",
    Outcome.UNWOUND: "not picked up",
    Outcome.HELD: "outputs stay; the part is as well held as the failure leaves it",
    Outcome.STILL_THERE: "perhaps still on the tool",
    Outcome.UNFINISHED: "unknown",
}
LET_GO = "falls: its device lets go when it hears nothing"


def fmea(
    description: Description,
    cells: Sequence[Cell],
    played: Mapping[str, Played],
) -> str:
    """Return the FMEA as CSV: a row for each fault and function, from the cells without a command.

    Args:
        cells: cells of the matrix.
        played: their results by id.
    """
    groups: dict[tuple[str, str], list[tuple[Cell, Played]]] = {}
    for cell in cells:
        if cell.command == NOTHING and cell.name != NOMINAL and cell.id in played:
            groups.setdefault((cell.fault, cell.moment.phase), []).append((cell, played[cell.id]))
    text = StringIO()
    table = csv.writer(text)
    table.writerow(COLUMNS)
    order = sorted(groups.items(), key=lambda each: PHASES.index(each[0][1]))
    faults = list(dict.fromkeys(cell.fault for cell in cells))
    for (fault, phase), group in sorted(order, key=lambda each: faults.index(each[0][0])):
        table.writerow(_row(description, fault, phase, group))
    return text.getvalue()


def _row(
    description: Description,
    fault: str,
    phase: str,
    group: Sequence[tuple[Cell, Played]],
) -> list[str | int]:
    cell, rows = group[0][0], [each for _, each in group]
    meaning = next(each.meaning for each in FAULTS if each.name == cell.name)
    outcomes = Counter(each.outcome.value for each in rows)
    told = Counter(each.told for each in rows if each.told)
    longest = max(each.seconds for each in rows)
    first = [each.told_after for each in rows if each.told_after is not None]
    effects = sorted({LET_GO if each.let_go else ON_PART[each.outcome] for each in rows})
    times = f"told after {min(first):g} to {max(first):g}; " if first else ""
    effects_of = Effects(description, fault, phase, cell.moment.engaged, cell.moment.part)
    return [
        display_name(effects_of.fault.place) or "Whole tool",
        FUNCTIONS[phase],
        fault,
        meaning,
        effects_of.words,
        "; ".join(effects),
        next(iter(told.most_common(1)), ("none is needed: nothing is affected",))[0],
        "; ".join(f"{name} ({count})" for name, count in outcomes.most_common()),
        f"{times}last movement of a line after {longest:g}",
        "",
        "",
        len(rows),
        sum(bool(each.objections) for each in rows),
    ]
