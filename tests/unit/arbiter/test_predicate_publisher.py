"""What the publisher repeats to the line arbiter between two frames of a slow link; in virtual time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from end_effector_hal.arbiter import PredicatePublisher, _predicate_publisher
from end_effector_hal.codecs import load_tool
from end_effector_hal.signals import Frame

FAULT = "no_latching_fault:cup_fault"


class Arbiter:
    """Keeps what is sent to it."""

    def __init__(self) -> None:
        self.told: list[tuple[int, Mapping[str, bool]]] = []

    def send(self, predicates: Mapping[str, bool], at_us: int) -> bool:
        self.told.append((at_us, predicates))
        return True

    def close(self) -> None:
        """Nothing is held."""


class Repetitions:
    """The event that ends the repetitions, after some of them; each waits in virtual time."""

    def __init__(self, times: int) -> None:
        self.now, self._left = 0, times

    def wait(self, timeout: float) -> bool:
        self._left -= 1
        self.now += round(timeout * 1_000_000)
        return self._left < 0


@pytest.mark.parametrize("read", [False, True])
def test_it_repeats_what_is_proven_and_never_nothing(read: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    arbiter, times = Arbiter(), Repetitions(6)
    monkeypatch.setattr(_predicate_publisher, "PredicateSender", lambda path: arbiter)
    tool = load_tool(Path("examples/tools/epick_commanded/end_effector.yaml"))
    publisher = PredicatePublisher(tool, clock=lambda: times.now)
    monkeypatch.setattr(publisher, "_ended", times)
    if read:
        publisher.frame(Frame(0, None, None, {"cup_fault": 0}))
    publisher._repeat()
    assert all(told for _, told in arbiter.told), "an empty message ends the connection to the arbiter"
    assert [at for at, told in arbiter.told if told.get(FAULT)] == ([0, 50_000, 100_000] if read else [])


def test_what_was_not_read_yet_is_not_due_again_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    arbiter = Arbiter()
    monkeypatch.setattr(_predicate_publisher, "PredicateSender", lambda path: arbiter)
    publisher = PredicatePublisher(load_tool(Path("examples/tools/epick_commanded/end_effector.yaml")))
    assert publisher.repeats_at == 0
    publisher.repeat(0)
    assert publisher.repeats_at == 40_000
    assert arbiter.told == []
