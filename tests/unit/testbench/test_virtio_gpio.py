"""An emulated machine: its GPIO chip, and its clock, which goes as it likes."""

from __future__ import annotations

import struct
import threading
from collections.abc import Iterator
from pathlib import Path
from queue import Queue

import pytest

from end_effector_hal.errors import WireError
from end_effector_hal.wires import now_us
from end_effector_lab.testbench.inputs import Monotonic, clock_of
from tests.support.patience import PATIENCE_S
from tests.support.virtual_machine import GUEST, VirtualMachine
from tools.board._qemu import GuestClock
from tools.virtio_gpio import Pins, VirtioGpioInputs

NAMES = ["A", "B", "C"]
GET_NAMES, GET_DIRECTION, SET_DIRECTION, GET_VALUE, SET_VALUE = 1, 2, 3, 4, 5
NONE, OUT, IN = 0, 1, 2


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "run" / "chip.sock"


@pytest.fixture
def seen() -> Queue[tuple[str, bool]]:
    return Queue()


@pytest.fixture
def chip(path: Path, seen: Queue[tuple[str, bool]]) -> Iterator[VirtioGpioInputs]:
    inputs = VirtioGpioInputs(path, NAMES)
    inputs.start(lambda line, level, at: seen.put((line, level)))
    yield inputs
    inputs.close()
    assert not path.exists()


@pytest.fixture
def machine(chip: VirtioGpioInputs, path: Path) -> Iterator[VirtualMachine]:
    machine = VirtualMachine(path).boot()
    yield machine
    machine.off()


def test_the_driver_finds_the_lines_by_name(machine: VirtualMachine) -> None:
    config = machine.say(24, struct.pack("<III", 0, 8, 0) + bytes(8), reply=True)[12:]
    assert struct.unpack("<HxxI", config) == (3, len(b"A\0B\0C\0"))
    assert machine.ask(GET_NAMES, 0, room=7) == b"\0A\0B\0C\0"


def test_the_answer_comes_after_the_edge_was_told(
    machine: VirtualMachine, seen: Queue[tuple[str, bool]]
) -> None:
    machine.ask(SET_VALUE, 1, 1)
    assert seen.empty(), "a value is no level while the line is no output"
    machine.ask(SET_DIRECTION, 1, OUT)
    assert seen.get_nowait() == ("B", True)
    assert machine.ask(GET_VALUE, 1) == b"\0\1"
    assert machine.ask(GET_DIRECTION, 1) == bytes([0, OUT])


@pytest.mark.parametrize("direction", [NONE, IN])
def test_a_line_that_is_let_go_falls_and_is_not_remembered(
    machine: VirtualMachine, seen: Queue[tuple[str, bool]], direction: int
) -> None:
    machine.drive(0, True)
    machine.ask(SET_DIRECTION, 0, direction)
    assert [seen.get_nowait(), seen.get_nowait()] == [("A", True), ("A", False)]
    assert machine.ask(GET_VALUE, 0) == b"\0\0"
    machine.ask(SET_DIRECTION, 0, OUT)
    assert seen.empty(), "the level of its last owner is no command of the next"


def test_a_machine_that_goes_drives_nothing_and_another_may_come(
    chip: VirtioGpioInputs, path: Path, seen: Queue[tuple[str, bool]]
) -> None:
    for _ in range(2):
        machine = VirtualMachine(path).boot()
        machine.drive(2, True)
        machine.off()
        assert [seen.get(timeout=PATIENCE_S), seen.get(timeout=PATIENCE_S)] == [("C", True), ("C", False)]


def test_more_requests_than_the_ring_has_places(
    machine: VirtualMachine, seen: Queue[tuple[str, bool]]
) -> None:
    machine.ask(SET_DIRECTION, 0, OUT)
    for number in range(1, 300):
        machine.ask(SET_VALUE, 0, number % 2)
        assert seen.get_nowait() == ("A", bool(number % 2))


@pytest.mark.parametrize(
    "request_", [(GET_VALUE, 3, 0), (SET_VALUE, 0, 2), (SET_DIRECTION, 0, 3), (6, 0, 1), (99, 0, 0)]
)
def test_what_the_chip_cannot_do_is_refused(machine: VirtualMachine, request_: tuple[int, int, int]) -> None:
    assert machine.ask(*request_) == b"\1\0"


def test_a_request_that_is_too_short() -> None:
    assert Pins(NAMES, lambda *_: None).answer(b"\5\0") == b"\1\0"


def test_a_queue_that_is_stopped_goes_on_where_it_was(
    machine: VirtualMachine, seen: Queue[tuple[str, bool]]
) -> None:
    machine.ask(GET_VALUE, 0)
    assert machine.say(11, struct.pack("<II", 0, 0), reply=True) == struct.pack("<II", 0, 1)


@pytest.mark.parametrize(
    "wrong",
    [
        struct.pack("<III", 5, 1, 1 << 30),  # a huge message
        struct.pack("<III", 8, 1, 2) + b"ab",  # a short one
        struct.pack("<III", 8, 1, 8) + struct.pack("<II", 7, 4),  # a queue that there is not
        struct.pack("<III", 9, 1, 40) + struct.pack("<IIQQQQ", 0, 0, 1, 2, 3, 4),  # no memory there
        struct.pack("<III", 12, 1, 8) + bytes(8),  # a doorbell without a file
        b"GET / HTTP/1.1\r\n\r\n",
    ],
)
def test_nonsense_ends_its_connection_and_nothing_else(
    chip: VirtioGpioInputs, path: Path, wrong: bytes
) -> None:
    nonsense = VirtualMachine(path)
    nonsense.socket.sendall(wrong)
    assert nonsense.is_cut_off
    nonsense.off()
    machine = VirtualMachine(path).boot()
    assert machine.ask(GET_VALUE, 0) == b"\0\0"
    machine.off()


def test_a_broken_ring_ends_its_connection(machine: VirtualMachine) -> None:
    struct.pack_into("<QIHH", machine.memory, 0, GUEST, 8, 1, 0)  # a chain that bites its tail
    struct.pack_into("<H", machine.memory, 0x402, 1)
    machine.ring()
    assert machine.is_cut_off


def test_a_place_where_no_socket_can_be_made() -> None:
    with pytest.raises(WireError, match="Give a short path"):
        VirtioGpioInputs("/proc/none/chip", NAMES).start(lambda *_: None)


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
