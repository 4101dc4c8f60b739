from __future__ import annotations

from statistics import mean, stdev

import pytest

from end_effector_lab.testbench._noise import Noise


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
