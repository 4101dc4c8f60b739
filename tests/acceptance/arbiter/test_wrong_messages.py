"""Whatever is said at its socket, the line arbiter answers in words and goes on."""

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from end_effector_hal.errors import (
    UsageError,
)
from tests.acceptance.arbiter.bench import BOTTOM, LINES, TOKEN, TOP, UNLOCK, Bench, Raw
from tests.support.patience import wait_until

pytestmark = pytest.mark.wall


@pytest.mark.parametrize(
    ("text", "error"),
    [
        (b"\n", "must be a JSON object"),
        (b"hello\n", "must be a JSON object"),
        (b"\xff\xfe\n", "must be a JSON object"),
        (b"[" * 50_000 + b"\n", "must be a JSON object"),
        (b"3\n", "must be a JSON object"),
        (b"1" * 5000 + b"\n", "must be a JSON object"),
        (b'{"id": ' + b"1" * 19 + b"}\n", "an integer of at most 18 digits"),
        (b'{"id": 1.5, "op": "levels"}\n', "an integer of at most 18 digits"),
        (b'{"id": NaN, "op": "levels"}\n', "an integer of at most 18 digits"),
        (b'{"id": true, "op": "levels"}\n', "id must be an integer"),
        (b'{"id": [1], "op": "levels"}\n', "id must be an integer"),
        (b'{"id": "' + b"x" * 65 + b'", "op": "levels"}\n', "id must be an integer"),
        (b'{"op": "levels", "id": "\\ud800"}\n', "all printable"),
        (b'{"op": "levels", "\\ud800": 1}\n', "all printable"),
        (b'{"op": "levels", "x": "' + b"x" * 501 + b'"}\n', "at most 500 characters"),
        ({"op": "levels", "x": [[[[[]]]]]}, "nested at most 4 levels deep"),
        ({"op": "hello", "role": "king", "client": "x", "token": TOKEN}, "role must be left out, or sensors"),
        ({"op": "hello", "client": "x\ny", "token": TOKEN, "lines": [BOTTOM]}, "all printable"),
        ({"op": "hello", "client": "x" * 65, "token": TOKEN, "lines": [BOTTOM]}, "client must be a name"),
        (
            {"op": "hello", "client": "x", "token": TOKEN, "lines": [BOTTOM] * 129},
            "lines must be a list of 1 to 128",
        ),
        (
            {"op": "tell", "predicates": {"locked": True}, "at_us": 1},
            "only the connection with the role sensors may report predicates: say hello with it first",
        ),
        ({"op": "latch", "fault": "sensor_fault", "why": "IL-04"}, "say hello first"),
        ({"op": "fly"}, "op must be one of"),
        ({"op": ["set"]}, "op must be one of"),
        ({"op": "set", "levels": {BOTTOM: True}}, "say hello first"),
        ({"op": "hello", "client": 3, "lines": [BOTTOM]}, "client must be a name"),
        ({"op": "hello", "client": "x", "lines": [BOTTOM]}, "token must be 32 random digits"),
        ({"op": "hello", "client": "x", "token": 7, "lines": [BOTTOM]}, "token must be 32 random digits"),
        (
            {"op": "hello", "client": "x", "token": TOKEN, "lines": [BOTTOM], "faults": ["sensor_fault"]},
            "faults must be an object",
        ),
        (
            {"op": "hello", "client": "x", "token": TOKEN, "lines": [BOTTOM], "faults": {"sensor_fault": 1}},
            "faults must be an object",
        ),
        ({"op": "clear", "fault": "sensor_fault"}, "say hello first"),
        ({"op": "hello", "client": "x", "token": "", "lines": [BOTTOM]}, "token must be 32 random digits"),
        (
            {"op": "hello", "client": "x", "token": "a" * 31, "lines": [BOTTOM]},
            "token must be 32 random digits",
        ),
        (
            {"op": "hello", "client": "x", "token": "a" * 33, "lines": [BOTTOM]},
            "token must be 32 random digits",
        ),
        (
            {"op": "hello", "client": "x", "token": "g" * 32, "lines": [BOTTOM]},
            "token must be 32 random digits",
        ),
        (
            {"op": "hello", "client": "x", "token": "A" * 32, "lines": [BOTTOM]},
            "token must be 32 random digits",
        ),
        ({"op": "hello", "client": "x", "token": "a" * 32 + "\n", "lines": [BOTTOM]}, "all printable"),
        (
            {"op": "hello", "client": "x", "token": "١" * 32, "lines": [BOTTOM]},
            "token must be 32 random digits",
        ),
        ({"op": "hello", "client": "x", "token": TOKEN, "lines": [3]}, "lines must be a list"),
        ({"op": "hello", "client": "x", "token": TOKEN, "lines": []}, "lines must be a list"),
        ({"op": "hello", "client": "x", "token": TOKEN, "lines": ["SODIMM_209"]}, "did you mean SODIMM_20"),
        (
            {"op": "hello", "client": "x", "token": TOKEN, "lines": [BOTTOM], "will": 3},
            "a last will must be a list",
        ),
        (
            {"op": "hello", "client": "x", "token": TOKEN, "lines": [BOTTOM], "will": [3]},
            "step 0 of the last will",
        ),
        (
            {"op": "hello", "client": "x", "token": TOKEN, "lines": [BOTTOM], "will": [{"x": 1}]},
            "step 0 of the last will",
        ),
        (
            {"op": "hello", "client": "x", "token": TOKEN, "lines": [BOTTOM], "will": [{"line": UNLOCK}]},
            "does not write",
        ),
        ({"op": "set", "levels": {BOTTOM: 1}}, "each true or false"),
        ({"op": "set"}, "each true or false"),
    ],
)
def test_garbage_is_answered(bench, text, error):
    with bench.arbiter(), bench.client("grip", [TOP]) as grip:
        raw = Raw(bench)
        reply = raw.ask(text)
        assert reply["ok"] is False
        assert error in reply["error"]
        assert raw.ask({"id": "a", "op": "levels"}) == {
            "id": "a",
            "ok": True,
            "error": None,
            "levels": dict.fromkeys(LINES, False),
        }
        raw.close()
        assert grip.set({TOP: True}).levels[TOP]


@pytest.mark.parametrize(
    "will",
    [
        [{"line": BOTTOM, "after_us": -1}],
        [{"line": BOTTOM, "after_us": 1.5}],
        [{"line": BOTTOM, "after_us": True}],
        [{"line": BOTTOM, "level": 0}],
        [{"line": 3}],
        [{"line": BOTTOM, "after_us": 2}, {"line": TOP, "after_us": 1}],
        [{"line": BOTTOM}] * 129,
        "BOTTOM",
        {"line": BOTTOM},
    ],
)
def test_a_wrong_will_is_refused_on_both_sides(bench, will):
    with bench.arbiter(), bench.client() as grip:
        with pytest.raises(UsageError, match="will"):
            grip.set({BOTTOM: True}, will)
        raw = Raw(bench)
        reply = raw.ask({"op": "hello", "client": "x", "token": TOKEN, "lines": [UNLOCK], "will": will})
        assert reply["code"] == UsageError.code
        raw.close()
    assert bench.levels() == [False, False, False]


def test_an_endless_message_ends_the_connection(bench):
    with bench.arbiter(), bench.client():
        raw = Raw(bench)
        with pytest.raises(OSError):
            raw.say(b"x" * 4096 * 1000)
        raw.close()
        with bench.client("look", []) as look:
            assert look.levels()


def test_a_client_that_reads_no_replies_is_dead(bench):
    with bench.arbiter():
        raw = Raw(bench)
        will = [{"line": BOTTOM, "level": False, "after_us": 0}]
        raw.say({"op": "hello", "client": "x", "token": TOKEN, "lines": [BOTTOM]})
        raw.say({"op": "set", "levels": {BOTTOM: True}, "will": will})
        wait_until("it", lambda: bench.levels()[1])
        with pytest.raises(OSError):
            raw.say(b'{"op": "levels"}\n' * 100_000)
        wait_until("it", lambda: not bench.levels()[1])
        raw.close()


def test_messages_may_come_in_pieces_and_together(bench):
    with bench.arbiter():
        raw = Raw(bench)
        raw.say(b'{"id": 1, "op": "lev')
        raw.say(b'els"}\n{"id": 2, "op": "levels"}\n')
        assert [json.loads(raw.file.readline())["id"] for _ in range(2)] == [1, 2]
        raw.close()


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    deadline=None,
    max_examples=50,
)
@given(
    junk=st.binary(max_size=200),
    op=st.sampled_from(["hello", "set", "renew", "bye", "status"]),
    data=st.data(),
)
def test_the_arbiter_outlives_any_bytes(shared, junk, op, data):
    json_values = st.recursive(
        st.none()
        | st.booleans()
        | st.integers()
        | st.floats()
        | st.text(max_size=9)
        | st.sampled_from(LINES),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner, max_size=3),
    )
    keys = st.sampled_from(["id", "client", "token", "lines", "levels", "will"])
    message = data.draw(st.dictionaries(keys, json_values)) | {"op": op}
    raw = Raw(shared)
    raw.say(junk.replace(b"\n", b"") + b"\n")
    assert json.loads(raw.file.readline())["ok"] is False or junk
    assert "ok" in raw.ask(message)
    raw.close()


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    bench = Bench(tmp_path_factory.mktemp("arbiter"))
    with bench.arbiter():
        yield bench
