"""The lines of a node are written in their order by another thread, and all of them before the end."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator

import pytest

pytest.importorskip("rospy")

from end_effector_hal.nodes.process import BURST, PacedLog
from end_effector_hal.ros1._ros_node import write_line


class Rosout:
    """In place of rospy's functions, which write in the thread that calls them; it can be made to wait."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.threads: set[str] = set()
        self.goes_on = threading.Event()
        self.goes_on.set()

    def __call__(self, form: str, *values: object) -> None:
        assert self.goes_on.wait(60.0)
        self.threads.add(threading.current_thread().name)
        self.lines.append((form % values).partition(": ")[2])


@pytest.fixture
def rosout(monkeypatch: pytest.MonkeyPatch) -> Rosout:
    rosout = Rosout()
    levels = ((logging.WARNING, rosout), (logging.INFO, rosout))
    monkeypatch.setattr("end_effector_hal.ros1._ros_node._LEVELS", levels)
    return rosout


@pytest.fixture
def log(rosout: Rosout) -> Iterator[tuple[logging.Logger, PacedLog]]:
    handler, logger = PacedLog(write_line), logging.Logger("tests.log")
    logger.addHandler(handler)
    yield logger, handler
    rosout.goes_on.set()
    handler.end()


def test_a_line_never_waits_for_its_writer(rosout: Rosout, log: tuple[logging.Logger, PacedLog]) -> None:
    logger, handler = log
    rosout.goes_on.clear()
    expected = [f"line {number}" for number in range(BURST)]
    for line in expected:
        logger.info("%s", line)
    assert rosout.lines == []
    rosout.goes_on.set()
    handler.end()
    assert rosout.lines == expected
    assert rosout.threads == {"log"}


def test_after_the_end_a_line_is_written_at_once_after_all_others(
    rosout: Rosout, log: tuple[logging.Logger, PacedLog]
) -> None:
    logger, handler = log
    logger.info("first")
    handler.end()
    logger.warning("last")
    assert rosout.lines == ["first", "last"]
