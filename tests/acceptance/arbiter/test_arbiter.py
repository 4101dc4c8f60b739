"""The line arbiter and its client over a real socket."""

import json
import os
import socket
import stat
import tempfile
import threading
from pathlib import Path

import pytest

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
from end_effector_hal.wires.lines import VirtualLines
from tests.acceptance.arbiter.bench import BOTTOM, LINES, POLICY, TOKEN, TOP, UNLOCK, Bench, Raw
from tests.support.patience import wait_until
from tests.support.stranger import as_nobody

pytestmark = pytest.mark.wall


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
        wait = client.ask({BOTTOM: True}, [LastWillStep(BOTTOM, False)])
        levels = [None]
        other = threading.Thread(target=lambda: levels.append(client.levels()))
        other.start()  # waits for its turn: a reply belongs to one request
        assert wait() == 0
        other.join()
        assert levels[-1][BOTTOM]
        with pytest.raises(UsageError):
            client.ask({UNLOCK: True})()
        client.ask({BOTTOM: False})()
        wait_until("it", lambda: client.levels()[BOTTOM] is False)
        with pytest.raises(UsageError):
            client.ask({BOTTOM: True}, ["no step"])()
        with pytest.raises(TypeError):
            client.ask({BOTTOM: True}, [object()])
        assert client.levels()[BOTTOM] is False, "the client goes on"


def test_a_write_in_two_parts_never_waits_for_the_calls_of_others(bench):
    with bench.arbiter(), ArbiterClient(bench.socket, "grip", [BOTTOM]) as client:
        first = client.ask({BOTTOM: True})
        second = client.ask({BOTTOM: False})  # its turn has not come: all of it is done when it is waited for
        assert first() == 0
        assert client.levels()[BOTTOM] is True
        second()
        wait_until("it", lambda: client.levels()[BOTTOM] is False)


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


LATCHING = Policy(LINES, lease_us=1_500_000, min_switch_us=0, faults={"sensor_fault": "changer"})


def test_what_a_client_latches_or_clears_while_no_arbiter_is_there_is_told_to_the_next(bench):
    with bench.arbiter(LATCHING):
        grip = bench.client()
        grip.latch("sensor_fault", "IL-04")
    with pytest.raises(ArbiterError):
        grip.clear("sensor_fault")
    with bench.arbiter(LATCHING), bench.client("look", []) as look:
        wait_until("it", lambda: not look.status()["faults"])
        assert look.reset() == {}
    with pytest.raises(ArbiterError):
        grip.latch("sensor_fault", "another one")
    with bench.arbiter(LATCHING), bench.client("look", []) as look:
        wait_until("it", lambda: look.status()["faults"] == {"sensor_fault": "another one"})
        grip.clear("sensor_fault")
        assert look.status()["faults"] == {}
        grip.close()


def test_a_client_that_was_declared_dead_comes_back_with_what_it_has_latched(bench):
    alive = threading.Event()
    alive.set()
    with bench.arbiter(LATCHING), bench.client() as grip, bench.client("look", []) as look:
        grip.attend(alive=alive.is_set)
        grip.latch("sensor_fault", "IL-04")
        assert look.reset() == {"sensor_fault": "grip has latched sensor_fault, and has not been reset."}
        alive.clear()
        wait_until("it", lambda: look.reset() == {})
        assert look.status()["faults"] == {}
        alive.set()
        wait_until("it", lambda: look.status()["faults"])
        assert look.reset()
        grip.clear("sensor_fault")


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
        ArbiterServer(VirtualLines(bench.chip), tmp_path / "file" / "arbiter.sock", POLICY)
    with bench.arbiter():
        pass
