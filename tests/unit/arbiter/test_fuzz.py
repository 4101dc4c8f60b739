"""Whatever comes over its socket, the line arbiter goes on, stays small, and keeps who writes lines alive."""

from __future__ import annotations

import json
import logging
import os
from pathlib import Path
from random import Random
from typing import Any

import pytest

from tests.support.keeping import BOTTOM, UNLOCK
from tests.support.nightly import examples
from tests.unit.arbiter.grammar import Grammar
from tests.unit.arbiter.stepping import MS, Peer, S, Stepped

BLOCKS = examples(2, 100) // 2
RUNS = 2
"""Of a block, each from its seed."""
STEPS, MOST_PEERS, MOST_GROWTH = 60, 50, 64 << 20


class Watched:
    """A program, the sensors, and many others that say what a seed has them say."""

    def __init__(self, arbiter: Stepped, seed: int) -> None:
        self.arbiter, self.random = arbiter, Random(seed)
        self.grammar = Grammar(self.random)
        self.program, self.sensors = arbiter.peer(), arbiter.peer()
        assert self.program.writes(BOTTOM, client="gripper")["ok"]
        assert self.sensors.proves(token="e" * 32)["ok"]
        self.sensors.send(b'{"op":"tell","predicates":{"locked":true},"at_us":-' + b"9" * 4300 + b"}\n")
        assert self.program.ask("status")["ok"]
        assert [reply["ok"] for reply in self.sensors.replies()] == [False]
        self.session = next(each for each in arbiter.rules.sessions if each.client == "gripper")
        self.others: list[Peer] = []
        self.heard = 0

    def run(self) -> None:
        for number in range(STEPS):
            self.say()
            self.arbiter.to(self.random.choice((0, 1, 40 * MS, 100 * MS)))
            self.lives(active=number % 2 == 0)
            self.hear()
        for peer in self.others:
            peer.close()

    def say(self) -> None:
        """Some connect, some go, some speak."""
        for _ in range(self.random.randrange(6)):
            if len(self.others) < MOST_PEERS:
                self.others.append(self.arbiter.peer())
        if self.others and self.random.random() < 0.3:
            self.others.pop(self.random.randrange(len(self.others))).close()
        for peer in self.random.sample(self.others, min(len(self.others), 8)):
            for _ in range(self.random.randrange(4)):
                peer.send(self.grammar.message(self.arbiter.at))
        if self.others and self.random.random() < 0.2:
            # so that some write lines, and die with a will
            peer = self.random.choice(self.others)
            token, lines = f"{self.random.getrandbits(128):032x}", [UNLOCK]
            hello = {"op": "hello", "client": "x", "token": token, "lines": lines}
            peer.send(b"\n" + json.dumps(hello).encode() + b"\n")

    def lives(self, *, active: bool) -> None:
        """The lease is renewed, what is proven counts, and lines are written, all within a few rounds."""
        renewed = self.program.ask("renew")
        assert renewed["ok"]
        assert self.session in self.arbiter.rules.sessions
        assert not self.session.ended
        assert self.session.lease_until == self.arbiter.at + 1 * S
        assert self.sensors.tell(closed=True, locked=True)["ok"]
        assert {name: claim.holds for name, claim in self.arbiter.rules.predicates.proofs.items()} == {
            "closed": True,
            "locked": True,
        }
        assert "closed" not in self.arbiter.rules.predicates.faults, (
            "who may not prove latches nothing either"
        )
        done = self.program.ask("set", levels={BOTTOM: active})
        refusals = tuple(f"{interlock}: bottom is not activated" for interlock in ("IL-05", "IL-13"))
        assert done["ok"] or done["error"].startswith(refusals), "unlock may be active, or a stranger stopped"
        self.can_go_out(renewed, self.program.ask("status"), done)

    def hear(self) -> None:
        for peer in self.others:
            if self.random.random() < 0.7:
                self.can_go_out(*peer.replies())

    def can_go_out(self, *replies: dict[str, Any]) -> None:
        for reply in replies:
            self.heard += 1
            assert isinstance(reply["ok"], bool)
            for text in texts(reply):
                assert text.encode("utf-8").decode("utf-8") == text
                assert text.isprintable(), text


def texts(value: object) -> list[str]:
    if isinstance(value, dict):
        return [text for pair in value.items() for each in pair for text in texts(each)]
    if isinstance(value, list):
        return [text for each in value for text in texts(each)]
    return [value] if isinstance(value, str) else []


def memory() -> int:
    """Bytes that this process has in memory."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.parametrize("block", range(BLOCKS))
def test_whatever_comes_the_arbiter_goes_on(
    block: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    heard, before = 0, 0
    for seed in range(block * RUNS, (block + 1) * RUNS):
        folder = tmp_path / str(seed)
        folder.mkdir()
        arbiter = Stepped(folder, monkeypatch)
        try:
            watched = Watched(arbiter, seed)
            watched.run()
            heard += watched.heard
            assert not [record for record in caplog.records if record.exc_info], f"seed {seed}"
            assert not [record for record in caplog.records if record.levelno >= logging.ERROR], (
                f"seed {seed}"
            )
            assert all(record.getMessage().isprintable() for record in caplog.records), f"seed {seed}"
        except BaseException as error:
            error.add_note(f"seed {seed}")
            raise
        finally:
            arbiter.close()
        caplog.clear()
        before = before or memory()
        assert memory() - before < MOST_GROWTH, f"seed {seed}"
    assert heard > 30 * RUNS


def test_an_arbiter_is_as_small_at_the_end_as_in_the_beginning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Names that are new each time were once kept each: 900 MB in 8 s."""
    arbiter = Stepped(tmp_path, monkeypatch)
    sensors, guest = arbiter.peer(), arbiter.peer()
    assert sensors.proves()["ok"]
    before = memory()
    for number in range(2_000):
        names = {f"{number} {each} {'x' * 40}": True for each in range(32)}
        sensors.send(json.dumps({"op": "tell", "predicates": names, "at_us": arbiter.at}).encode() + b"\n")
        guest.send(json.dumps({"op": "latch", "fault": f"{number}" * 8, "why": "y" * 400}).encode() + b"\n")
        arbiter.step()
        sensors.lines()
        guest.lines()
    assert arbiter.rules.predicates.proofs == {}
    assert arbiter.rules.predicates.faults == {}
    assert memory() - before < 8 << 20
    arbiter.close()
