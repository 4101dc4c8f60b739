"""What happens to frames on the wire, and the files of edges and true values."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random
from statistics import mean, stdev

import pytest

from end_effector_hal.errors import UsageError
from end_effector_lab.testbench import Scenario
from end_effector_lab.testbench._noise import LONGEST_BURST, Noise, disturbed
from end_effector_lab.testbench._program import Events

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


def test_depends_on_seed_purpose_and_time_only() -> None:
    noise = Noise(7)
    first = noise.normal("bottom", 20_000)
    noise.normal("top", 20_000)
    assert noise.normal("bottom", 20_000) == first == Noise(7).normal("bottom", 20_000)
    assert (
        len(
            {
                first,
                noise.normal("top", 20_000),
                noise.normal("bottom", 40_000),
                Noise(8).normal("bottom", 20_000),
            }
        )
        == 4
    )


def test_is_standard_normal() -> None:
    numbers = [Noise(1).normal("x", at) for at in range(2000)]
    assert mean(numbers) == pytest.approx(0, abs=0.1)
    assert stdev(numbers) == pytest.approx(1, abs=0.1)


def test_events(tmp_path: Path) -> None:
    events = Events(tmp_path / "events")
    events.line("SODIMM_208", True, 100, 130)
    events.frame(200, 7, {"bottom": -5, "locked": True, "top": None}, sent=False)
    lines = (tmp_path / "events").read_text().splitlines()  # before it is closed: it is there at once
    assert [json.loads(line) for line in lines] == [
        {"at": 100, "seen": 130, "line": "SODIMM_208", "level": 1},
        {"at": 200, "frame": 7, "sent": False, "values": {"bottom": -5, "locked": True, "top": None}},
    ]
    events.close()


def test_a_file_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="Give another path"):
        Events(tmp_path)
    full = Events("/dev/full")
    with pytest.raises(UsageError, match="No space left"):
        full.line("A", True, 0, 0)
    full.close()
