"""The tables printed at the end."""

from __future__ import annotations

from collections.abc import Mapping

from arbiter_cost import ArbiterCost
from figures import Figures, figures
from latency import Result
from rich.console import Console
from rich.table import Table
from usage import Usage
from verification import Measured, Subject

WORDS = {
    "reaction": "reaction: confirming frame → line edge",
    "reaction_seen": "  … → edge seen by the testbench",
    "command": "command: goal → first line edge",
    "state": "state: line edge → state received",
    "loss": "loss: first frame under the threshold → state",
    "loss_decided": "  … frame that decides → state",
}


def print_latencies(console: Console, title: str, result: Result) -> None:
    """Print median, p99 and maximum in ms, with those of the floor beside them."""
    table = Table(title=title, title_justify="left")
    table.add_column("ms", no_wrap=True)
    for head in ("median", "p99", "max", "n", "floor median", "p99", "max", "n", "ratio", "by block"):
        table.add_column(head, justify="right")
    for name in result.names:
        product, floor = map(figures, result.pooled(name))
        ratio, blocks = result.ratio(name), result.block_ratios(name)
        spread = f"{min(blocks):.1f}–{max(blocks):.1f}" if blocks else ""
        table.add_row(WORDS[name], *_cells(product), *_cells(floor), f"{ratio:.2f}" if ratio else "", spread)
    for name, samples in result.losses.items():
        table.add_row(WORDS[name], *_cells(figures(samples)), *[""] * 6)
    console.print(table)


def print_arbiter(console: Console, cost: ArbiterCost) -> None:
    """Print a command with and without the line arbiter, and the arbiter's usage."""
    table = Table(title="A line command, directly and through the line arbiter", title_justify="left")
    table.add_column("ms", no_wrap=True)
    for head in ("median", "p99", "max", "n"):
        table.add_column(head, justify="right")
    for text, found in (
        ("directly: call → line written", cost.direct_line),
        ("  … → call returns", cost.direct_return),
        ("through the arbiter: call → line written", cost.arbiter_line),
        ("  … → call returns", cost.arbiter_return),
    ):
        table.add_row(text, *_cells(found))
    console.print(table)
    print_usage(console, "The line arbiter while a part is held, link at 50 Hz", {"line arbiter": cost.usage})


def print_usage(console: Console, title: str, usage: Mapping[str, Usage]) -> None:
    """Print processor time, memory and wake-ups of each process, and their sums."""
    table = Table(title=title, title_justify="left")
    table.add_column("process")
    for head in ("% of a core", "PSS MiB", "RSS MiB", "wake-ups/s"):
        table.add_column(head, justify="right")
    for name, one in usage.items():
        table.add_row(name, *_used(one))
    total = [sum(getattr(one, field) for one in usage.values()) for field in Usage.__dataclass_fields__]
    table.add_section()
    table.add_row("all", *_used(Usage(*total)))
    console.print(table)


def print_verification(console: Console, measured: Measured) -> None:
    """Print seconds, states and memory of each subject."""
    table = Table(title="Verification", title_justify="left")
    table.add_column("what", min_width=40)
    for head in ("CPU s", "states", "states/s", "peak MiB", "bytes/state"):
        table.add_column(head, justify="right")
    subject = measured.alone
    for answer in subject.answers if subject else ():
        mark = "" if answer.holds else "  DOES NOT HOLD"
        table.add_row(answer.sentence + mark, *_rate(answer.seconds, answer.states), "", "")
    if subject:
        row = (*_rate(subject.seconds, subject.states), *_memory(subject))
        table.add_row(f"all of these, one by one{_left(subject)}", *row)
    subject = measured.together
    row = (*_rate(subject.seconds, subject.states), *_memory(subject))
    table.add_row(f"all requirements in one exploration, as eehal verify{_left(subject)}", *row)
    table.add_section()
    for one in measured.fischer:
        row = (*_rate(one.seconds, one.states), *_memory(one))
        table.add_row(f"Fischer, {one.size} processes{_left(one)}", *row)
    table.add_section()
    for one in measured.steps:
        row = (*_rate(one.seconds, one.states), *_memory(one))
        table.add_row(f"{one.size} steps, all requirements{_left(one)}", *row)
    console.print(table)
    if measured.growth is not None and measured.growth_of_states is not None:
        console.print(
            f"With the number N of steps time grows as N^{measured.growth:.2f}, "
            f"states as N^{measured.growth_of_states:.2f}.",
            highlight=False,
        )


def _cells(found: Figures | None) -> tuple[str, str, str, str]:
    if found is None:
        return "", "", "", "0"
    return (*(f"{us / 1000:.3f}" for us in (found.median, found.p99, found.maximum)), str(found.n))


def _used(usage: Usage) -> tuple[str, str, str, str]:
    memory = (f"{kib / 1024:.1f}" for kib in (usage.pss_kib, usage.rss_kib))
    return (f"{usage.cpu_percent:.1f}", *memory, f"{usage.wakeups_per_s:.0f}")


def _rate(seconds: float, states: int) -> tuple[str, str, str]:
    return f"{seconds:.3f}", f"{states:,}", f"{states / seconds:,.0f}" if seconds else ""


def _memory(subject: Subject) -> tuple[str, str]:
    return f"{subject.peak_kib / 1024:.0f}", f"{subject.bytes_per_state:,.0f}"


def _left(subject: Subject) -> str:
    return "" if subject.finished else " (not finished in its time)"
