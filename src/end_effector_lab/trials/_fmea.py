"""The failure modes of a tool and their effects as played (FMEA), for a person to sign."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Mapping, Sequence
from io import StringIO

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import display_name
from end_effector_lab.testbench import FAULTS

from ._case import NOMINAL
from ._effects import GRIP, HELD, PHASES, RELEASE, REST, Effects
from ._grid import NOTHING, Cell
from ._outcome import Outcome
from ._run_grid import Played

COLUMNS = (
    "item", "function", "failure mode", "cause", "local effect", "effect on the part", "detection", "reaction",
    "time_s", "severity", "occurrence", "cells", "unexplained",
)  # fmt: skip
KEY, SIGNED = ("item", "function", "failure mode"), ("severity", "occurrence")
SignedCells = Mapping[tuple[str, ...], tuple[str, ...]]
"""Severity and occurrence by item, function and failure mode."""
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


def signed_cells(data: bytes | None) -> SignedCells:
    """Return the cells that a person filled in in an earlier FMEA; empty if it cannot be read."""
    try:
        text = (data or b"").decode("utf-8-sig")  # some spreadsheets put a mark in front
        separator = ";" if text.partition("\n")[0].count(";") >= len(KEY) else ","
        rows = list(csv.DictReader(StringIO(text, newline=""), delimiter=separator))
    except (ValueError, csv.Error):
        return {}
    found = {
        tuple(row.get(name) or "" for name in KEY): tuple((row.get(name) or "").strip() for name in SIGNED)
        for row in rows
    }
    return {key: signed for key, signed in found.items() if any(signed)}


def fmea(
    description: Description,
    cells: Sequence[Cell],
    played: Mapping[str, Played],
    signed: SignedCells | None = None,
) -> str:
    """Return the FMEA as CSV: a row for each fault and function, from the cells without a command.

    Args:
        cells: cells of the matrix.
        played: their results by id.
        signed: severity and occurrence; empty cells without it.
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
        table.writerow(_row(description, fault, phase, group, signed or {}))
    return text.getvalue()


def _row(
    description: Description,
    fault: str,
    phase: str,
    group: Sequence[tuple[Cell, Played]],
    signed: SignedCells,
) -> list[str | int]:
    cell, rows = group[0][0], [each for _, each in group]
    meaning = next(each.meaning for each in FAULTS if each.name == cell.name)
    outcomes = Counter(each.outcome.value for each in rows)
    told = Counter(each.told for each in rows if each.told)
    longest = max(each.seconds for each in rows)
    first = [each.told_after for each in rows if each.told_after is not None]
    effects = sorted({LET_GO if each.let_go else ON_PART[each.outcome] for each in rows})
    times = f"told after {min(first):g} to {max(first):g}; " if first else ""
    effects_of = Effects(description, fault, phase, cell.moment.engaged)
    key = (display_name(effects_of.fault.place) or "Whole tool", FUNCTIONS[phase], fault)
    return [
        *key,
        meaning,
        effects_of.words,
        "; ".join(effects),
        next(iter(told.most_common(1)), ("none is needed: nothing is affected",))[0],
        "; ".join(f"{name} ({count})" for name, count in outcomes.most_common()),
        f"{times}last movement of a line after {longest:g}",
        *signed.get(key, ("", "")),
        len(rows),
        sum(bool(each.objections) for each in rows),
    ]
