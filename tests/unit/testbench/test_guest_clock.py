"""The clock of an emulated machine, which goes as it likes."""

from __future__ import annotations

import threading
from collections.abc import Iterator

from end_effector_hal.wires import now_us
from end_effector_lab.testbench.inputs import Monotonic, clock_of
from tools.board._qemu import GuestClock


class Counter:
    """Answers with these seconds, one after the other; "": the machine has ended."""

    def __init__(self, *seconds: float) -> None:
        self.left: Iterator[float] = iter(seconds)
        self.asked = 0

    def __call__(self, command: str) -> str:
        assert command == "readl 0x30370054"
        self.asked += 1
        seconds = next(self.left, None)
        return "" if seconds is None else f"OK {int(seconds * 32768) % 2**32:#018x}"


class Never(threading.Event):
    """Waits for no time at all, and notes for how long it was to be."""

    def __init__(self) -> None:
        super().__init__()
        self.waits: list[float] = []

    def wait(self, timeout: float | None = None) -> bool:
        assert timeout is not None
        self.waits.append(timeout)
        return False


def test_it_counts_from_the_first_question() -> None:
    clock = GuestClock(Counter(100, 100, 100.5, 102))
    assert [clock.now_us() for _ in range(4)] == [0, 0, 500_000, 2_000_000]


def test_its_counter_begins_anew() -> None:
    clock = GuestClock(Counter(131071, 131073))
    assert [clock.now_us() for _ in range(2)] == [0, 2_000_000]


def test_it_stands_still_when_the_machine_has_ended() -> None:
    clock = GuestClock(Counter(1, 3))
    assert [clock.now_us() for _ in range(4)] == [0, 2_000_000, 2_000_000, 2_000_000]


def test_it_waits_as_long_as_the_machine_needs() -> None:
    """Half a millisecond is not asked for, nor more than a tenth of a second at once."""
    counter, never = Counter(0, 0, 0, 0.0625, 0.109375, 0.125), Never()
    clock = GuestClock(counter)
    clock.now_us()
    assert not clock.wait(never, 110_000)
    assert never.waits == [0.1, 0.1, 0.0475, 0.001]
    assert counter.asked == 6


def test_it_waits_until_the_end_only() -> None:
    stop = threading.Event()
    stop.set()
    clock = GuestClock(Counter(0, 0))
    clock.now_us()
    assert clock.wait(stop, 1_000_000)


def test_other_lines_share_our_clock() -> None:
    class Inputs:
        pass

    clock = clock_of(Inputs())  # type: ignore[arg-type]
    assert isinstance(clock, Monotonic)
    before = now_us()
    assert not clock.wait(threading.Event(), before + 2000)
    assert clock.now_us() >= before + 2000
