"""The values that detectors read are those that have not turned stale, whatever was left out, late or refused."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from end_effector_hal.codecs import carrier_of, load_tool, sources_of
from end_effector_hal.description import load, profile_path
from end_effector_hal.sensing import SensorState
from end_effector_hal.sensing._readings import Readings
from end_effector_hal.signals import Frame, Kind, PassingReadings, clone


def _fresh(state: SensorState, at: int) -> dict[str, int | bool]:
    values = {name: state.readings.get(name, at) for name in state.readings.carried}
    return {name: value for name, value in values.items() if value is not None}


@pytest.mark.parametrize("tool", ["verdin_gripper", "two_links", "remote_io"])
def test_the_fresh_values_are_the_ones_that_were_read_recently(tool: str) -> None:
    path = Path("examples/tools", tool, "end_effector.yaml")
    description = load(profile_path() if tool == "verdin_gripper" else path)
    carrier, random, at = carrier_of(description), Random(3), 1_000_000
    sources, state = sources_of(carrier), SensorState(description, carrier)
    for _ in range(600):
        at += random.choice((20_000, 20_000, 100_000, 700_000))
        values = {
            name: random.random() < 0.5
            if carrier.channels[name] is Kind.BIT
            else random.randrange(-90_000, 0)
            for name in random.choice(sources).channels
        }
        sent = {name: None if random.random() < 0.2 else value for name, value in values.items()}
        frame = Frame(at, None, None, sent)
        passing = PassingReadings(state.readings, frame)
        other = clone(state)
        if (due := state.deadline(at - 700_000)) is not None and due < at:
            state.wait(due)
            assert state.readings.fresh == _fresh(state, due)
        list(state.take(frame))
        now = max(at, state.readings.last_frame)
        assert state.readings.fresh == _fresh(state, now)
        doubted = {name for name, value in sent.items() if value is not None} - state.readings.arrived
        if not doubted:
            assert passing.fresh == state.readings.fresh
            assert passing.arrived == state.readings.arrived
        before = dict(other.readings.fresh)
        list(state.take(Frame(now + 1, None, None, values)))
        assert other.readings.fresh == before, "a copy is independent"


def test_the_faults_of_a_device_are_judged_once_for_all_who_ask(monkeypatch: pytest.MonkeyPatch) -> None:
    description = load_tool(Path("examples/tools/epick_commanded/end_effector.yaml"))
    state, at, asked = SensorState(description, carrier_of(description)), 1_000_000, list[str]()
    faults, code = state.faults, dict.fromkeys(state.faults.channels, 0)
    assert code
    list(state.take(Frame(at, None, None, code)))

    def get(_: Readings, channel: str, at: int) -> int:
        asked.append(channel)
        return 0

    monkeypatch.setattr(Readings, "get", get)
    for latching in (False, True):
        assert all(faults.well(state.readings, at, latching=latching).values())
    assert not faults.standing(state.readings, at)
    assert not faults.unproven(state.readings, at)
    assert not asked
    assert not faults.unknown(state.readings, at + 1)
    assert asked == list(code), "another time"
