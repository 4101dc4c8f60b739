from __future__ import annotations

import pytest

from end_effector_lab.testbench.physics import Cylinder, Supply, Valve


def at(cylinder: Cylinder, seconds: float) -> Cylinder:
    cylinder.advance(round(seconds * 1e6))
    return cylinder


def test_extends_on_a_plateau_then_rises_to_supply() -> None:
    cylinder = Cylinder(Valve(30_000))
    cylinder.command(True, 0)
    assert at(cylinder, 0.03).pressure_kpa == 0.0
    assert cylinder.bits == {"extended": False, "retracted": True}
    assert at(cylinder, 0.25).pressure_kpa == pytest.approx(270, abs=2)
    assert cylinder.bits == {"extended": False, "retracted": False}
    assert 0 < cylinder.position < 1
    assert at(cylinder, 0.45).pressure_kpa == pytest.approx(270, abs=2)
    assert at(cylinder, 1.0).pressure_kpa == pytest.approx(600, abs=1)
    assert cylinder.bits == {"extended": True, "retracted": False}


def test_retracts_by_its_spring_and_exhausts() -> None:
    cylinder = Cylinder(Valve(30_000))
    cylinder.settle(True)
    cylinder.command(False, 0)
    assert at(cylinder, 0.03).pressure_kpa == pytest.approx(600)
    assert at(cylinder, 0.4).pressure_kpa == pytest.approx(90, abs=2)
    assert cylinder.bits == {"extended": False, "retracted": False}
    assert at(cylinder, 1.0).pressure_kpa == pytest.approx(0, abs=1)
    assert cylinder.bits == {"extended": False, "retracted": True}


def test_the_stroke_takes_its_time() -> None:
    cylinder = Cylinder(Valve(0), extend_s=0.8)
    cylinder.command(True, 0)
    while not cylinder.bits["extended"]:
        cylinder.advance(cylinder.now + 1000)
    assert cylinder.now / 1e6 == pytest.approx(0.8, abs=0.09)  # filling comes first


def test_turning_back_half_way() -> None:
    cylinder = Cylinder(Valve(30_000))
    cylinder.command(True, 0)
    half = at(cylinder, 0.3).position
    cylinder.command(False, 300_000)
    assert at(cylinder, 1.2).position == 0.0 < half
    assert cylinder.pressure_kpa == pytest.approx(0, abs=1)


def test_too_little_air_moves_nothing() -> None:
    cylinder = Cylinder(Valve(30_000), Supply(200.0))
    cylinder.command(True, 0)
    assert at(cylinder, 5.0).position == 0.0
    assert cylinder.pressure_kpa == pytest.approx(200, abs=1)


def test_it_has_no_leak() -> None:
    with pytest.raises(ValueError, match="Cylinder has no leak"):
        Cylinder().leak(4.0)
