from __future__ import annotations

from random import Random

import pytest

from end_effector_lab.testbench import Scenario
from end_effector_lab.testbench._noise import LONGEST_BURST, disturbed

DATA = bytes(10_000)


def through(**faults: float) -> bytes:
    return disturbed(DATA, Scenario(**faults), Random(1))  # type: ignore[arg-type]


def test_a_good_cable_changes_nothing() -> None:
    assert through() == DATA


@pytest.mark.parametrize("rate", [0.1, 1.0])
def test_noise_changes_its_share_of_the_bytes(rate: float) -> None:
    assert sum(byte != 0 for byte in through(noise=rate)) == pytest.approx(10_000 * rate, rel=0.1)


def test_flips_turn_their_share_of_the_bits() -> None:
    assert sum(byte.bit_count() for byte in through(flips=0.01)) == pytest.approx(800, rel=0.1)


def test_bytes_are_lost_and_doubled() -> None:
    assert len(through(dropped=0.2)) == pytest.approx(8_000, rel=0.05)
    assert len(through(doubled=0.2)) == pytest.approx(12_000, rel=0.05)


def test_a_burst_changes_bytes_in_a_row() -> None:
    for seed in range(100):
        data = disturbed(bytes(60), Scenario(bursts=1.0), Random(seed))
        changed = [at for at, byte in enumerate(data) if byte]
        assert len(data) == 60
        assert not changed or changed[-1] - changed[0] < LONGEST_BURST
    assert disturbed(b"", Scenario(bursts=1.0), Random(1)) == b""


def test_babble_keeps_nothing() -> None:
    data = disturbed(DATA, Scenario(), Random(1), babble=True)
    assert len(data) == len(DATA)
    assert data.count(0) < 100
