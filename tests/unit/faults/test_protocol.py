from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.faults import LONGEST, MOST_TEXT, FaultRequest, socket_of_testbench
from end_effector_hal.wires.rpc._messages import read_message

RIGHT = {"id": 1, "word": "check", "scenario": "nominal", "until_us": 5}


def read_fault_request(line: bytes) -> FaultRequest:
    return read_message(FaultRequest, line, "request")


def line(**changed: object) -> bytes:
    return json.dumps({**RIGHT, **changed}).encode()


def test_it_stands_beside_the_socket_of_the_line_arbiter(verdin: Description) -> None:
    assert str(socket_of_testbench(verdin.with_socket("/run/x/a.sock"))) == "/run/x/a.sock.testbench"


def test_a_request() -> None:
    request = read_fault_request(line())
    assert (request.id, request.word, request.scenario, request.until_us) == (1, "check", "nominal", 5)


@pytest.mark.parametrize(
    ("wrong", "place"),
    [
        (b"", "message"),
        (b"nominal", "message"),
        (b"\xff\xfe", "message"),
        (b"[]", "message"),
        (b"null", "message"),
        (b"{" * 5_000, "message"),
        (line(word="quit"), "word"),
        (line(id=-1), "id"),
        (line(id=2**60), "id"),
        (line(id="1"), "id"),
        (line(id=True), "id"),
        (line(until_us=-1), "until_us"),
        (line(until_us=1.5), "until_us"),
        (line(until_us=2**63), "until_us"),
        (line(scenario=None), "scenario"),
        (line(scenario=["nominal"]), "scenario"),
        (line(scenario="x" * (MOST_TEXT + 1)), "scenario"),
        (b'{"id": 1, "word": "check", "until_us": 5}', "scenario"),
    ],
)
def test_what_is_no_request_is_said_with_its_place(wrong: bytes, place: str) -> None:
    with pytest.raises(UsageError, match=f"This is not a valid request: {place}: "):
        read_fault_request(wrong)


@given(
    st.binary(max_size=300) | st.recursive(st.none() | st.integers() | st.text(), st.lists).map(json.dumps)
)
def test_whatever_comes_is_refused_in_a_sentence(content: bytes | str) -> None:
    line = content.encode() if isinstance(content, str) else content
    with pytest.raises(UsageError, match="This is not a valid request: "):
        read_fault_request(line)


def test_any_scenario_fits_into_a_message() -> None:
    assert len(line(id=2**53, word="choose", scenario="\u0001" * MOST_TEXT, until_us=2**62)) < LONGEST
