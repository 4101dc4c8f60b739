"""What the sensors of a simulated tool show, and what of it a codec carries."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import carrier_of, codec_of, get_codec
from end_effector_hal.description import Description, examine_text
from end_effector_hal.errors import UsageError
from end_effector_hal.sensing import SensorSet
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Evidence
from end_effector_lab.testbench import Bench, SensorBoard, carried
from end_effector_lab.virtual import VirtualTool

S = 1_000_000


def tool(kind: str, evidence: str, channels: str, more: str = "") -> Description:
    channel = ", channel: none" if kind in ("vacuum", "cylinder") else ""
    text = (
        f"name: tool\nlink: {{port: p, frame: {{text: {{}}}}}}\nchannels: {{{channels}}}\nsequence: [it]\n"
        f"actuators: {{it: {{kind: {kind}, line: A{channel}, evidence: {{{evidence}}}}}}}\n"
        f"supply: {{channel: none}}\n{more}"
    )
    examination = examine_text(text, "tool.yaml")
    assert examination.description is not None, examination.lines()
    return examination.description


def story(description: Description, *orders: tuple[bool, float], scenario: str = "nominal") -> list[Evidence]:
    """The evidence at the end of each order: the level of the line, and for how long."""
    bench, senses = Bench(description, scenario), SensorSet(description, carrier_of(description))
    at, ends = 0, []
    for level, seconds in orders:
        bench.line("A", level, at)
        for _ in range(round(seconds * 50)):
            at += 20_000
            shown = bench.sample(at)
            values = {name: shown[name] for name in senses.now.readings.carried if name in shown}
            senses.frame(Frame(at, None, None, values))
        ends.append(senses.now.evidence[0])
    return ends


BITS = "a: {text: {field: 1}}, b: {text: {field: 2}}, c: {text: {field: 3}}"
PRESSURES = "p: {text: {field: 1}, unit: kPa}, q: {text: {field: 2}, unit: bar, range: [0, 8]}"
CYCLE = (False, 1.0), (True, 2.0), (False, 2.0)
DONE = [Evidence.GONE, Evidence.CONFIRMED, Evidence.GONE]


@pytest.mark.parametrize("kind", ["gripper", "magnet", "vacuum", "cylinder"])
@pytest.mark.parametrize(
    ("evidence", "channels"),
    [
        ("confirmed: {on: a}, gone: {on: b}", BITS),
        ("confirmed: {on: a, for_ms: 100}, gone: {not: {on: a}, for_ms: 100}", BITS),
        ("confirmed: {all: [{on: a}, {not: {on: b}}], samples: 3}, gone: {any: [{on: b}, {on: c}]}", BITS),
        ("confirmed: {not: {any: [{on: a}, {on: b}]}}, gone: {all: [{on: a}, {on: b}]}, lost: {on: c}", BITS),
        ("confirmed: {on: a}, gone: {on: b}, fault: {all: [{on: a}, {on: b}]}, empty: {on: c}", BITS),
        ("confirmed: {channel: p, below_kpa: -50}, gone: {channel: p, above_kpa: -5}", PRESSURES),
        (
            "confirmed: {all: [{channel: p, between_kpa: [-60, -50]}, {channel: q, above_kpa: 500}]}, "
            "gone: {channel: q, below_kpa: 50}",
            PRESSURES,
        ),
        ("confirmed: {channel: q, above_kpa: 790}, gone: {not: {channel: q, above_kpa: 10}}", PRESSURES),
    ],
)
def test_whatever_proves_it_is_shown_as_far_as_the_device_is(kind: str, evidence: str, channels: str) -> None:
    assert story(tool(kind, evidence, channels), *CYCLE) == DONE


def test_on_the_way_neither_is_shown() -> None:
    it = tool("gripper", "confirmed: {on: a}, gone: {on: b}", BITS)
    assert story(it, (False, 1.0), (True, 0.12)) == [Evidence.GONE, Evidence.PARTIAL]


def test_what_fails_or_is_lost_or_stuck_is_shown_as_it_is() -> None:
    it = tool("gripper", "confirmed: {on: a}, gone: {on: b}", BITS)
    assert story(it, (True, 2.0), scenario="never-confirms:it") == [Evidence.GONE]
    assert story(it, (True, 1.0), (True, 2.0), scenario="lost-after:it:2") == [
        Evidence.CONFIRMED,
        Evidence.PARTIAL,
    ]
    assert story(it, *CYCLE, scenario="stuck-release:it")[-1] is Evidence.CONFIRMED


def test_a_gripper_without_a_part_shows_that_it_is_empty() -> None:
    it = tool("gripper", "confirmed: {on: a}, gone: {on: b}, empty: {on: c}", BITS)
    bench = Bench(it, "no-part:it")
    bench.line("A", True, 0)
    assert {name: bench.sample(2 * S)[name] for name in "abc"} == {"a": False, "b": False, "c": True}


def test_what_the_kind_shows_by_itself_is_left_to_it() -> None:
    text = (
        "name: tool\nlink: {port: p}\nsequence: [it]\nsupply: {channel: none}\n"
        "actuators: {it: {kind: vacuum, line: A, channel: bottom, evidence: "
        "{confirmed: {channel: bottom, below_kpa: -55}, gone: {channel: bottom, above_kpa: -10}}}}\n"
    )
    description = examine_text(text, "tool.yaml").description
    assert description is not None
    assert story(description, *CYCLE) == DONE
    bench = Bench(description)
    bench.line("A", True, 0)
    assert -60_000 < (bench.sample(300_000)["bottom"] or 0) < -10_000  # it goes on like a pressure


@pytest.mark.parametrize(
    ("evidence", "which"),
    [
        ("confirmed: {all: [{on: a}, {not: {on: a}}]}, gone: {on: b}", "confirmed"),
        ("confirmed: {on: a}, gone: {all: [{on: a}, {on: b}]}, fault: {on: c}", "gone"),
        # what each asks to be on would be on: a contradiction, by default
        ("confirmed: {on: a}, lost: {not: {on: b}}, gone: {all: [{not: {on: a}}, {on: b}]}", "confirmed"),
    ],
)
def test_what_cannot_be_played_is_refused_in_one_sentence(evidence: str, which: str) -> None:
    with pytest.raises(UsageError) as refused:
        Bench(tool("gripper", evidence, BITS))
    assert "'it' cannot be simulated: no value of its channels" in str(refused.value)
    assert f"makes {which!r} true alone" in str(refused.value)


def test_however_many_conditions_there_are_the_search_ends() -> None:
    pairs = ", ".join(
        "{any: [{all: [{on: a}, {not: {on: a}}]}, {all: [{on: b}, {not: {on: b}}]}]}" for _ in range(6)
    )
    with pytest.raises(UsageError, match="cannot be simulated"):
        Bench(tool("gripper", f"confirmed: {{all: [{pairs}]}}, gone: {{on: c}}", BITS))


def test_an_e_stop_of_its_own_name_is_shown() -> None:
    it = tool(
        "gripper",
        "confirmed: {on: a}, gone: {on: b}",
        BITS + ", door: {text: {field: 4}}",
        "e_stop: {channel: door}\n",
    )
    assert (Bench(it).sample(0)["door"], Bench(it, "estop-open").sample(0)["door"]) == (True, False)


def test_the_default_format_carries_all_of_the_shipped_tool(verdin: Description) -> None:
    codec = get_codec("ees1-ascii")
    values = Bench(verdin).sample(0)
    assert carried(values, codec.channels, verdin) == values
    (frame,) = codec.decoder().feed(codec.encode(Frame(0, 1, 2, values)), at=5)
    assert dict(frame.values) == values


def test_a_pressure_on_a_bit_channel_is_a_switch_at_the_threshold(verdin: Description) -> None:
    channels = get_codec("legacy-nibble").channels
    values = {"bottom": -54_999, "top": -55_000, "cylinder_extended": True, "locked": True, "unlocked": False}
    assert carried(values | {"supply": 600_000, "cylinder": 0}, channels, verdin) == {
        "bottom": False,
        "top": True,
        "cylinder_extended": True,
        "locked": True,
        "unlocked": False,
    }


def test_invalid_stays_invalid(verdin: Description) -> None:
    channels = get_codec("legacy-nibble").channels
    assert carried({"bottom": None}, channels, verdin) == {"bottom": None}


def test_switches_of_a_cylinder_and_of_the_supply(verdin: Description) -> None:
    kind = get_codec("legacy-nibble").channels["bottom"]
    channels = {"cylinder": kind, "supply": kind}
    assert carried({"cylinder": 509_000, "supply": 399_000}, channels, verdin) == {
        "cylinder": False,
        "supply": False,
    }
    assert carried({"cylinder": 511_000, "supply": 401_000}, channels, verdin) == {
        "cylinder": True,
        "supply": True,
    }


TOOL = """\
name: cup
link: {port: /dev/a, frame: {text: {start: "$"}}}
channels:
  cup: {text: {field: 1}, unit: kPa}
  tank: {text: {field: 2}, unit: bar, range: [1, 10], invalid: [-9999]}
  door: {text: {field: 3}, on: [7], invalid: [0]}
  lamp: {digital: {line: X}}
sequence: [cup]
actuators: {cup: {kind: vacuum, line: A, channel: cup}}
supply: {channel: none}
"""


def test_what_nothing_uses_has_a_value_of_its_range() -> None:
    description = examine_text(TOOL, "tool.yaml").description
    assert description
    codec = codec_of(description)
    board = SensorBoard(description, Bench(description), 0)
    (frame,) = codec.decoder().feed(board.frame(20_000).data, 20_000)
    assert (frame.values["tank"], frame.values["door"]) == (100_000, False)


def test_no_frame_has_a_channel_without_a_value_in_virtual_time() -> None:
    description = examine_text(TOOL, "tool.yaml").description
    assert description
    frames: list[Frame] = []
    tool = VirtualTool(description, on_frame=frames.append)
    tool.run(2.0)
    assert {name for frame in frames for name in frame.values} == {"cup", "tank", "door", "lamp"}
    assert not [frame for frame in frames if None in frame.values.values()]
