"""Scenarios in virtual time: what the sensors show after what the lines do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.description import Description, load
from end_effector_hal.errors import UsageError
from end_effector_lab.testbench import Bench

BOTTOM, CYLINDER, TOP, CHANGER = "SODIMM_208", "SODIMM_210", "SODIMM_212", "SODIMM_206"
S = 1_000_000

MakeBench = Callable[..., Bench]


@pytest.fixture
def make(verdin: Description) -> MakeBench:
    return lambda *args, **options: Bench(verdin, *args, **options)


def kpa(bench: Bench, channel: str, at: float) -> float:
    value = bench.sample(round(at * S))[channel]
    assert isinstance(value, int)
    return value / 1000


def extended(bench: Bench, at: float) -> bool:
    values = bench.sample(round(at * S))
    assert values["cylinder_extended"] is not values["cylinder_retracted"]
    return values["cylinder_extended"] is True


def test_at_rest(make: MakeBench) -> None:
    values = make().sample(0)
    assert {name: value for name, value in values.items() if isinstance(value, bool)} == {
        "locked": True,
        "unlocked": False,
        "tool_present": True,
        "in_stand": True,
        "estop_ok": True,
        "cylinder_extended": False,
        "cylinder_retracted": True,
    }
    pressures = {name: value for name, value in values.items() if not isinstance(value, bool)}
    nominal = {"bottom": 0, "cylinder": 0, "top": 0, "supply": 600_000}
    assert pressures == pytest.approx(nominal, abs=500)  # noise: 5 sigma


def test_each_line_moves_its_own_device_only(make: MakeBench) -> None:
    bench = make()
    bench.line(BOTTOM, True, 0)
    assert kpa(bench, "bottom", 2) < -75
    assert kpa(bench, "top", 2) == pytest.approx(0, abs=0.5)
    assert not extended(bench, 2)
    bench.line(CYLINDER, True, 2 * S)
    bench.line(TOP, True, 2 * S)
    assert extended(bench, 4)
    assert kpa(bench, "top", 4) < -75
    assert kpa(bench, "cylinder", 4) == pytest.approx(592, abs=2)
    bench.line(CHANGER, True, 4 * S)
    assert bench.sample(5 * S)["unlocked"] is True
    for line in (BOTTOM, CYLINDER, TOP, CHANGER):
        bench.line(line, False, 5 * S)
    assert bench.sample(7 * S) | {"bottom": 0, "top": 0, "cylinder": 0, "supply": 0} == make().sample(0) | {
        "bottom": 0,
        "top": 0,
        "cylinder": 0,
        "supply": 0,
    }
    assert kpa(bench, "bottom", 7) == pytest.approx(0, abs=0.5)


def test_a_level_given_twice_is_one_activation(make: MakeBench) -> None:
    bench = make("fails-once:cylinder")
    bench.line(CYLINDER, True, 0)
    bench.line(CYLINDER, True, 1 * S)
    assert not extended(bench, 3)


def test_fails_once(make: MakeBench) -> None:
    bench = make("fails-once:cylinder")
    bench.line(CYLINDER, True, 0)
    assert not extended(bench, 5)
    assert kpa(bench, "cylinder", 5) == pytest.approx(0, abs=0.5)
    bench.line(CYLINDER, False, 5 * S)
    bench.line(CYLINDER, True, 6 * S)
    assert extended(bench, 7)


@pytest.mark.parametrize("line", [BOTTOM, CYLINDER, TOP])
def test_never_confirms(make: MakeBench, verdin: Description, line: str) -> None:
    name = next(name for name, actuator in verdin.ordered if actuator.line == line)
    bench = make(f"never-confirms:{name}")
    for attempt in range(0, 18, 6):
        bench.line(line, True, attempt * S)
        values = bench.sample((attempt + 5) * S)
        assert values[verdin.actuators[name].channel] == pytest.approx(0, abs=500)
        bench.line(line, False, (attempt + 5) * S)


def test_stuck_release_stays_until_another_scenario_frees_it(make: MakeBench) -> None:
    bench = make("stuck-release:top_vacuum")
    bench.line(TOP, True, 0)
    assert kpa(bench, "top", 2) < -75
    bench.line(TOP, False, 2 * S)
    assert kpa(bench, "top", 10) < -80
    bench.line(TOP, True, 10 * S)
    bench.line(TOP, False, 11 * S)
    assert kpa(bench, "top", 13) < -80
    bench.choose("nominal", 13 * S)
    assert kpa(bench, "top", 14) == pytest.approx(0, abs=0.5)


def test_stuck_tool_changer_stays_unlocked(make: MakeBench) -> None:
    bench = make("stuck-release:tool_changer")
    bench.line(CHANGER, True, 0)
    bench.sample(1 * S)
    bench.line(CHANGER, False, 1 * S)
    assert bench.sample(5 * S)["unlocked"] is True


def test_leak_confirms_but_is_never_secure(make: MakeBench) -> None:
    bench = make("leak:bottom_vacuum")
    bench.line(BOTTOM, True, 0)
    assert -75 < kpa(bench, "bottom", 10) < -55


def test_lost_after_counts_from_the_activation(make: MakeBench) -> None:
    bench = make("lost-after:bottom_vacuum:3")
    bench.line(BOTTOM, True, 1 * S)
    assert kpa(bench, "bottom", 3.99) < -75
    assert kpa(bench, "bottom", 4.1) > -50
    assert kpa(bench, "bottom", 9) > -40  # the ejector goes on
    bench.line(BOTTOM, False, 9 * S)
    assert kpa(bench, "bottom", 10) == pytest.approx(0, abs=0.5)
    bench.line(BOTTOM, True, 10 * S)  # another part
    assert kpa(bench, "bottom", 12.9) < -75
    assert kpa(bench, "bottom", 13.1) > -50


def test_a_loss_that_is_overtaken_by_the_deactivation_does_not_come(make: MakeBench) -> None:
    bench = make("lost-after:cylinder:3")
    bench.line(CYLINDER, True, 0)
    bench.line(CYLINDER, False, 2 * S)
    bench.line(CYLINDER, True, 2_500_000)
    assert extended(bench, 5.4)
    assert not extended(bench, 7.0)


def test_a_loss_between_two_calls_is_the_same(make: MakeBench) -> None:
    seldom, often = make("lost-after:bottom_vacuum:3"), make("lost-after:bottom_vacuum:3")
    for bench in (seldom, often):
        bench.line(BOTTOM, True, 0)
    for at in range(0, 3_100_000, 777):
        often.sample(at)
    assert seldom.sample(3_100_000) == often.sample(3_100_000)


def test_what_is_stuck_is_not_lost_with_the_line_inactive(make: MakeBench) -> None:
    bench = make("stuck-release:top_vacuum,lost-after:top_vacuum:3")
    bench.line(TOP, True, 0)
    bench.sample(2 * S)
    bench.line(TOP, False, 2 * S)
    assert kpa(bench, "top", 10) < -80


def test_invalid_marks_one_pressure(make: MakeBench) -> None:
    values = make("invalid:cylinder").sample(0)
    assert [name for name, value in values.items() if value is None] == ["cylinder"]


def test_bits_and_supply(make: MakeBench) -> None:
    values = make("no-tool,not-in-stand,estop-open,supply:380").sample(0)
    assert [values[name] for name in ("tool_present", "in_stand", "estop_ok")] == [False, False, False]
    assert values["supply"] == pytest.approx(380_000, abs=500)


def test_silence_counts_from_the_choice(make: MakeBench) -> None:
    bench = make("silent-after:5", start=10 * S)
    assert not bench.silent(15 * S - 1)
    assert bench.silent(15 * S)
    bench.choose("silent-after:5", 20 * S)
    assert not bench.silent(24 * S)
    bench.choose("nominal", 24 * S)
    assert not bench.silent(99 * S)


def test_noise_changes_bytes(make: MakeBench) -> None:
    assert make().corrupt(b"$EES1", 0) == b"$EES1"
    assert make("noise:1").corrupt(b"$EES1", 0) != b"$EES1"


def test_a_new_scenario_counts_activations_anew_and_keeps_what_works(make: MakeBench) -> None:
    bench = make()
    bench.line(CYLINDER, True, 0)
    assert extended(bench, 1)
    bench.choose("fails-once:cylinder", 1 * S)
    assert extended(bench, 3)
    bench.line(CYLINDER, False, 3 * S)
    bench.line(CYLINDER, True, 5 * S)
    assert not extended(bench, 7)
    bench.choose("nominal", 7 * S)  # the line is active: what was blocked comes free
    assert extended(bench, 8)


def test_a_scenario_that_cannot_be_used_changes_nothing(make: MakeBench) -> None:
    bench = make("fails-once:cylinder")
    with pytest.raises(UsageError):
        bench.choose("fails-once:cylinda", 0)
    assert bench.scenario.text == "fails-once:cylinder"


def test_a_bench_started_anew_goes_on_holding(make: MakeBench) -> None:
    bench = make("fails-once:top_vacuum", levels={BOTTOM: True, CYLINDER: True})
    values = bench.sample(0)
    assert values["bottom"] == pytest.approx(-85_000, abs=500)
    assert values["cylinder"] == pytest.approx(600_000, abs=500)
    assert values["cylinder_extended"] is True
    assert values["top"] == pytest.approx(0, abs=500)


def test_the_seed_decides_noise_and_dead_times(make: MakeBench) -> None:
    def story(seed: int, start: int = 0) -> list[object]:
        bench = make(seed=seed, start=start)
        bench.line(BOTTOM, True, start + 1000)
        return [bench.sample(start + at) for at in range(0, S, 20_000)]

    assert story(1) == story(1) == story(1, start=123_456_000)
    assert story(1) != story(2)


def test_an_event_older_than_the_last_sample_counts_from_then_on(make: MakeBench) -> None:
    bench = make()
    bench.sample(1 * S)
    bench.line(BOTTOM, True, S - 300)
    assert kpa(bench, "bottom", 3) < -75


def test_a_line_on_which_nothing_hangs(make: MakeBench) -> None:
    with pytest.raises(UsageError, match=r"SODIMM_209.*Did you mean .SODIMM_21"):
        make().line("SODIMM_209", True, 0)


def test_any_number_of_actuators(verdin: Description) -> None:
    vacuum = verdin.actuators["bottom_vacuum"]
    actuators = {
        f"cup_{n}": vacuum.model_copy(update={"line": f"L{n}", "channel": f"c{n}"}) for n in range(32)
    }
    many = verdin.model_copy(
        update={"actuators": actuators, "sequence": tuple(actuators), "tool_changer": None}
    )
    bench = Bench(many, "never-confirms:cup_31")
    assert list(bench.lines.values()) == [f"L{n}" for n in range(32)]
    for n in range(32):
        bench.line(f"L{n}", True, 0)
    values = bench.sample(2 * S)
    assert [n for n in range(32) if values[f"c{n}"] < -75_000] == list(range(31))  # type: ignore[operator]
    assert "locked" not in values


def bits(bench: Bench, *names: str, at: float = 1.0) -> list[object]:
    values = bench.sample(round(at * S))
    return [values[name] for name in names]


@pytest.mark.parametrize("bit", [False, True])
def test_a_sensor_of_the_tool_changer_lies_until_another_scenario(make: MakeBench, bit: bool) -> None:
    bench = make(f"unlocked-shows:tool_changer:{bit:d},locked-shows:tool_changer:{bit:d}")
    assert bits(bench, "locked", "unlocked") == [bit, bit]
    bench.line(CHANGER, True, 1 * S)
    assert bits(bench, "locked", "unlocked", at=2) == [bit, bit], "wherever it is"
    bench.choose("nominal", 2 * S)
    assert bits(bench, "locked", "unlocked", at=2) == [False, True], "it has moved all the same"


def test_the_sensor_of_the_stand_lies_and_no_other(make: MakeBench) -> None:
    bench = make("stand-shows:tool_changer:0")
    assert bits(bench, "in_stand", "tool_present", "locked", "unlocked") == [False, True, True, False]
    bench.choose("not-in-stand,stand-shows:tool_changer:1", 1 * S)
    assert bits(bench, "in_stand") == [True]
    bench.choose("not-in-stand", 1 * S)
    assert bits(bench, "in_stand") == [False]


def test_the_stand_shows_on_the_bits_of_the_description(verdin: Description) -> None:
    changer = verdin.tool_changer
    assert changer
    named = changer.model_copy(update={"stand_bit": "rack", "present_bit": "tool"})
    bench = Bench(verdin.model_copy(update={"tool_changer": named}), "no-tool")
    assert bits(bench, "rack", "tool") == [True, False]


def test_channels_that_only_evidence_names_show_what_their_device_does(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(
        """
schema: 2
name: zones
link: {port: /dev/null, frame: {text: {}}}
channels:
  left: {text: {field: 1}}
  right: {text: {field: 2}}
  deep: {text: {field: 3}, unit: kPa}
  open: {text: {field: 4}}
  grips: {text: {field: 5}}
sequence: [row, jaw]
actuators:
  row:
    kind: vacuum
    line: A
    channel: none
    evidence:
      confirmed: {all: [{on: left}, {on: right}, {channel: deep, below_kpa: -50}]}
      gone: {not: {any: [{on: left}, {on: right}]}}
  jaw: {kind: gripper, line: B, evidence: {confirmed: {on: grips}, gone: {on: open}}}
supply: {channel: none}
"""
    )
    bench = Bench(load(path))
    rest = bench.sample(0)
    assert [rest[name] for name in ("left", "right", "open", "grips")] == [False, False, True, False]
    assert rest["deep"] == pytest.approx(0, abs=500)
    bench.line("A", True, 0)
    bench.line("B", True, 0)
    shown = bench.sample(2 * S)
    assert [shown[name] for name in ("left", "right", "open", "grips")] == [True, True, False, True]
    assert kpa(bench, "deep", 2) < -50
