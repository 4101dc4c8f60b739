"""What recorded grips say of thresholds and time-outs: held against the tool really driven with other values."""

from __future__ import annotations

import json
import shutil
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.page.recorded import RecordingFiles
from end_effector_hal.recording import Recording
from end_effector_lab.recorded import GripCollector, Tuning, tune
from end_effector_lab.recorded import _attempts as attempts_module
from end_effector_lab.recorded._attempts import course_of
from end_effector_lab.recorded._parameters import TunableKey, not_tried, parameters_of
from tests.support.recorded_tool import RecordedTool, recorded
from tests.support.virtual_tool import VirtualTool
from tests.unit.verification.replay.test_command import run as replayed

TOOL = load(profile_path())


@pytest.fixture(scope="module")
def nominal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("nominal") / "run", "nominal", 1.0, "grip", 4.0, "drop", 3.0)


def collected(*folders: Path) -> GripCollector:
    collector = GripCollector(TOOL)
    for number, folder in enumerate(folders):
        collector.collect(RecordingFiles(folder).entries(), number)
    return collector


def tuned(*folders: Path) -> Tuning:
    return tune(collected(*folders).grips, TOOL)


def of(tuning: Tuning, key: str) -> Any:
    (found,) = [each for each in tuning.tried if each.parameter.key == f"actuators.{key}"]
    return found


def changed(name: str, key: str, value: float) -> Description:
    parameter = next(each for each in parameters_of(TOOL) if (each.actuator, each.path) == (name, (key,)))
    actuator = parameter.with_value(TOOL.actuators[name], TOOL.supply, value)
    assert actuator is not None
    return TOOL.model_copy(update={"actuators": {**TOOL.actuators, name: actuator}})


def waits(description: Description, actuator: int) -> list[float]:
    """How long an actuator is pending, when the tool is really driven so; s."""
    tool = VirtualTool(description)
    tool.run(1.0)
    assert tool.command("grip").accepted
    tool.run(4.0)
    seen = [(status.at, status.actuators[actuator]) for status in tool.statuses]
    edges = [(at, new) for (_, old), (at, new) in pairwise(seen) if new != old]
    return [(after - at) / 1e6 for (at, new), (after, _) in pairwise(edges) if new == 1]


@pytest.mark.parametrize(
    ("name", "key", "value"),
    [
        ("bottom_vacuum", "confirmed_kpa", 70.0),
        ("bottom_vacuum", "confirmed_samples", 12),
        ("cylinder", "extended_s", 0.4),
    ],
)
def test_a_course_is_what_the_tool_does_when_it_is_driven_so(
    nominal: Path, name: str, key: str, value: float
) -> None:
    """Of the first actuator to the frame; of a later one, whose noise is then another, within two frames."""
    (grip,) = collected(nominal).grips
    other = changed(name, key, value)
    course = course_of(other.actuators[name], TOOL.supply, grip.activations[name][0])
    assert course.confirmed is not None
    (really,) = waits(other, TOOL.sequence.index(name))
    assert course.confirmed / 1e6 == pytest.approx(really, abs=0.0001 if name == TOOL.sequence[0] else 0.04)


def test_a_time_out_fails_grips_from_the_confirmation_on(nominal: Path) -> None:
    (really,) = waits(TOOL, 0)
    found = of(tuned(nominal), "bottom_vacuum.timeout_s")
    assert found.same_from == pytest.approx(really, abs=0.01)
    assert found.same_from >= really
    assert (found.ends_below, found.ends_above) == (True, False)
    for value, counts in found.values:
        assert counts.failed == (value < really), value
    # and so it goes when it is driven so: the first attempt fails just below it, and not just above
    tries = [len(waits(changed("bottom_vacuum", "timeout_s", really + by), 0)) for by in (-0.02, 0.02)]
    assert tries[0] > 1
    assert tries[1] == 1


def test_a_threshold_is_late_before_it_fails(nominal: Path) -> None:
    found = of(tuned(nominal), "bottom_vacuum.confirmed_kpa")
    assert found.ends_above
    assert not found.ends_below
    assert found.today == (0, 0, 0, 0, 0)
    beyond = [counts for value, counts in found.values if value > found.same_to]
    assert beyond
    assert all(counts.late or counts.failed for counts in beyond)


@pytest.mark.thinned
def test_a_leak_is_confirmed_and_lost_within_the_hold(tmp_path: Path) -> None:
    folder = recorded(tmp_path / "run", "leak-grows:bottom_vacuum:2", 1.0, "grip", 13.0, "drop", 3.0)
    found = of(tuned(folder), "bottom_vacuum.lost_kpa")
    assert found.today.lost == 1
    kept = [value for value, counts in found.values if not counts.lost]
    assert kept
    assert max(kept) < found.same_from
    assert found.ends_below


def test_a_cancelled_attempt_decides_nothing(tmp_path: Path) -> None:
    folder = recorded(tmp_path / "run", "never-confirms:bottom_vacuum", 1.0, "grip", 2.0, "cancel", 3.0)
    found = of(tuned(folder), "bottom_vacuum.timeout_s")
    assert (found.today.failed, found.today.undecided) == (0, 1)
    short = [counts for value, counts in found.values if value < 1.8]
    assert {(counts.failed, counts.undecided) for counts in short} == {(1, 0)}


@pytest.fixture
def gripped_twice(tmp_path: Path) -> Path:
    """Two grips, each held and dropped; in the first the cylinder fails once."""
    tool = RecordedTool(tmp_path / "run", "fails-once:cylinder")
    tool.run(1.0)
    for seconds in (8.0, 2.0):
        assert tool.command("grip").accepted
        tool.run(seconds)
        assert tool.command("drop").accepted
        tool.run(2.0)
    tool.close()
    return tool.folder


@pytest.mark.thinned
def test_attempts_that_were_needed(gripped_twice: Path) -> None:
    found = of(tuned(gripped_twice), "cylinder.attempts")
    assert found.today.late == 1
    assert dict(found.values)[1.0].failed == 1
    assert (found.same_from, found.same_to) == (2.0, 3.0)


def test_a_release_is_stuck_when_its_wait_is_shorter(nominal: Path) -> None:
    found = of(tuned(nominal), "cylinder.release_s")
    assert all(counts.stuck == (value < found.same_from) for value, counts in found.values)
    assert 0.2 < found.same_from < 2.0


def test_what_the_readings_do_not_show_is_set_aside(nominal: Path) -> None:
    """As of a bag that lacks a channel, or of a description that is not the one that ran."""
    other = changed("bottom_vacuum", "confirmed_kpa", 74.0)
    found = tune(collected(nominal).grips, TOOL, [other])
    assert found.set_aside == {"bottom_vacuum": 1}
    assert not [each for each in found.tried if each.parameter.actuator == "bottom_vacuum"]


def test_memory_is_bounded(nominal: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(attempts_module, "MOST_READINGS", 50)
    collector = collected(nominal)
    assert collector.full
    activations = [one for grip in collector.grips for each in grip.activations.values() for one in each]
    assert len({id(readings) for each in activations for readings in each.readings}) <= 51
    monkeypatch.setattr(attempts_module, "MOST_GRIPS", 0)
    assert not collected(nominal).grips


def test_values_that_make_no_sense_alone_are_not_tried() -> None:
    lost = TunableKey("bottom_vacuum", ("lost_kpa",), 50.0, whole=False)
    actuator = TOOL.actuators["bottom_vacuum"]
    assert lost.with_value(actuator, TOOL.supply, 56.0) is None  # confirmed at 55
    assert lost.with_value(actuator, TOOL.supply, 150.0) is None
    assert lost.with_value(actuator, TOOL.supply, 54.0) is not None


def command(*words: object) -> Result:
    return CliRunner().invoke(eehal, ["tune", *map(str, words)])


def test_the_command(nominal: Path) -> None:
    result = command(nominal)
    assert result.exit_code == 0, result.output
    assert "1 grip in 1 recording" in result.output
    assert "bottom_vacuum.timeout_s" in result.output
    assert "what another pause would have changed is in no recording" in result.output
    content = json.loads(command(nominal, "--json").stdout)
    assert (content["grips"], content["set_aside"]) == (1, {})
    keys = [each["key"] for each in content["parameters"]]
    assert "actuators.top_vacuum.lost_kpa" in keys
    assert "actuators.cylinder.reset_s" in [each["key"] for each in content["not_tried"]]


def test_one_of_many_that_cannot_be_read_is_left_out(nominal: Path, tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / "runs" / name).mkdir(parents=True)
    (tmp_path / "runs" / "a" / "hal.mcap").write_bytes(b"nothing")
    shutil.copy(nominal / "hal.mcap", tmp_path / "runs" / "b")
    content = json.loads(command(tmp_path / "runs", "--json").stdout)
    assert content["grips"] == 1
    (note,) = [each for each in content["notes"] if "left out" in each]
    assert "not an MCAP file" in note
    assert isinstance(command(tmp_path / "runs" / "a").exception, UsageError)


def test_tables_have_pressures_and_no_bits(nominal: Path, tmp_path: Path) -> None:
    """What its bit decided is set aside; the rest is as of the trace."""
    files = RecordingFiles(nominal)
    with Recording(tmp_path / "run", TOOL, now=lambda: files.begin) as recording:
        for at, kind, record in files.entries():
            if kind == "status":
                recording.state(at, record.ee, record.command, record.actuators)
            elif kind == "frame":
                recording.values(record.stamp, record.values)
    content = json.loads(command(tmp_path / "run", "--description", profile_path(), "--json").stdout)
    assert content["set_aside"] == {"cylinder": 1}
    (wait,) = [each for each in content["parameters"] if each["key"] == "actuators.bottom_vacuum.timeout_s"]
    assert wait["same_from"] == pytest.approx(
        of(tuned(nominal), "bottom_vacuum.timeout_s").same_from, abs=0.021
    )


def test_a_recording_without_a_grip_is_refused(tmp_path: Path) -> None:
    folder = recorded(tmp_path / "run", "nominal", 1.0)
    for path in (folder, tmp_path / "none"):
        assert isinstance(command(path).exception, UsageError), path
    assert replayed(folder).exit_code == 0


def test_thresholds_of_a_pressure_that_no_wire_carries_are_not_tried() -> None:
    shipped = load(profile_path())
    assert "actuators.cylinder.retracted_kpa" in {each.key for each in parameters_of(shipped)}
    cylinder = shipped.actuators["cylinder"].model_copy(update={"channel": "none"})
    tool = shipped.model_copy(update={"actuators": {**shipped.actuators, "cylinder": cylinder}})
    idle = {"actuators.cylinder.extended_fraction", "actuators.cylinder.retracted_kpa"}
    assert not idle & {each.key for each in parameters_of(tool)}
    said = dict(not_tried(tool))
    assert {said[key] for key in idle} == {"no pressure of it is measured, so that its thresholds are off"}
