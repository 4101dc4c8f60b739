"""Lines of an input that nobody types."""

from __future__ import annotations

import os

from end_effector_hal.wires import PipedLines
from end_effector_hal.wires._piped_lines import LONGEST_LINE


def test_lines_come_in_pieces_and_the_last_may_lack_its_end() -> None:
    read, write = os.pipe()
    lines = PipedLines(read)
    for piece in (b"scenario nom", b"inal\nscenario noise:0.1\nqu"):
        os.write(write, piece)
    assert [lines.next(), lines.next()] == ["scenario nominal", "scenario noise:0.1"]
    os.write(write, b"it")
    os.close(write)
    assert [lines.next(), lines.next()] == ["quit", None]
    os.close(read)


def test_a_line_without_an_end_is_bounded() -> None:
    read, write = os.pipe()
    lines, sent = PipedLines(read), 0
    os.set_blocking(write, False)
    while sent < 2 * LONGEST_LINE:  # a pipe holds less than that
        sent += os.write(write, b"x" * 4_096)
        if sent == LONGEST_LINE:
            line = lines.next()
    assert line == "x" * LONGEST_LINE
    os.close(write)
    assert lines.next() == "x" * LONGEST_LINE
    os.close(read)


def test_an_input_that_is_closed_or_another_programs_has_ended() -> None:
    assert PipedLines(-1).next() is None
