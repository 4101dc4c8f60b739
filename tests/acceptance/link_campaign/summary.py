"""What a campaign has shown, for people and for programs."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

from tests.acceptance.link_campaign.episode import FUNCTIONS, Found
from tests.acceptance.link_campaign.faults import KINDS

NONE = "none"


def show(console: Console, title: str, found: Found) -> None:
    """Faults by kind and by the function that they hit, and what came of them."""
    table = Table("fault", *FUNCTIONS, "all", title=title, title_justify="left")
    for column in table.columns[1:]:
        column.justify = "right"
    for kind in KINDS:
        counts = [found.faults[kind, function] for function in FUNCTIONS]
        if sum(counts):
            table.add_row(kind, *map(str, counts), str(sum(counts)))
    totals = [sum(found.faults[kind, function] for kind in KINDS) for function in FUNCTIONS]
    table.add_section()
    table.add_row("all", *map(str, totals), str(sum(totals)))
    console.print(table)
    for name, value in counted(found).items():
        console.print(f"  {name:34} {value}")
    for sentence in [*found.violations[:20], *found.tracebacks[:3]]:
        console.print(f"  [red]{sentence}[/red]", markup=True)


def counted(found: Found) -> dict[str, int]:
    """The totals."""
    return {
        "faults": found.faults.total(),
        "frames that were delivered": found.decoded,
        "pieces that were refused": found.refused,
        "damaged frames that were delivered": found.undetected,
        "confirmations": found.confirmations,
        "false confirmations": found.false_confirmations,
        "violations": len(found.violations),
        "tracebacks": len(found.tracebacks),
    }


def as_json(found: Found) -> dict[str, Any]:
    """The same for programs."""
    faults = {
        kind: {
            function: found.faults[kind, function] for function in FUNCTIONS if found.faults[kind, function]
        }
        for kind in KINDS
    }
    return {
        "ok": holds(found),
        "by_fault_and_function": faults,
        **{name.replace(" ", "_"): value for name, value in counted(found).items()},
        "what_was_violated": found.violations,
        "what_was_raised": found.tracebacks,
    }


def holds(found: Found) -> bool:
    """Whether everything did that must."""
    return not (found.violations or found.tracebacks or found.undetected or found.false_confirmations)
