"""The devices of a simulated tool, one by one."""

from __future__ import annotations

import pytest

from end_effector_lab.testbench.physics import (
    STEP_US,
    Cylinder,
    Fingers,
    HoldingMagnet,
    Plant,
    Supply,
    ToolChanger,
    VacuumCircuit,
    Valve,
)


def passes(circuit: VacuumCircuit, kpa: float, within_s: float = 20.0) -> float | None:
    """Seconds until its sensor shows this vacuum."""
    start = circuit.now
    while circuit.now - start < within_s * 1e6:
        if -circuit.pressure_kpa >= kpa:
            return (circuit.now - start) / 1e6
        circuit.advance(circuit.now + STEP_US)
    return None


def switched_on(leak_l_min: float = 0.0) -> VacuumCircuit:
    circuit = VacuumCircuit()
    circuit.leak(leak_l_min)
    circuit.command(True, 0)
    return circuit


def test_its_switches_are_those_of_a_part_and_of_no_vacuum() -> None:
    circuit, seen = switched_on(), list[dict[str, bool]]()

    def watch(seconds: float) -> None:
        for at in range(circuit.now, circuit.now + round(seconds * 1e6), STEP_US):
            circuit.advance(at)
            if dict(circuit.bits) not in seen[-1:]:
                seen.append(dict(circuit.bits))

    watch(2.0)
    circuit.command(False, circuit.now)
    watch(2.0)
    places = [(each["part"], each["gone"]) for each in seen]
    assert places == [(False, True), (False, False), (True, False), (False, False), (False, True)]


@pytest.mark.parametrize(
    ("leak_l_min", "kpa", "seconds"),
    [(0, 55, 0.33), (0, 75, 0.95), (4, 55, 0.38), (4, 75, None), (20, 55, None)],
)
def test_measured_times(leak_l_min: float, kpa: float, seconds: float | None) -> None:
    passed = passes(switched_on(leak_l_min), kpa)
    assert passed == (None if seconds is None else pytest.approx(seconds, abs=0.006))


def test_ultimate_vacuum_is_never_passed() -> None:
    circuit = switched_on()
    circuit.advance(60_000_000)
    assert circuit.depth_kpa == pytest.approx(85.0, abs=1e-3)
    assert passes(circuit, 85.001) is None


@pytest.mark.parametrize(("leak_l_min", "low_s", "high_s"), [(800, 0.003, 0.012), (40, 0.06, 0.13)])
def test_a_lost_seal_crosses_54_kpa(leak_l_min: float, low_s: float, high_s: float) -> None:
    circuit = VacuumCircuit()
    circuit.settle(True)
    circuit.leak(leak_l_min)
    while circuit.depth_kpa > 54:
        circuit.advance(circuit.now + STEP_US)
    assert low_s <= circuit.now / 1e6 <= high_s


def test_off_is_gone_within_half_a_second_but_not_before_the_valve_closed() -> None:
    circuit = VacuumCircuit(Valve(30_000))
    circuit.settle(True)
    circuit.command(False, 0)
    circuit.advance(30_000)
    assert circuit.depth_kpa == pytest.approx(85.0)
    circuit.advance(500_000)
    assert 0.0 <= circuit.depth_kpa < 1.0


def test_a_pulse_shorter_than_the_dead_time_does_nothing() -> None:
    circuit = VacuumCircuit(Valve(30_000))
    circuit.command(True, 0)
    circuit.advance(20_000)
    circuit.command(False, 20_000)
    circuit.advance(1_000_000)
    assert circuit.depth_kpa == 0.0


@pytest.mark.parametrize("pace_us", [1_000, 7_300, 20_000, 999_999])
def test_the_result_does_not_depend_on_the_calls(pace_us: int) -> None:
    often, seldom = switched_on(4), switched_on(4)
    for at in range(0, 700_000, pace_us):
        often.advance(at)
    often.advance(700_000)
    seldom.advance(700_000)
    assert often.pressure_kpa == seldom.pressure_kpa


def test_what_has_settled_is_what_time_leads_to() -> None:
    waited, settled = switched_on(4), VacuumCircuit()
    waited.advance(60_000_000)
    settled.leak(4)
    settled.settle(True)
    assert waited.pressure_kpa == pytest.approx(settled.pressure_kpa, abs=1e-3)


def test_settled_leaves_out_steps_and_no_change() -> None:
    circuit = switched_on()
    circuit.advance(60_000_000)
    assert circuit.settled
    circuit.advance(10**12)  # 11 days in no time
    circuit.command(False, 10**12)
    assert not circuit.settled
    circuit.advance(10**12 + 500_000)
    assert circuit.depth_kpa < 1.0


def test_suction_opens_no_later_than_its_step() -> None:
    circuit = VacuumCircuit(Valve(22_000))
    circuit.command(True, 0)
    circuit.advance(22_000)
    assert circuit.depth_kpa == 0.0
    circuit.advance(23_000)
    assert circuit.depth_kpa > 0.0


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


def test_follows_its_regulator() -> None:
    supply = Supply(600.0)
    supply.advance(1_000_000)
    assert supply.kpa == 600.0
    supply.regulate(380.0)
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


def test_inactive_is_locked_active_is_unlocked_and_between_is_neither() -> None:
    changer = ToolChanger(Valve(30_000))
    changer.advance(1_000_000)
    assert changer.bits == {"locked": True, "unlocked": False}
    changer.command(True, 1_000_000)
    changer.advance(1_100_000)
    assert changer.bits == {"locked": False, "unlocked": False}
    changer.advance(1_200_000)
    assert changer.bits == {"locked": False, "unlocked": True}
    changer.command(False, 2_000_000)
    changer.advance(2_100_000)
    assert changer.bits == {"locked": False, "unlocked": False}
    changer.advance(2_200_000)
    assert changer.bits == {"locked": True, "unlocked": False}
    assert changer.pressure_kpa is None


OPEN, CLOSED, PART, BETWEEN = {"open"}, {"closed"}, {"part"}, set[str]()


def shown(device: Fingers | HoldingMagnet) -> set[str]:
    return {name for name, on in device.bits.items() if on}


def story(fingers: Fingers, seconds: float) -> list[set[str]]:
    """What the switches show, one after the other."""
    seen = [shown(fingers)]
    for at in range(fingers.now, fingers.now + round(seconds * 1e6), STEP_US):
        fingers.advance(at)
        if shown(fingers) != seen[-1]:
            seen.append(shown(fingers))
    return seen


def test_on_their_way_no_switch_is_made() -> None:
    fingers = Fingers()
    fingers.command(True, 0)
    assert story(fingers, 1.0) == [OPEN, BETWEEN, PART]
    fingers.command(False, fingers.now)
    assert story(fingers, 1.0) == [PART, BETWEEN, OPEN]


def test_without_a_part_they_close_as_far_as_they_go() -> None:
    fingers = Fingers()
    fingers.meet(False)
    fingers.command(True, 0)
    assert story(fingers, 1.0) == [OPEN, BETWEEN, CLOSED]


def test_a_part_that_is_pulled_out_is_back_for_the_next_grip() -> None:
    fingers = Fingers()
    fingers.settle(True)
    assert shown(fingers) == PART
    fingers.lose(0)
    assert story(fingers, 1.0) == [BETWEEN, CLOSED]
    for active in (False, True):
        fingers.command(active, fingers.now)
        fingers.advance(fingers.now + 1_000_000)
    assert shown(fingers) == PART


@pytest.mark.parametrize(("after_ms", "holds"), [(100, True), (200, False)])
def test_a_magnet_that_is_switched_off_holds_for_a_while(after_ms: int, holds: bool) -> None:
    magnet = HoldingMagnet()
    magnet.settle(True)
    magnet.command(False, 0)
    magnet.advance(after_ms * 1000)
    assert shown(magnet) == ({"part"} if holds else {"gone"})


def test_a_magnet_holds_nothing_where_there_is_nothing_or_it_is_torn_off() -> None:
    magnet = HoldingMagnet()
    magnet.meet(False)
    magnet.command(True, 0)
    magnet.advance(1_000_000)
    assert shown(magnet) == {"gone"}
    magnet.meet(True)
    magnet.advance(1_100_000)
    assert shown(magnet) == {"part"}
    magnet.lose(1_100_000)
    magnet.advance(2_000_000)
    assert shown(magnet) == {"gone"}
