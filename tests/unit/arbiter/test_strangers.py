"""What somebody who may only open the arbiter's socket can do to those who use it: nothing."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.arbiter.server._connections import IDLE_US, MOST_STRANGERS
from tests.support.keeping import BOTTOM, CYLINDER, TOP, UNLOCK
from tests.unit.arbiter.stepping import MS, S, Stepped


@pytest.fixture
def arbiter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Stepped]:
    made = Stepped(tmp_path, monkeypatch)
    yield made
    made.close()


def test_a_number_of_thousands_of_digits_is_no_time(arbiter: Stepped) -> None:
    """It once ended the arbiter, in its reply to ``status``."""
    sensors, guest = arbiter.peer(), arbiter.peer()
    assert sensors.proves()["ok"]
    sensors.send(b'{"op": "tell", "predicates": {"locked": true}, "at_us": -' + b"9" * 4290 + b"}\n")
    arbiter.step()
    (refused,) = sensors.replies()
    assert "at most 18 digits" in refused["error"]
    assert guest.ask("status")["status"]["told"] == {}


def test_new_names_of_predicates_are_refused_and_not_kept(arbiter: Stepped) -> None:
    sensors = arbiter.peer()
    assert sensors.proves()["ok"]
    for number in range(100):
        reply = sensors.tell(locked=True, **{f"name{number}": True})
        assert f"this arbiter has no predicate name{number}" in reply["error"]
    assert arbiter.rules.predicates.proofs == {}, "nothing of such a message counts"


def test_idle_connections_do_not_lock_the_programs_out(arbiter: Stepped) -> None:
    idle = [arbiter.peer() for _ in range(2 * MOST_STRANGERS)]
    for _ in range(20):
        arbiter.step()
    program, sensors = arbiter.peer(), arbiter.peer()
    assert program.writes(BOTTOM)["ok"]
    assert sensors.proves()["ok"]
    more = [arbiter.peer() for _ in range(2 * MOST_STRANGERS)]
    for _ in range(20):
        arbiter.step()
    assert sum(peer.open for peer in idle) == 0, "the oldest go first"
    assert sum(peer.open for peer in more) == MOST_STRANGERS
    assert program.ask("renew")["ok"]
    assert sensors.tell(locked=True)["ok"]


def test_the_user_who_has_most_connections_loses_one(arbiter: Stepped) -> None:
    ours = arbiter.peer()
    assert ours.ask("levels")["ok"]
    theirs = [arbiter.peer(uid=65534) for _ in range(2 * MOST_STRANGERS)]
    for _ in range(20):
        arbiter.step()
    assert ours.open
    assert sum(peer.open for peer in theirs) == MOST_STRANGERS - 1


def test_who_says_nothing_is_closed_and_who_writes_has_a_lease(arbiter: Stepped) -> None:
    program, sensors, guest = arbiter.peer(), arbiter.peer(), arbiter.peer()
    assert program.writes(BOTTOM)["ok"]
    assert sensors.proves()["ok"]
    assert guest.ask("levels")["ok"]
    guest.send(b'{"op": "lev')
    for _ in range(IDLE_US // (500 * MS)):
        arbiter.to(500 * MS)
        assert program.ask("renew")["ok"]
    assert not guest.open
    assert not sensors.open
    assert program.ask("renew")["ok"]


def test_a_will_of_ten_minutes_is_refused(arbiter: Stepped) -> None:
    guest = arbiter.peer()
    will = [{"line": TOP, "level": False, "after_us": 600 * S}]
    assert "the longest last will of this tool takes 10000000 µs" in guest.writes(TOP, will=will)["error"]
    assert guest.writes(TOP)["ok"]
    assert "the longest last will" in guest.ask("set", levels={}, will=will)["error"]
    assert "the longest last will" in guest.ask("bye", will=will)["error"]


def test_a_flood_of_one_does_not_delay_another(arbiter: Stepped) -> None:
    program = arbiter.peer()
    assert program.writes(BOTTOM)["ok"]
    strangers = [arbiter.peer() for _ in range(MOST_STRANGERS)]
    for peer in strangers:
        peer.send(b'{"op": "status"}\n' * 3_000)
    for _ in range(100):
        before = arbiter.at
        assert program.ask("renew")["ok"]
        assert arbiter.at == before
        answered = [len(peer.lines()) for peer in strangers]
        assert max(answered) <= 8, "a few in each round"


def test_a_lone_surrogate_is_made_printable_in_a_sentence_and_refused_in_a_name(arbiter: Stepped) -> None:
    program, guest = arbiter.peer(), arbiter.peer()
    latch = {"id": 1, "op": "latch", "fault": "sensor_fault", "why": "IL-04: \ud800\nboth \x1b[31mbits\x00"}
    guest.send(latch)
    arbiter.step()
    arbiter.step()
    assert [reply["error"] for reply in guest.replies()] == ["say hello first."]
    assert program.writes(BOTTOM)["ok"]
    assert program.ask("latch", **{key: latch[key] for key in ("fault", "why")})["ok"]
    (shown,) = program.ask("renew")["faults"].values()
    assert shown == "IL-04: ? both ?[31mbits?"
    assert shown.encode() in arbiter.record.read_bytes()
    for name in ("a\nb", "a\x00", "\ud800", "\u2028", "x" * 65):
        for fields in (
            {"op": "hello", "client": name, "token": "c" * 32, "lines": [TOP]},
            {"op": "hello", "client": "x", "token": "c" * 32, "lines": [name]},
            {"op": "hello", "client": "x", "token": "c" * 32, "lines": [TOP], "will": [{"line": name}]},
            {"op": "latch", "fault": name, "why": "why"},
            {"op": name},
            {"op": "levels", name: 1},
        ):
            guest.send({"id": 7, **fields})
            arbiter.step()
            arbiter.step()
            (reply,) = guest.replies()
            assert reply["ok"] is (name == "x" * 65 and fields["op"] == "levels")
            assert str(reply["error"]).isprintable()


def test_faults_of_clients_take_no_room_of_an_interlock(arbiter: Stepped) -> None:
    """32 of them once filled the table, and an open e-stop latched nothing."""
    program, sensors = arbiter.peer(), arbiter.peer()
    assert program.writes(TOP)["ok"]
    assert sensors.proves()["ok"]
    for number in range(40):
        program.ask("latch", fault=f"fault{number}", why="why")
    assert program.ask("latch", fault="sensor_fault", why="IL-04")["ok"]
    assert sensors.tell(closed=True, locked=True)["ok"]
    assert sensors.tell(closed=False, locked=True)["ok"]
    assert sensors.tell(closed=True, locked=True)["ok"]
    refused = program.ask("set", levels={TOP: True})
    assert "the e-stop was opened; reset the faults first" in refused["error"]
    assert program.ask("status")["status"]["faults"].keys() == {"sensor_fault", "closed"}


def test_the_status_shows_no_token(arbiter: Stepped) -> None:
    program, sensors, guest = arbiter.peer(), arbiter.peer(), arbiter.peer()
    assert program.writes(BOTTOM, CYLINDER)["ok"]
    assert sensors.proves()["ok"]
    assert guest.writes(UNLOCK, client="changer", token="c" * 32)["ok"]
    said = json.dumps([guest.ask("status"), guest.writes(TOP, client="x", token="d" * 32)])
    assert not any(letter * 32 in said for letter in "abcd")
