"""Who may ask for lines is not who may prove: one process at a time says what the sensors show."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.keeping import TOP
from tests.unit.arbiter.stepping import MS, S, Stepped

OTHER = 65534


@pytest.fixture
def arbiter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Stepped]:
    made = Stepped(tmp_path, monkeypatch)
    yield made
    made.close()


def test_what_is_told_without_the_role_counts_for_nothing(arbiter: Stepped) -> None:
    guest, program = arbiter.peer(), arbiter.peer()
    assert program.writes(TOP)["ok"]
    for peer in (guest, program):
        assert (
            "only the connection with the role sensors may report predicates"
            in peer.tell(locked=True, closed=True)["error"]
        )
    assert "has reported yet" in program.ask("set", levels={TOP: True})["error"]
    sensors = arbiter.peer()
    assert sensors.proves()["ok"]
    assert sensors.tell(locked=True, closed=True)["ok"]
    assert program.ask("set", levels={TOP: True})["ok"]
    assert "said hello already" in sensors.writes("unlock", client="x")["error"]
    assert "said hello already" in program.proves()["error"]


@pytest.mark.parametrize("uid", [None, OTHER])
def test_a_second_one_is_refused_and_latched_while_the_first_is_heard(
    arbiter: Stepped, uid: int | None
) -> None:
    sensors, second, program = arbiter.peer(), arbiter.peer(uid), arbiter.peer()
    assert sensors.proves()["ok"]
    assert program.writes(TOP)["ok"]
    assert sensors.tell(locked=False, closed=True)["ok"]
    refused = second.proves(token="c" * 32)
    assert refused["code"] == "EE-402"
    assert (
        "wants to report what the sensors show; the arbiter ignores it, because the first one (pid "
        in refused["error"]
    )
    assert "only the connection with the role sensors" in second.tell(locked=True, closed=True)["error"]
    assert "not proven to be locked" in program.ask("set", levels={TOP: True})["error"]
    (fault,) = program.ask("renew")["faults"].values()
    assert fault.startswith("A second process (pid ")
    assert program.ask("reset")["ok"]
    assert program.ask("renew")["faults"] == {}


def test_it_comes_back_with_its_token(arbiter: Stepped) -> None:
    """As after a message that was cut: the arbiter may still hold the connection from before."""
    sensors, again = arbiter.peer(), arbiter.peer()
    assert sensors.proves()["ok"]
    assert sensors.tell(locked=True)["ok"]
    assert again.proves()["ok"]
    assert not sensors.open
    assert again.tell(locked=True)["ok"]
    assert arbiter.rules.predicates.faults == {}


def test_a_token_that_was_overheard_is_of_no_use_to_another_user(arbiter: Stepped) -> None:
    sensors, thief = arbiter.peer(), arbiter.peer(OTHER)
    assert sensors.proves()["ok"]
    assert not thief.proves()["ok"]
    assert sensors.tell(locked=True)["ok"]


def test_the_next_of_the_same_user_takes_over_from_one_that_is_silent(arbiter: Stepped) -> None:
    sensors, second, stranger = arbiter.peer(), arbiter.peer(), arbiter.peer(OTHER)
    assert sensors.proves()["ok"]
    assert sensors.tell(locked=True)["ok"]
    arbiter.to(150 * MS - 1)
    assert not second.proves(token="c" * 32)["ok"]
    arbiter.to(1)
    refused = stranger.proves(token="d" * 32)["error"]
    assert "belongs to another user" in refused
    assert second.proves(token="c" * 32)["ok"]
    assert not sensors.open
    assert second.tell(locked=True)["ok"]


def test_the_role_is_free_when_its_connection_has_ended(arbiter: Stepped) -> None:
    sensors, stranger = arbiter.peer(), arbiter.peer(OTHER)
    assert sensors.proves()["ok"]
    sensors.close()
    arbiter.step()
    assert stranger.proves(token="d" * 32)["ok"]
    assert arbiter.rules.predicates.faults == {}


def test_one_that_hangs_has_the_role_for_ten_seconds(arbiter: Stepped) -> None:
    sensors = arbiter.peer()
    assert sensors.proves()["ok"]
    arbiter.to(10 * S)
    stranger = arbiter.peer(OTHER)
    assert stranger.proves(token="d" * 32)["ok"]
    assert not sensors.open
