"""Bags of each format become the recording that DataLogger would have written."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from rosbags.rosbag2 import CompressionMode

from end_effector_hal.control import EventKind
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.nodes.interface import END_EFFECTOR_STATE, SUPERVISOR_COMMANDS, pressure_topics
from end_effector_hal.recording import EventRow, read_alarms, read_pressures, read_run, read_states
from end_effector_lab.bags import Bag, ImportedBag, import_bag
from tests.support.bags import (
    COMMAND,
    PRESSURE,
    STATE,
    TOPICS,
    definitions,
    frame,
    state,
    write_ros1,
    write_ros2,
)
from tests.support.parts import with_parts

S = 1_000_000
Write = Callable[..., Path]
WRITERS: dict[str, tuple[str, Write]] = {
    "ros1": ("run.bag", write_ros1),
    "mcap": ("run", write_ros2),
    "sqlite": ("run", lambda path, *rest: write_ros2(path, *rest, mcap=False)),
}


@pytest.fixture(params=WRITERS)
def write(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[..., Path]:
    """Write a bag of each format."""
    name, writer = WRITERS[request.param]
    return lambda *rest: writer(tmp_path / name, *rest)


def imported(bag: Path, **options: Any) -> ImportedBag:
    with closing(Bag(bag)) as opened:
        return import_bag(opened, bag.parent / "imported", **options)


def rows(found: ImportedBag) -> list[tuple[float, int, int, tuple[int, ...]]]:
    log = read_states(found.folder / "states.csv")
    return [(row.time_s, row.end_effector, row.command, row.actuators) for row in log.rows]


def test_all_of_a_recording(write: Write, verdin: Description) -> None:
    pressures = {"bottom": -500, "cylinder": 2_000, "top": None, "supply": 600_000}
    bag = write([
        state(10 * S, 0),
        *frame(20_000, **pressures),
        state(12 * S, 2 * S, 1, command=2, actuators=[1, 0, 0], count=1, alarms=["Frames are late: 3."]),
        ("/supervisor_commands", COMMAND, 2 * S, {"command": 2, "part": "lid"}),
        state(12 * S, 2 * S + 100_000, 1, command=2, actuators=[1, 0, 0], count=1, alarms=["Frames are late: 3."]),
        *frame(2 * S + 20_000, **{**pressures, "bottom": -60_000}),
        state(13 * S, 3 * S, 3, actuators=[2, 2, 2], count=2, part="lid"),
    ])  # fmt: skip
    found = imported(bag, description=with_parts(verdin))
    assert (found.tool, found.states, found.pressures, found.seconds) == ("verdin_gripper", 4, 8, 3.0)
    assert not found.faults
    assert rows(found) == [
        (0.0, 0, -1, (0, 0, 0)), (2.0, 1, 2, (1, 0, 0)), (3.0, 3, -1, (2, 2, 2)),
    ]  # fmt: skip
    alarms = read_alarms(found.folder / "alarms.csv")
    assert [(row.time_s, row.event) for row in alarms] == [(2.0, "begun"), (3.0, "ended")]
    log = read_pressures(found.folder / "pressures.csv")
    assert log.channels == ("bottom", "cylinder", "top", "supply")
    assert log.samples == ((0.02, (-0.5, 2.0, None, 600.0)), (2.02, (-60.0, 2.0, None, 600.0)))
    assert (found.folder / "commands.csv").read_text().splitlines() == [
        "time_s,command,part",
        "2.000000,2,lid",
    ]
    parts = (found.folder / "parts.csv").read_text().splitlines()
    assert parts == ["time_s,part", "0.000000,", "3.000000,lid"]
    info = read_run(found.folder)
    assert (info.ros, info.start_us, info.started[:16]) == (True, 10 * S, "2026-09-21T14:13")
    assert info.limits["bottom_vacuum"]["channel"] == "bottom"


def test_events_are_those_of_the_states_and_a_wrong_one_leaves_its_state_out(write: Write) -> None:
    def began(at_us: int, name: str) -> dict[str, Any]:
        return {
            "at_us": at_us,
            "event": name,
            "actuator": "cylinder",
            "attempt": 1,
            "old_state": -1,
            "new_state": -1,
        }

    found = imported(write([
        state(1 * S, 0),
        state(2 * S, 1 * S, 1, count=1, events=[began(2 * S - 1_000, "attempt began")]),
        state(2 * S, 2 * S, 1, count=1),
        state(3 * S, 3 * S, 3, count=2, events=[began(3 * S, "exploded")]),
    ]))  # fmt: skip
    log = read_states(found.folder / "states.csv")
    assert [row.end_effector for row in log.rows] == [0, 1]
    began_row = EventRow(0.999, EventKind.ATTEMPT_BEGAN, "cylinder", 1)
    assert log.events == (began_row, EventRow(1.0, EventKind.STATE_CHANGED, old=0, new=1))
    (fault,) = found.faults
    assert fault.startswith("/EndEffectorState: 1 of 4 messages are left out; the first: 'exploded'")


def test_without_a_description_there_are_states_and_alarms(write: Write) -> None:
    found = imported(write([state(1 * S, 0), state(2 * S, 1 * S, 1), *frame(1 * S, bottom=1)]))
    assert [row[0] for row in rows(found)] == [0.0, 1.0]
    assert not (found.folder / "pressures.csv").exists()
    assert read_run(found.folder).actuators == {
        "bottom_vacuum": "vacuum",
        "cylinder": "cylinder",
        "top_vacuum": "vacuum",
    }
    assert "neither pressures nor thresholds" in found.notes[0]
    assert "no traces" in found.notes[-1]


def test_a_state_from_before_the_bag_stands_at_its_beginning(write: Write) -> None:
    """A latched state may be hours old; when the bag began is seen in the next thing that was new."""
    bag = write([state(10 * S, 0, 6), state(10 * S, S // 10, 6), state(10_000 * S, 5 * S, 1, count=1)])
    found = imported(bag)
    assert [row[0] for row in rows(found)] == [0.0, 5.0]
    assert read_run(found.folder).start_us == 9_995 * S


def test_the_machine_is_restarted_in_the_middle(write: Write, verdin: Description) -> None:
    """Its clock begins again: the times at which the messages were written down count."""
    bag = write([
        state(9_000 * S, 0), state(9_001 * S, S, 3, count=1), *frame(S, supply=500_000),
        state(20 * S, 61 * S, 6, since_us=19 * S), *frame(61 * S, supply=400_000),
        state(22 * S, 63 * S, 1, since_us=19 * S, count=1),
    ])  # fmt: skip
    found = imported(bag, description=verdin)
    assert [row[0] for row in rows(found)] == [0.0, 1.0, 61.0, 63.0]
    assert read_pressures(found.folder / "pressures.csv").times_s == (1.0, 61.0)
    assert any("jumped 1 times" in note for note in found.notes)
    assert "HALMain was started again 1 times, the last before 61.000 s." in found.notes


def test_the_wall_clock_is_set_in_the_middle(write: Write) -> None:
    """The stamps are of the monotonic clock, which goes on."""
    day = 86_400 * S
    bag = write([
        state(1 * S, 0), state(2 * S, 1 * S, 3, count=1),
        state(3 * S, day, 1, count=2), state(4 * S, day + S, 3, count=3),
    ])  # fmt: skip
    found = imported(bag)
    assert [row[0] for row in rows(found)] == [0.0, 1.0, 2.0, 3.0]
    assert not any("jumped" in note for note in found.notes)


def test_a_stamp_that_is_nonsense_moves_nothing_else(write: Write) -> None:
    bag = write([
        state(1 * S, 0), state(2 * S, 1 * S, 1, count=1), state(2**62, 2 * S, 6, count=2),
        state(4 * S, 3 * S, 3, count=3), state(-(2**62), 4 * S, 1, count=4), state(6 * S, 5 * S, 3, count=5),
    ])  # fmt: skip
    assert [row[0] for row in rows(imported(bag))] == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


def test_messages_out_of_order_and_changes_that_are_missing(write: Write) -> None:
    bag = write([
        state(1 * S, 0, count=4), state(2 * S, 1 * S, 1, count=5), state(19 * S // 10, S + 9, 3, count=5),
        state(5 * S, 4 * S, 1, count=9),
    ])  # fmt: skip
    found = imported(bag)
    assert [row[0] for row in rows(found)] == [0.0, 1.0, 1.0, 4.0]
    assert read_run(found.folder).gaps == ("Before 4.000 s 3 changes of the state are not in the bag.",)


@pytest.mark.parametrize("mcap", [True, False])
@pytest.mark.parametrize("compression", [CompressionMode.MESSAGE, CompressionMode.FILE])
def test_a_bag_that_is_compressed(tmp_path: Path, mcap: bool, compression: CompressionMode) -> None:
    messages = [state(S, 0), state(2 * S, S, 1, count=1)]
    bag = write_ros2(tmp_path / "run", messages, mcap=mcap, compression=compression)
    assert [row[0] for row in rows(imported(bag))] == [0.0, 1.0]


def test_one_of_several_tools(write: Write) -> None:
    left, right = "/left/EndEffectorState", "/cell/right/EndEffectorState"
    bag = write([state(S, 0, topic=left), state(S, 0, 1, topic=right), state(2 * S, S, 3, topic=right)])
    with pytest.raises(
        UsageError, match=r"several tools, in /cell/right, /left\. Choose one, such as --namespace"
    ):
        imported(bag)
    with pytest.raises(UsageError, match=r"no tool in /centre\. There are tools in: /cell/right, /left"):
        imported(bag, namespace="centre")
    with pytest.raises(UsageError, match=r"no tool in /\. "):
        imported(bag, namespace="/")
    assert [row[:2] for row in rows(imported(bag, namespace="cell/right/"))] == [(0.0, 1), (1.0, 3)]


def test_a_state_with_a_part_that_is_no_name_is_left_out(write: Write) -> None:
    found = imported(write([state(S, 0), state(2 * S, S, 3, part="a,b"), state(3 * S, 2 * S, 3, part="lid")]))
    assert [row[0] for row in rows(found)] == [0.0, 2.0]
    (fault,) = found.faults
    assert fault.endswith("1 of 3 messages are left out; the first: its part is not a name.")


def test_what_is_no_state_of_table_ii_is_left_out_and_told(write: Write) -> None:
    bag = write(
        [state(S, 0), state(2 * S, S, 99), state(3 * S, 2 * S, 1), state(4 * S, 3 * S, 1, actuators=[0, 0])]
    )
    found = imported(bag)
    assert [row[0] for row in rows(found)] == [0.0, 2.0]
    assert found.faults == (
        "/EndEffectorState: 2 of 4 messages are left out; the first: 99 is not a valid EndEffectorState.",
    )
    assert read_run(found.folder).gaps == found.faults


def test_another_tool_than_the_description(write: Write, verdin: Description) -> None:
    bag = write([state(S, 0, actuator_names=["a", "b", "c"])])
    with pytest.raises(UsageError, match=r"other actuators \(a, b, c\)"):
        imported(bag, description=verdin)
    assert not (bag.parent / "imported").exists()


def test_an_older_version_of_the_messages(write: Write) -> None:
    """What the bag defines is read, and what it lacks is told."""

    def older(name: str, text: str) -> str:
        gone = ("string[] alarms", "alarm_ids", "tool ", "since_us", "uint32 count", "events")
        lines = text.splitlines() if name == "EndEffectorState" else [text]
        return "\n".join(line for line in lines if not any(f" {each}" in f" {line}" for each in gone))

    found = imported(write([state(S, 0), state(2 * S, S, 1)], definitions(older)))
    assert [row[0] for row in rows(found)] == [0.0, 1.0]
    assert read_states(found.folder / "states.csv").events is None
    assert (
        "The states of the bag are of another version: they lack since_us, count, tool, alarms, alarm_ids, events."
        in found.notes
    )


def test_fields_of_other_types(write: Write) -> None:
    changed = definitions(lambda _, text: text.replace("int8 state ", "string state "))
    with pytest.raises(UsageError, match=r"no message .* can be used.*field state is of another type"):
        imported(write([state(S, 0, "GRIPPED")], changed))
    assert not Path("imported").exists()


def test_topics_that_are_missing_or_of_another_type(write: Write, verdin: Description) -> None:
    with pytest.raises(UsageError, match="no states of an end-effector: its topics are /PressureSupply"):
        imported(write(frame(0, supply=1)))


def test_a_topic_of_another_type(write: Write, verdin: Description) -> None:
    wrong = ("/EndEffectorState", PRESSURE, 0, {})
    with pytest.raises(UsageError, match="/EndEffectorState is of the type sensor_msgs/msg/FluidPressure"):
        imported(write([wrong]))


def test_no_frames(write: Write, verdin: Description) -> None:
    found = imported(write([state(S, 0)]), description=verdin)
    (note,) = [each for each in found.notes if each.startswith("There are no pressures")]
    assert all(topic in note for topic in TOPICS.values())
    assert [row[0] for row in rows(found)] == [0.0]


def test_a_folder_that_is_there_is_left_alone(write: Write) -> None:
    bag = write([state(S, 0)])
    (bag.parent / "imported").mkdir()
    found = imported(bag)
    before = (found.folder / "states.csv").read_bytes()
    with pytest.raises(UsageError, match="exists already"):
        imported(bag)
    assert (found.folder / "states.csv").read_bytes() == before


def test_the_topics_are_those_of_the_table(verdin: Description) -> None:
    assert (END_EFFECTOR_STATE.name, SUPERVISOR_COMMANDS.name) == ("EndEffectorState", "supervisor_commands")
    assert STATE.replace("/msg/", "/") == END_EFFECTOR_STATE.type
    assert {channel: f"/{topic.name}" for channel, topic in pressure_topics(verdin)} == TOPICS
    assert {topic.type for _, topic in pressure_topics(verdin)} == {PRESSURE.replace("/msg/", "/")}
