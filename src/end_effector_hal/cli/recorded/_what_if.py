"""``eehal replay --description``: the whole other story beside the recorded one, as text and as a figure."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli._figures import figures
from end_effector_hal.cli._progress import Progress
from end_effector_hal.vocabulary import display_name

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_hal.recording import Grip
    from end_effector_hal.verification.whatif import ApartSpan, LinePair, WhatIf

MOST_SPANS = 10
MOST_SAME = 6
"""So many lines that are the same in both runs are printed in a row; of more, the first and the last."""


def play_other(recording: Path, tool: Description, *, shown: bool) -> WhatIf:
    """What another tool would have made of a recording; raises ModelError, UsageError.

    Args:
        recording: a folder with traces, or one trace.
        tool: the other one.
        shown: whether progress is shown.
    """
    from end_effector_hal.page.recorded import RecordingFiles
    from end_effector_hal.verification.whatif import what_if

    with Progress(f"Playing {recording} with {tool.source.name}", shown=shown):
        files = RecordingFiles(recording)
        return what_if(files.entries(), files.description, tool)


def draw_what_if(told: WhatIf, output: Path) -> Path:
    """Write the figure of both; raises MissingExtraError, UsageError."""
    return figures().save(figures().what_if(told), output)


def print_what_if(told: WhatIf) -> None:
    """Both verdicts, each grip, the lines of both in one order of time, and from where on the other one is a guess."""
    from end_effector_hal.verification.whatif import changes

    ours, theirs = told.recorded, told.other
    click.echo(f"  what if, with {theirs.description.source.name} ({theirs.info.hash}):")
    for change in changes(ours.description, theirs.description):
        click.echo(f"    {change}")
    click.echo(f"    recorded  {ours.story.verdict}")
    click.echo(f"    other     {theirs.story.verdict}")
    if told.same:
        click.echo("    The whole story is the same, to the µs.")
    for pair in told.grips:
        begun = pair.recorded or pair.other
        assert begun is not None
        guess = "" if pair.guess_s is None else f" (a guess from {pair.guess_s:.3f} s on)"
        decided = f"recorded {_decided(pair.recorded)}; other {_decided(pair.other)}"
        click.echo(f"    grip at {begun.start_s:.3f} s: {decided}{guess}")
    if not told.same:
        click.echo(
            "    = in both, ~ in both at another time, - only recorded, + only with the other description"
        )
        for line in _rows(told):
            click.echo(f"    {line}")
    if told.spans:
        times = [_span(told, span) for span in told.spans[:MOST_SPANS]]
        more = f" and {len(told.spans) - MOST_SPANS} times more" if len(told.spans) > MOST_SPANS else ""
        click.echo(
            f"    A guess from {', '.join(times)}{more}: the recorded tool did not see the other outputs, and the"
        )
        click.echo(
            "    readings answer its own. It ends where both are at rest: in stand-by, nothing active or sensed."
        )
    else:
        click.echo(
            "    Both drive the same outputs all the time: the other story is as good as the recording."
        )
    for side, who in ((ours, "recorded"), (theirs, "other")):
        if side.left_out:
            click.echo(
                f"    note: {side.left_out} lines of the {who} story are left out: there are too many."
            )
    for note in told.notes:
        click.echo(f"    note: {note}")


def _span(told: WhatIf, span: ApartSpan) -> str:
    end = "the end" if span.until is None else f"{told.seconds(span.until):.3f} s"
    return f"{told.seconds(span.since):.3f} s to {end}"


def _decided(grip: Grip | None) -> str:
    if grip is None:
        return "no grip"
    took = "" if grip.decided_s is None else f" after {grip.decided_s - grip.start_s:.3f} s"
    late = [
        f"{display_name(name)} on attempt {number}"
        for name, number in grip.attempts_by_actuator.items()
        if number > 1
    ]
    return f"{grip.decision}{took}" + (f" ({', '.join(late)})" if late else "")


def _rows(told: WhatIf) -> Iterator[str]:
    """The lines with what happens between them: the readings answer other outputs, or no longer do."""
    marks = [(told.seconds(span.since), f"──── from here on a guess: {span.why}") for span in told.spans]
    marks += [
        (told.seconds(span.until), "──── both tools are at rest: no guess any more")
        for span in told.spans
        if span.until is not None
    ]
    marks.sort()
    for same, group in groupby(_with_marks(told, marks), lambda row: row[0]):
        rows = [text for _, text in group]
        if same and len(rows) > MOST_SAME:
            rows = [*rows[:2], f"{'':>20}… {len(rows) - 4} lines that are the same", *rows[-2:]]
        yield from rows


def _with_marks(told: WhatIf, marks: list[tuple[float, str]]) -> Iterator[tuple[bool, str]]:
    left = list(marks)
    for line in told.lines:
        # a mark stands below what has led to it
        while left and left[0][0] < line.time_s:
            at_s, text = left.pop(0)
            yield False, f"{at_s:>10.3f} s          {text}"
        yield line.same, _row(line)
    yield from ((False, f"{at_s:>10.3f} s          {text}") for at_s, text in left)


def _row(line: LinePair) -> str:
    if line.other_s is None:
        return f"{line.recorded_s:>10.3f} s        - {line.text}"
    if line.recorded_s is None:
        return f"{line.other_s:>10.3f} s        + {line.text}"
    if line.same:
        return f"{line.recorded_s:>10.3f} s        = {line.text}"
    return f"{line.recorded_s:>10.3f} s {line.other_s - line.recorded_s:>+6.3f} ~ {line.text}"
