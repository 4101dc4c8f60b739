"""The line arbiter over its socket; those marked `wall` run real processes and kill them."""

import json
import os
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from end_effector_hal.arbiter import ArbiterClient, ArbiterServer, Policy
from end_effector_hal.errors import (
    ArbiterError,
    LineBusyError,
    LineNotFoundError,
    LineRefusedError,
    UsageError,
    WireError,
)
from end_effector_hal.vocabulary import LastWillStep
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import ChipWatcher, VirtualChip, VirtualLines, read_chip
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.stranger import as_nobody

pytestmark = pytest.mark.wall
UNLOCK, BOTTOM, TOP = LINES = ("SODIMM_206", "SODIMM_208", "SODIMM_212")
TOKEN = "a" * 32
POLICY = Policy(LINES, [(UNLOCK, BOTTOM), (UNLOCK, TOP)], {UNLOCK: 300_000}, min_switch_us=0)


class Bench:
    """A chip, the path of a socket, and arbiters on them."""

    def __init__(self, folder):
        self.chip = VirtualChip.create(folder / "chip", LINES, {BOTTOM: "up"}).path
        self.socket = folder / "run" / "owner.sock"

    @contextmanager
    def arbiter(self, policy=POLICY):
        with ArbiterServer(VirtualLines(self.chip), self.socket, policy) as arbiter:
            thread = threading.Thread(target=arbiter.run)
            thread.start()
            try:
                yield arbiter
            finally:
                arbiter.stop()
                thread.join()

    def client(self, name="grip", lines=(BOTTOM, TOP), **more):
        return ArbiterClient(self.socket, name, lines, **{"patience_s": 0.0} | more)

    def levels(self):
        return [read_chip(self.chip).lines[line].level for line in LINES]


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


class Raw:
    """A client without manners."""

    def __init__(self, bench):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(10)
        self.socket.connect(str(bench.socket))
        self.file = self.socket.makefile("rb")

    def say(self, text):
        self.socket.sendall(text if isinstance(text, bytes) else json.dumps(text).encode() + b"\n")

    def ask(self, text):
        self.say(text)
        return json.loads(self.file.readline())

    def close(self):
        self.file.close()
        self.socket.close()


def test_set_and_levels(bench):
    with bench.arbiter() as arbiter, bench.client() as grip:
        assert arbiter.levels() == dict.fromkeys(LINES, False)
        assert grip.set({BOTTOM: True}) == ({UNLOCK: False, BOTTOM: True, TOP: False}, 0)
        assert grip.levels() == {UNLOCK: False, BOTTOM: True, TOP: False}
        assert bench.levels() == [False, True, False]
        grip.set({BOTTOM: False, TOP: True})
        assert bench.levels() == [False, False, True]
    assert bench.levels() == [False, False, True]


def test_a_will_can_be_left_without_levels(bench):
    with bench.arbiter():
        grip = bench.client()
        grip.set({BOTTOM: True}, [LastWillStep(BOTTOM)])
        grip.set({}, [])
        assert grip.status()["clients"][0]["will"] == []
        grip.close()


def test_a_write_that_was_given_up_is_not_executed_later(bench):
    with bench.arbiter():
        raw = Raw(bench)
        raw.ask({"id": 1, "op": "hello", "client": "grip", "token": TOKEN, "lines": [BOTTOM]})
        will = [LastWillStep(BOTTOM).as_json()]
        late = {"id": 2, "op": "set", "levels": {BOTTOM: True}, "will": will, "until_us": now_us() - 1}
        reply = raw.ask(late)
        assert (reply["ok"], reply["error"]) == (False, "this write came too late and was not executed.")
        assert bench.levels() == [False, False, False]
        assert raw.ask({"id": 3, "op": "status"})["status"]["clients"][0]["will"] == []
        assert raw.ask(late | {"until_us": now_us() + 10_000_000})["ok"]
        assert "until_us must be a time" in raw.ask(late | {"until_us": "soon"})["error"]
        raw.close()


def test_a_client_says_how_long_its_writes_are_good_for(bench):
    bench.socket.parent.mkdir()
    said = []
    with socket.socket(socket.AF_UNIX) as deaf:
        deaf.bind(str(bench.socket))
        deaf.listen()

        def listen():
            connection, _ = deaf.accept()
            with connection, connection.makefile("rb") as lines:
                connection.sendall(b'{"id": 1, "ok": true, "levels": {}}\n')
                said.extend(json.loads(lines.readline()) for _ in range(2))
                lines.read()

        thread = threading.Thread(target=listen)
        thread.start()
        client = bench.client(timeout_s=0.2)
        begun = now_us()
        with pytest.raises(ArbiterError, match="does not answer"):
            client.set({BOTTOM: True})
        given_up = now_us()
        thread.join()
        assert begun < said[1]["until_us"] < given_up
        client.close()


def test_the_socket_is_for_the_group(bench):
    with bench.arbiter():
        assert stat.S_IMODE(bench.socket.stat().st_mode) == 0o660
    assert not bench.socket.exists()


def test_the_socket_can_be_given_to_a_group(bench):
    """Root sees the group; whoever is not root can at least give it to an own one."""
    group = 65_533 if os.geteuid() == 0 else os.getgroups()[0]
    arbiter = ArbiterServer(VirtualLines(bench.chip), bench.socket, POLICY, group=str(group))
    assert (bench.socket.stat().st_gid, stat.S_IMODE(bench.socket.stat().st_mode)) == (group, 0o660)
    arbiter.close()
    with pytest.raises(UsageError, match="there is no group 'nobody-has-this'"):
        ArbiterServer(VirtualLines(bench.chip), bench.socket, POLICY, group="nobody-has-this")
    with bench.arbiter():
        pass


ASKING = """
import socket, sys
become_nobody(groups)
try:
    socket.socket(socket.AF_UNIX).connect(sys.argv[1])
    print("connected")
except OSError as error:
    print(error.strerror)
"""


@pytest.mark.skipif(os.geteuid() != 0, reason="needs root, to be somebody else")
def test_only_members_of_the_group_can_open_the_socket():
    with tempfile.TemporaryDirectory(prefix="eehal-") as folder:
        # the folders above are open: it is the socket that decides
        os.chmod(folder, 0o755)
        bench = Bench(Path(folder))
        with ArbiterServer(VirtualLines(bench.chip), bench.socket, POLICY, group="65533") as arbiter:
            os.chmod(bench.socket.parent, 0o755)
            serving = threading.Thread(target=arbiter.run)
            serving.start()

            def ask(*groups):
                done = as_nobody(ASKING, str(bench.socket), groups=groups)
                return done.stdout.strip() or done.stderr

            try:
                assert ask(65_533) == "connected"
                assert ask(65_532) == "Permission denied"
            finally:
                arbiter.stop()
                serving.join()


def test_refusals_are_sentences(bench):
    with bench.arbiter(), bench.client() as grip, bench.client("changer", [UNLOCK]) as changer:
        grip.set({BOTTOM: True})
        with pytest.raises(LineRefusedError, match=r"^IL-01: SODIMM_206 is not activated while SODIMM_208"):
            changer.set({UNLOCK: True})
        with pytest.raises(UsageError, match="grip does not write SODIMM_206"):
            grip.set({UNLOCK: True})
        with pytest.raises(LineBusyError, match=rf"SODIMM_208 belongs to grip \(pid {os.getpid()}, "):
            bench.client("other", [BOTTOM])
        with pytest.raises(UsageError, match="IL-11"):
            grip.set({TOP: True}, [LastWillStep(TOP, True)])
        assert bench.levels() == [False, True, False]


def test_a_write_in_two_parts_is_sent_first_and_answered_later(bench):
    with bench.arbiter(), ArbiterClient(bench.socket, "grip", [BOTTOM]) as client:
        wait = client.ask({BOTTOM: True}, [(BOTTOM, False, 0)])
        levels = [None]
        other = threading.Thread(target=lambda: levels.append(client.levels()))
        other.start()  # waits for its turn: a reply belongs to one request
        assert wait().levels[BOTTOM]
        other.join()
        assert levels[-1][BOTTOM]
        with pytest.raises(UsageError):
            client.ask({UNLOCK: True})()
        assert client.ask({BOTTOM: False})().levels[BOTTOM] is False


def test_a_write_in_two_parts_never_waits_for_the_calls_of_others(bench):
    with bench.arbiter(), ArbiterClient(bench.socket, "grip", [BOTTOM]) as client:
        first = client.ask({BOTTOM: True})
        second = client.ask({BOTTOM: False})  # its turn has not come: all of it is done when it is waited for
        assert first().levels[BOTTOM] is True
        assert second().levels[BOTTOM] is False


def test_a_write_in_two_parts_tells_of_a_lost_arbiter(bench):
    with bench.arbiter():
        client = ArbiterClient(bench.socket, "grip", [BOTTOM], patience_s=0)
    wait = client.ask({BOTTOM: True})
    with pytest.raises(ArbiterError):
        wait()
    with pytest.raises(ArbiterError):  # nobody holds the connection: it does not hang
        client.ask({BOTTOM: True})()
    client.close()


def test_a_delayed_write_says_so(bench):
    with bench.arbiter(Policy(LINES, min_switch_us=200_000)), bench.client() as grip:
        delay = grip.set({BOTTOM: True}).delay_us
        assert 0 < delay <= 200_000
        wait_until("it", lambda: bench.levels()[1])


def test_il_03_is_ended_by_the_arbiter_and_told_in_its_status(bench):
    with bench.arbiter(), bench.client("changer", [UNLOCK]) as changer, bench.client("look", []) as look:
        changer.set({UNLOCK: True})
        wait_until("it", lambda: not bench.levels()[0])
        status = look.status()
        assert [(trip["line"], trip["interlock"]) for trip in status["trips"]] == [(UNLOCK, "IL-03")]
        assert [(client["client"], client["lines"]) for client in status["clients"]] == [
            ("changer", [UNLOCK])
        ]
        assert status["pid"] == os.getpid()


def test_close_holds_or_executes_what_it_is_given(bench):
    with bench.arbiter():
        with bench.client() as grip:
            grip.set({BOTTOM: True, TOP: True}, [LastWillStep(TOP), LastWillStep(BOTTOM)])
        assert bench.levels() == [False, True, True]
        grip = bench.client()
        grip.close(will=[LastWillStep(TOP)])
        grip.close()
        assert bench.levels() == [False, True, False]
        with pytest.raises(ZeroDivisionError), bench.client(will=[LastWillStep(BOTTOM)]):
            raise ZeroDivisionError
        wait_until("it", lambda: bench.levels() == [False, False, False])


def test_a_lease_that_is_not_renewed_ends(bench):
    lost, alive = [], threading.Event()
    alive.set()
    policy = Policy(LINES, lease_us=1_500_000, min_switch_us=0)
    with bench.arbiter(policy), bench.client() as grip:
        grip.attend(alive=alive.is_set, on_lost=lost.append)
        grip.set({BOTTOM: True}, [LastWillStep(BOTTOM)])
        threading.Event().wait(2.0)
        assert bench.levels()[1]
        alive.clear()
        wait_until("it", lambda: not bench.levels()[1])
        alive.set()
        wait_until("it", lambda: lost)
        assert "the lease expired" in str(lost[0])
        with pytest.raises(ArbiterError, match="the lease expired"):
            grip.set({TOP: True})
        assert grip.set({TOP: True}).levels[TOP]
        assert [grip.declared_dead(), grip.declared_dead()] == [True, False], "told once"


def test_a_lost_arbiter_is_told_once_and_found_again(bench):
    lost = []
    with bench.arbiter():
        grip = bench.client()
        grip.attend(on_lost=lost.append)
        grip.set({BOTTOM: True}, [LastWillStep(BOTTOM)])
    with pytest.raises(ArbiterError, match="was lost"):
        grip.levels()
    with pytest.raises(ArbiterError, match="cannot be reached"):
        grip.levels()
    threading.Event().wait(0.6)
    with bench.arbiter():
        assert grip.levels() == {UNLOCK: False, BOTTOM: True, TOP: False}
        assert grip.status()["clients"][0]["will"] == [{"line": BOTTOM, "level": False, "after_us": 0}]
        assert len(lost) <= 1  # a renewal may have seen it before the first call did; it is no news any more
        grip.close()


def test_a_client_that_only_reads_connects_again_by_itself(bench):
    """As when it said nothing for so long that the arbiter has closed its connection."""
    with bench.arbiter():
        look = bench.client("look", [])
        assert look.levels()
    with pytest.raises(ArbiterError, match="cannot be reached"):
        look.levels()
    with bench.arbiter():
        assert look.levels()
    with bench.arbiter():
        assert look.status()["clients"] == []
    look.close()


def test_the_renewals_find_the_arbiter_again(bench):
    lost = []
    with bench.arbiter():
        grip = bench.client()
        grip.attend(on_lost=lost.append)
    wait_until("it", lambda: lost)
    with bench.arbiter(), bench.client("look", []) as look:
        wait_until("it", lambda: look.status()["clients"])
        with pytest.raises(ArbiterError, match="was lost"):
            grip.levels()
        grip.levels()
        grip.close()
    assert len(lost) == 1


def test_a_loss_that_was_not_told_yet_does_not_make_a_close_a_death(bench):
    with bench.arbiter():
        grip = bench.client()
        grip.set({BOTTOM: True}, [LastWillStep(BOTTOM)])
    with bench.arbiter(), bench.client("look", []) as look:
        wait_until("it", lambda: look.status()["clients"])
        grip.close()
        assert look.status()["clients"] == []
        assert look.levels()[BOTTOM]


def test_a_will_that_cannot_be_delivered_is_told(bench):
    with bench.arbiter():
        grip, other = bench.client(), bench.client("changer", [UNLOCK])
    other.close()
    with pytest.raises(ArbiterError):
        grip.close(will=[LastWillStep(BOTTOM)])


def test_no_arbiter(bench):
    with pytest.raises(ArbiterError, match="cannot be reached") as caught:
        bench.client()
    assert "eehal arbiter" in str(caught.value)
    assert caught.value.where == str(bench.socket)


def test_a_client_waits_for_its_arbiter(bench):
    late = threading.Timer(0.2, lambda: held.append(held[0].__enter__()))
    held = [bench.arbiter()]
    late.start()
    with bench.client(patience_s=10):
        pass
    late.join()
    held[0].__exit__(None, None, None)


def test_an_arbiter_that_does_not_answer(bench):
    bench.socket.parent.mkdir()
    with socket.socket(socket.AF_UNIX) as deaf:
        deaf.bind(str(bench.socket))
        deaf.listen()
        with pytest.raises(ArbiterError, match="does not answer"):
            bench.client(timeout_s=0.05)


def test_a_second_arbiter_is_refused(bench, tmp_path):
    with bench.arbiter():
        with pytest.raises(LineBusyError, match=f"socket of the line arbiter is held by pid {os.getpid()}"):
            ArbiterServer(VirtualLines(bench.chip), bench.socket, POLICY)
        with pytest.raises(LineBusyError, match=f"chip is held by pid {os.getpid()}"):
            ArbiterServer(VirtualLines(bench.chip), tmp_path / "other.sock", POLICY)
        with bench.client() as grip:
            assert grip.levels()


def test_an_arbiter_that_cannot_start_leaves_nothing_behind(bench, tmp_path):
    with pytest.raises(LineNotFoundError):
        ArbiterServer(VirtualLines(bench.chip), bench.socket, Policy(("SODIMM_1",)))
    with pytest.raises(WireError, match="less than 90 letters"):
        ArbiterServer(VirtualLines(bench.chip), tmp_path / ("x" * 120), POLICY)
    (tmp_path / "file").touch()
    with pytest.raises(WireError, match="socket of the line arbiter cannot be made"):
        ArbiterServer(VirtualLines(bench.chip), tmp_path / "file" / "owner.sock", POLICY)
    with bench.arbiter():
        pass


@pytest.mark.parametrize(
    ("text", "error"),
    [
        (b"\n", "must be a JSON object"),
        (b"hello\n", "must be a JSON object"),
        (b"\xff\xfe\n", "must be a JSON object"),
        (b"[" * 50_000 + b"\n", "must be a JSON object"),
        (b"3\n", "must be a JSON object"),
        (b"1" * 5000 + b"\n", "an integer of at most 18 digits"),
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
            {"op": "hello", "client": "x", "token": TOKEN, "lines": [BOTTOM] * 65},
            "lines must be a list of 1 to 64",
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
        [{"line": BOTTOM}] * 65,
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


# Real processes

OWNER = """
import sys
from end_effector_hal.arbiter import Policy, serve
from end_effector_hal.wires.lines import VirtualLines
chip, socket, *lines = sys.argv[1:]
serve(VirtualLines(chip), socket, Policy(lines), on_ready=lambda arbiter: print("ready", flush=True))
print("end", flush=True)
"""
CLIENT = """
import sys, time
from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.vocabulary import LastWillStep
socket, *lines = sys.argv[1:]
client = ArbiterClient(socket, "grip", lines)
will = [LastWillStep(line, False, i * 300_000) for i, line in enumerate(lines[::-1])]
client.set(dict.fromkeys(lines, True), will)
print("ready", flush=True)
time.sleep(60)
"""


@contextmanager
def process(program, *arguments):
    command = [sys.executable, "-c", program, *map(str, arguments)]
    child = subprocess.Popen(command, stdout=subprocess.PIPE)
    try:
        assert child.stdout.readline() == b"ready\n"
        yield child
    finally:
        child.kill()
        child.communicate()


def test_a_killed_arbiter_leaves_the_lines_and_the_next_adopts_them(bench):
    with process(OWNER, bench.chip, bench.socket, *LINES) as first:
        with bench.client() as grip:
            with pytest.raises(LineBusyError, match=f"pid {first.pid} "):
                ArbiterServer(VirtualLines(bench.chip), bench.socket, POLICY)
            grip.set({BOTTOM: True}, [])
            wait_until("it", lambda: bench.levels()[1])
            first.kill()
            first.wait()
            with pytest.raises(ArbiterError):
                grip.levels()
        assert bench.socket.exists()
    records = bench.chip.read_bytes()
    with process(OWNER, bench.chip, bench.socket, *LINES), bench.client() as grip:
        assert grip.levels() == {UNLOCK: False, BOTTOM: True, TOP: False}
        assert bench.chip.read_bytes() == records


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_an_arbiter_that_is_asked_to_end_leaves_the_lines_as_they_are(bench, number):
    with process(OWNER, bench.chip, bench.socket, *LINES) as arbiter:
        grip = bench.client()
        grip.set({BOTTOM: True}, [LastWillStep(BOTTOM)])
        wait_until("it", lambda: bench.levels()[1])
        arbiter.send_signal(number)
        assert arbiter.stdout.read() == b"end\n"
        assert arbiter.wait(PATIENCE_S) == 0
    assert bench.levels() == [False, True, False]
    assert not bench.socket.exists()
    grip.close()


def test_the_will_of_a_killed_client_is_executed_in_order_and_in_time(bench):
    edges = []
    with (
        process(OWNER, bench.chip, bench.socket, *LINES),
        process(CLIENT, bench.socket, BOTTOM, TOP) as client,
    ):
        wait_until("it", lambda: bench.levels() == [False, True, True])
        with ChipWatcher(bench.chip, edges.append):
            killed = now_us()
            client.kill()
            client.wait()
            grip = bench.client()
            # The will ran to its end before the next client was let in.
            assert grip.levels() == dict.fromkeys(LINES, False)
            wait_until("it", lambda: len(edges) == 2)
            grip.close()
    assert [(edge.line, edge.level) for edge in edges] == [(TOP, False), (BOTTOM, False)]
    assert killed <= edges[0].at < killed + 3_000_000
    assert killed + 300_000 <= edges[1].at < killed + 3_000_000


def test_an_arbiter_that_ends_with_its_clients_still_executes_their_wills(bench):
    # as roslaunch does it at Ctrl-C: everybody is told to end, the arbiter first
    with (
        process(OWNER, bench.chip, bench.socket, *LINES) as arbiter,
        process(CLIENT, bench.socket, BOTTOM, TOP) as client,
    ):
        wait_until("it", lambda: bench.levels() == [False, True, True])
        arbiter.send_signal(signal.SIGINT)
        time.sleep(0.2)
        client.kill()
        assert arbiter.wait(PATIENCE_S) == 0
    assert bench.levels() == [False, False, False]


def test_a_second_signal_ends_an_arbiter_at_once(bench):
    with (
        process(OWNER, bench.chip, bench.socket, *LINES) as arbiter,
        process(CLIENT, bench.socket, BOTTOM, TOP),
    ):
        wait_until("it", lambda: bench.levels() == [False, True, True])
        arbiter.send_signal(signal.SIGINT)
        time.sleep(0.4)
        arbiter.send_signal(signal.SIGINT)
        assert arbiter.wait(PATIENCE_S) == 0
    assert bench.levels() == [False, True, True]


def test_a_stopped_client_is_dead_after_its_lease(bench):
    with bench.arbiter(), process(CLIENT, bench.socket, BOTTOM) as client:
        wait_until("it", lambda: bench.levels()[1])
        client.send_signal(signal.SIGSTOP)
        before = time.monotonic()
        wait_until("it", lambda: not bench.levels()[1])
        assert 0.7 < time.monotonic() - before < 5


def test_an_arbiter_that_was_stopped_kills_nobody(bench):
    with process(OWNER, bench.chip, bench.socket, *LINES) as arbiter, bench.client(timeout_s=10) as grip:
        grip.set({BOTTOM: True}, [LastWillStep(BOTTOM)])
        arbiter.send_signal(signal.SIGSTOP)
        threading.Event().wait(1.5)
        arbiter.send_signal(signal.SIGCONT)
        assert grip.levels()[BOTTOM]
        threading.Event().wait(0.3)
        assert grip.levels()[BOTTOM]
