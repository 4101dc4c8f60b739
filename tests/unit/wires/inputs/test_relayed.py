"""Frames of inputs that the line arbiter hands on: what they may be."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import carrier_of, load_tool
from end_effector_hal.sensing import proven_by_arbiter
from end_effector_hal.signals import Frame
from end_effector_hal.wires.inputs import inputs_record
from end_effector_hal.wires.inputs._relayed import read_inputs_record
from tests.support.places import ROOT

NAMES = ("stop", "rack")
TOOL = ROOT / "examples" / "tools" / "two_coil_changer" / "end_effector.yaml"


def test_a_frame_comes_as_it_went() -> None:
    frame = Frame(5, None, None, {"stop": True, "rack": False})
    assert read_inputs_record(inputs_record(frame).rstrip(b"\n"), NAMES, 9) == frame


@pytest.mark.parametrize(
    "record",
    [
        b"",
        b"[]",
        b"5",
        b'"at"',
        b"\xff\xfe",
        b'{"at": 5}',
        b'{"at": 5, "content": []}',
        b'{"at": 5, "content": 3}',
        b'{"at": 5, "content": {"other": true}}',
        b'{"at": 5, "content": {"stop": 1}}',
        b'{"at": -5, "content": {"stop": true}}',
        b'{"at": true, "content": {"stop": true}}',
        b'{"at": 5.5, "content": {"stop": true}}',
        b'{"at": "5", "content": {"stop": true}}',
        b"[" * 60_000,
    ],
)
def test_anything_else_is_no_frame(record: bytes) -> None:
    assert read_inputs_record(record, NAMES, 9) is None


def test_what_is_not_expected_is_left_out_and_no_stamp_is_ahead_of_now() -> None:
    record = b'{"at": 99, "content": {"stop": true, "rack": null, "other": true}}'
    assert read_inputs_record(record, NAMES, 9) == Frame(9, None, None, {"stop": True})


def test_which_lines_the_arbiter_reads_and_what_it_proves_by_them() -> None:
    tool = load_tool(TOOL)
    assert tool.arbiter_inputs == {"changer_locked", "changer_unlocked", "coupled", "in_rack"}
    assert proven_by_arbiter(tool, carrier_of(tool)) == {"locked", "parked"}
    changer = tool.tool_changer
    assert changer is not None
    for key in ("locked_bit", "unlocked_bit"):
        other = tool.model_copy(update={"tool_changer": changer.model_copy(update={key: "jaw_closed"})})
        assert "locked" in proven_by_arbiter(other, carrier_of(other))
        over_link = {name: each for name, each in tool.channels.items() if name != getattr(changer, key)}
        other = tool.model_copy(update={"channels": over_link})
        assert "locked" not in proven_by_arbiter(other, carrier_of(other))
