"""A message that differs from an earlier one only in its id and time is read once, and means the same each time."""

import json
import sys
from pathlib import Path
from types import FrameType

import pytest

from end_effector_hal.arbiter.protocol import HEAD, read_id, read_message, read_request, read_rest
from tests.support.keeping import BOTTOM, TOP
from tests.unit.arbiter.stepping import MS, Stepped

MOST_CALLS = 60
"""A little above what one report of predicates takes in a round of the arbiter."""
WILL = b'"will":[{"line":"x","level":false,"after_us":0}]}'
READ_SHORTLY = (
    b'{"id":7,"op":"set","until_us":5,"levels":{"x":true},' + WILL,
    b'{"op":"set","until_us":0,"levels":{"x":true,"y":false},"drop":true,"part":"p","values":{"x":[1,2]}}',
    b'{"id":0,"op":"set","until_us":999999999999999999, "levels" : {}, "will":[["x",false,3]]}',
    b'{"op":"tell","at_us":12,"predicates":{"locked":true}}',
)
READ_IN_FULL = (
    b'{"id":7,"op":"set","until_us":5,"id":8,"levels":{"x":true}}',
    b'{"id":7,"op":"set","until_us":5,"levels":{"x":true},"until_us":6}',
    b'{"id":7,"op":"set","until_us":5,"levels":{"x":true},"op":"renew"}',
    b'{"id":7,"op":"set","until_us":5,"levels":{"x":true},"unt\\u0069l_us":6}',
    b'{"id":7,"op":"set","levels":{"x":true},"until_us":5}',
    b'{"id":"7","op":"set","until_us":5,"levels":{"x":true}}',
    b'{"id":7,"op":"set","until_us":-5,"levels":{"x":true}}',
    b'{"id":7,"op":"set","until_us":5,}',
    b'{"id":7,"op":"set","until_us":05,"levels":{"x":true}}',
    b'{"id":7,"op":"set","until_us":5,"levels":{"x":1}}',
    b'{"op":"tell","until_us":12,"predicates":{"locked":true}}',
)


@pytest.mark.parametrize("line", READ_SHORTLY)
def test_the_short_way_reads_the_same(line: bytes) -> None:
    head, message = HEAD.match(line), read_message(line)
    assert head
    request = read_rest(head[2], line[head.end() :])
    assert request == read_request(message)._replace(time_us=0)
    assert (int(head[1]) if head[1] else None) == read_id(message)
    assert int(head[3]) == read_request(message).time_us


@pytest.mark.parametrize("line", READ_IN_FULL)
def test_everything_odd_goes_the_long_way(line: bytes) -> None:
    head = HEAD.match(line)
    assert head is None or read_rest(head[2], line[head.end() :]) is None


def test_a_repeated_message_has_its_own_id_and_time_and_a_refusal_stays_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arbiter = Stepped(tmp_path, monkeypatch)
    sensors, grip = arbiter.peer(), arbiter.peer()
    sensors.proves()
    sensors.tell(locked=True, closed=True)
    grip.writes(BOTTOM)

    def ask(number: int, until_us: int, line: str) -> tuple[object, str]:
        rest = {"levels": {line: True}, "will": [{"line": line, "level": False, "after_us": number // 10}]}
        head = b'{"id":%d,"op":"set","until_us":%d,' % (number, until_us)
        grip.send(head + json.dumps(rest, separators=(",", ":")).encode()[1:] + b"\n")
        arbiter.step()
        (reply,) = grip.replies()
        return reply["id"], reply["error"] or ""

    assert ask(1, arbiter.at, BOTTOM) == (1, "")
    assert ask(2, arbiter.at - 1, BOTTOM) == (2, "this write came too late and was not executed.")
    assert ask(3, arbiter.at, BOTTOM) == (3, "")
    for number in (4, 5):
        found, why = ask(number, arbiter.at, TOP)
        assert found == number
        assert "does not write" in why
    assert [each.after_us for each in arbiter.rules.sessions[0].will] == [0]
    assert ask(13, arbiter.at, BOTTOM) == (13, "")
    assert [each.after_us for each in arbiter.rules.sessions[0].will] == [1], "another will, though alike"
    arbiter.close()


def test_a_repeated_report_of_predicates_costs_the_arbiter_little(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Twenty-five of them come in a second while a tool holds; the records are compared once for each."""
    arbiter = Stepped(tmp_path, monkeypatch)
    sensors, counts = arbiter.peer(), [0, 0]
    sensors.proves()
    for number in range(2):
        arbiter.at += 40 * MS
        sensors.send(b'{"op":"tell","at_us":%d,"predicates":{"locked":true}}\n' % arbiter.at)

        def count(_frame: FrameType, event: str, _what: object, number: int = number) -> None:
            counts[number] += event == "call"

        sys.setprofile(count)
        try:
            arbiter.step()
        finally:
            sys.setprofile(None)
        assert arbiter.rules.predicates.proofs["locked"].at == arbiter.at
    assert counts[1] < counts[0], "the second one is not checked again"
    assert counts[1] <= MOST_CALLS
    arbiter.close()
