"""In the guest, on the kernel's simulated chip: the gpiod back-end, and the testbench's sides on this machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from queue import Queue
from types import SimpleNamespace

import gpiod
import pytest

from end_effector_hal.errors import LineNotFoundError, WireError
from end_effector_hal.wires.lines import GpiodLines
from end_effector_lab.testbench.inputs import GpioInputs, GpioSimInputs
from tests.acceptance.gpiochip.inside.owned import Arbiter
from tests.acceptance.gpiochip.inside.simulated import CONFIG, SimulatedChip, remove
from tests.support.line_backend_tests import LineBackendConformance
from tests.support.line_inputs_tests import A, B, LineInputsConformance, Wires

NAMES = LineBackendConformance.names


@pytest.fixture
def chip() -> Iterator[SimulatedChip]:
    with SimulatedChip(["", *NAMES, "other"]) as chip:
        yield chip


class TestBackend(LineBackendConformance):
    keeps_level = False  # a line that is given back falls to its pull

    @pytest.fixture
    def make(self) -> Iterator[Callable[[], GpiodLines]]:
        with SimulatedChip(["", *self.names, "other"]):
            yield GpiodLines

    def test_a_pulled_up_input_is_no_command(self, chip: SimulatedChip) -> None:
        chip.pull(B, True)
        assert chip.level(B) is True
        lines = GpiodLines()
        assert lines.request([A, B]) == {A: False, B: False}
        assert chip.level(B) is False
        lines.close()


class TestSimulatedSide(LineInputsConformance):
    at_is_now = False  # it looks once a millisecond

    @pytest.fixture
    def wires(self) -> Iterator[Wires]:
        lines, claimed = GpiodLines(), list[str]()

        def drive(line: str, level: bool) -> None:
            if not claimed:
                claimed.extend(lines.request([A, B]))
            lines.set({line: level})

        with SimulatedChip([A, "", B]):
            inputs = GpioSimInputs([A, B])
            yield SimpleNamespace(inputs=inputs, drive=drive)
            inputs.close()
            lines.close()


class TestInputsOfARaspberryPi(LineInputsConformance):
    """Edges of the kernel: the pull of a simulated input is the wire that comes from the board."""

    @pytest.fixture
    def wires(self) -> Iterator[Wires]:
        with SimulatedChip([A, "", B]) as chip:
            inputs = GpioInputs({A: A, B: B}, "gpiod")
            yield SimpleNamespace(inputs=inputs, drive=chip.pull)
            inputs.close()


def test_the_testbench_makes_the_chip_that_is_missing() -> None:
    inputs = GpioSimInputs([A, B])
    assert inputs.start(lambda *_: None) == {A: False, B: False}
    lines = GpiodLines()
    assert lines.request([B, A]) == {A: False, B: False}
    lines.close()
    inputs.close()
    again = GpioSimInputs([A, B])
    assert again.start(lambda *_: None) == {A: False, B: False}
    again.close()
    remove(CONFIG / "end-effector-testbench")


def test_a_name_on_two_chips(chip: SimulatedChip) -> None:
    with (
        SimulatedChip([A], "second"),
        pytest.raises(LineNotFoundError, match=rf"{A} is ambiguous: /dev/gpio"),
    ):
        GpiodLines().request([A])


def test_lines_without_names_by_the_name_the_path_and_the_label_of_their_chip() -> None:
    with SimulatedChip(["", "", "", A], label="expander") as chip:
        name = chip.device.name
        lines = GpiodLines()
        lines.request([f"{name}:0", "expander:2"])
        lines.set({f"{name}:0": True, "expander:2": True})
        with gpiod.Chip(str(chip.device)) as device:
            assert [device.get_line_info(offset).used for offset in range(4)] == [True, False, True, False]
        lines.close()
        with pytest.raises(LineNotFoundError, match=rf"no offset 4; there is {name} \[expander\], 4 lines"):
            lines.request([f"{name}:4"])
        with pytest.raises(WireError, match=rf"{A} and expander:3 are one line: {chip.device} line 3"):
            lines.request([A, "expander:3"])


def test_the_testbench_makes_a_chip_of_the_label_that_is_missing() -> None:
    inputs, seen = GpioSimInputs(["expander:1"]), Queue[tuple[str, bool]]()
    assert inputs.start(lambda line, level, _at: seen.put((line, level))) == {"expander:1": False}
    lines = GpiodLines()
    lines.request(["expander:1"])
    lines.set({"expander:1": True})
    assert seen.get(timeout=20) == ("expander:1", True)
    lines.close()
    inputs.close()
    remove(CONFIG / "end-effector-testbench")


def test_lines_on_two_chips() -> None:
    with SimulatedChip([A], "first") as first, SimulatedChip([B], "second") as second:
        lines = GpiodLines()
        lines.request([A, B])
        lines.set({A: True, B: True})
        assert (first.level(A), second.level(B)) == (True, True)
        lines.close()


def test_a_chip_that_goes_while_its_lines_are_held(chip: SimulatedChip) -> None:
    lines = GpiodLines()
    lines.request([A, B])
    chip.unplug()
    with pytest.raises(WireError, match="the lines do not work any more: No such device"):
        lines.set({A: True})
    with pytest.raises(WireError, match="No such device"):
        lines.levels()
    lines.close()


def test_all_lines_change_at_once(chip: SimulatedChip) -> None:
    """One write of the back-end is one request to the kernel: nobody sees a state in between for long."""
    lines = GpiodLines()
    lines.request(NAMES)
    for level in (True, False) * 20:
        lines.set(dict.fromkeys(NAMES, level))
        assert {chip.level(name) for name in NAMES} == {level}
    lines.close()


def test_lines_are_handed_on_by_their_descriptor(chip: SimulatedChip) -> None:
    """As the service manager keeps it between two arbiters: this chip lets a level fall that is given back."""
    first = GpiodLines()
    first.request([A, B])
    first.set({A: True})
    kept = {name: os.dup(fd) for name, fd in first.descriptors().items()}
    first.close()
    assert chip.level(A) is True
    second = GpiodLines()
    second.restore(kept)
    assert second.request([A, B]) == {A: True, B: False}
    second.set({A: False, B: True})
    assert second.levels() == {A: False, B: True}
    assert (chip.level(A), chip.level(B)) == (False, True)
    second.close()
    assert chip.level(B) is False


def test_a_killed_arbiter_leaves_its_lines_at_their_pull(chip: SimulatedChip) -> None:
    with Arbiter([A, B]) as arbiter:
        arbiter.set({A: True, B: True})
        assert (chip.level(A), chip.level(B)) == (True, True)
        arbiter.kill()
        assert (chip.level(A), chip.level(B)) == (False, False)
    with Arbiter([A, B]) as arbiter:
        assert arbiter.levels() == {A: False, B: False}


def test_a_killed_arbiter_lets_a_pulled_up_line_rise(chip: SimulatedChip) -> None:
    """And the next one adopts it as an active output: to this kernel it still is one."""
    chip.pull(B, True)
    with Arbiter([A, B]) as arbiter:
        assert arbiter.levels() == {A: False, B: False}
        arbiter.kill()
        assert (chip.level(A), chip.level(B)) == (False, True)
    with Arbiter([A, B]) as arbiter:
        assert arbiter.levels() == {A: False, B: True}


def test_the_kernel_says_what_a_line_is(chip: SimulatedChip) -> None:
    lines = GpiodLines()
    lines.request([A])
    with gpiod.Chip(str(chip.device)) as device:
        info = device.get_line_info(A)
    assert (info.used, info.consumer, info.direction) == (
        True,
        "end-effector-hal",
        gpiod.line.Direction.OUTPUT,
    )
    lines.close()
