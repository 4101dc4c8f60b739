from __future__ import annotations

import pytest

from end_effector_lab.testbench.physics import Plant, Supply, VacuumCircuit, Valve


def test_follows_its_regulator() -> None:
    supply = Supply(600.0)
    supply.advance(1_000_000)
    assert supply.kpa == 600.0
    supply.regulated_kpa = 380.0
    supply.advance(2_000_000)
    assert supply.kpa == pytest.approx(380.0, abs=0.01)


def test_gives_way_while_an_ejector_draws() -> None:
    plant = Plant(Supply(600.0), {"cup": VacuumCircuit(Valve(30_000))})
    plant.devices["cup"].command(True, 0)
    plant.advance(1_000_000)
    assert plant.supply.kpa == pytest.approx(596.0, abs=0.01)
    plant.devices["cup"].command(False, 1_000_000)
    plant.advance(3_000_000)
    assert plant.supply.kpa == pytest.approx(600.0, abs=0.01)
