"""The physics is solved from one switching to the next: it shows what the stepping model shows, within a step."""

from __future__ import annotations

from itertools import pairwise
from random import Random
from typing import Any

import pytest

from end_effector_lab.testbench import physics
from tests.support.nightly import NIGHTLY, first_of
from tests.unit.testbench.stepping import cylinder, device, parts, vacuum

STEP_US = 1000
SEEDS = range(200) if NIGHTLY else first_of(range(8), 3, 0)
NOISE_KPA = 0.3
"""Three times the noise of a sensor: an edge that lies within it may be some steps earlier or later."""
FILLING_KPA = 4.0
"""A cylinder fills by 13 kPa in a step."""


def stepping(valves: list[int]) -> Any:
    supply = parts.Supply(600.0)
    bottom, middle, top = map(physics.Valve, valves)
    devices = {
        "bottom": vacuum.VacuumCircuit(bottom),
        "cylinder": cylinder.Cylinder(middle, supply),
        "top": vacuum.VacuumCircuit(top),
    }
    return device.Plant(supply, devices)


def solved(valves: list[int]) -> Any:
    supply = physics.Supply(600.0)
    bottom, middle, top = map(physics.Valve, valves)
    devices = {
        "bottom": physics.VacuumCircuit(bottom),
        "cylinder": physics.Cylinder(middle, supply),
        "top": physics.VacuumCircuit(top),
    }
    return physics.Plant(supply, devices)


def shown(plant: Any) -> tuple[list[float], list[bool]]:
    kpa = [plant.supply.kpa, *(each.pressure_kpa for each in plant.devices.values())]
    return kpa, [bit for each in plant.devices.values() for bit in each.bits.values()]


def disturb(plant: Any, name: str, what: str, much: float, at: int) -> None:
    """One thing that lines and scenarios do."""
    one = plant.devices[name]
    match what:
        case "on" | "off":
            one.command(what == "on", at)
        case "lose":
            one.lose(at)
        case "supply":
            plant.supply.regulate(150 + much * 450)
        case "leak" if name != "cylinder":
            one.leak(much * 20)
        case "grow" if name != "cylinder":
            one.leak(0.0, much * 5)
        case "blow" if name != "cylinder":
            one.blow(much < 0.5, at)
        case "stick" if name != "cylinder":
            one.stick(much < 0.5)


DISTURBANCES = ("on", "on", "on", "off", "off", "lose", "leak", "grow", "supply", "blow", "stick")


def moments(random: Random) -> list[tuple[int, str, str, float]]:
    at, found = 0, []
    for _ in range(12):
        name, what = random.choice(("bottom", "cylinder", "top")), random.choice(DISTURBANCES)
        found.append((at, name, what, random.random()))
        at += random.choice((50_000, 400_000, 900_000, 2_000_000))
    return [*found, (at, "top", "off", 0.0)]


@pytest.mark.parametrize("seed", SEEDS)
def test_it_shows_what_the_stepping_model_shows(seed: int) -> None:
    random = Random(seed)
    valves = [random.randint(15_000, 60_000) for _ in range(3)]
    reference, plant = stepping(valves), solved(valves)
    told, seen = [], []
    for (at, *which), (until, *_) in pairwise(moments(random)):
        disturb(reference, *which, at)
        disturb(plant, *which, at)
        for now in range(at + STEP_US, until + 1, STEP_US):
            reference.advance(now)
            plant.advance(now)
            told.append(shown(reference))
            seen.append(shown(plant))
    for i, (kpa, bits) in enumerate(seen):
        around = told[max(0, i - 1) : i + 2]
        for k, value in enumerate(kpa):
            off = FILLING_KPA if k == 2 else NOISE_KPA
            low, high = (f(each[0][k] for each in around) for f in (min, max))
            assert low - off <= value <= high + off, (i, k)
        for k, bit in enumerate(bits):
            assert any(each[1][k] == bit for each in around), (i, k)


@pytest.mark.parametrize("pace_us", [1_000, 7_300, 20_000, 333_333])
def test_the_course_does_not_depend_on_the_calls(pace_us: int) -> None:
    often, seldom = solved([20_000, 30_000, 40_000]), solved([20_000, 30_000, 40_000])
    for (at, *which), (until, *_) in pairwise(moments(Random(5))):
        for plant in (often, seldom):
            plant.advance(at)
            disturb(plant, *which, at)
        for now in range(at, until, pace_us):
            often.advance(now)
        often.advance(until)
        seldom.advance(until)
        assert shown(often) == shown(seldom)
