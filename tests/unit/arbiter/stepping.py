"""A real line arbiter on a real socket, round by round in virtual time: no thread, no waiting, the same every time."""

from __future__ import annotations

import json
import os
import socket
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.arbiter import ArbiterServer, Policy
from end_effector_hal.arbiter.server import _connections, _requests, _server
from end_effector_hal.wires.lines import VirtualChip, VirtualLines
from tests.support.keeping import CLOSED, GRIP, LINES, LOCKED, UNLOCK

MS, S = 1_000, 1_000_000
GUARDED = Policy(
    LINES,
    [(UNLOCK, line) for line in GRIP],
    {UNLOCK: 3 * S},
    needs={UNLOCK: (CLOSED,), **dict.fromkeys(GRIP, (CLOSED, LOCKED))},
    faults={"sensor_fault": "changer"},
)


class Peer:
    """One connection; it never waits."""

    def __init__(self, arbiter: Stepped) -> None:
        self._arbiter, self._rest = arbiter, b""
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.setblocking(False)
        self.sock.connect(arbiter.socket.name)
        self.number = 0

    def send(self, message: dict[str, Any] | bytes) -> None:
        data = message if isinstance(message, bytes) else json.dumps(message).encode() + b"\n"
        with suppress(BlockingIOError, BrokenPipeError, ConnectionResetError):
            self.sock.send(data)

    def replies(self) -> list[dict[str, Any]]:
        """What came since the last time."""
        return [json.loads(line) for line in self.lines()]

    def lines(self) -> list[bytes]:
        with suppress(BlockingIOError, ConnectionResetError):
            while data := self.sock.recv(1 << 20):
                self._rest += data
        *lines, self._rest = self._rest.split(b"\n")
        return lines

    def ask(self, op: str, **fields: object) -> dict[str, Any]:
        """Its reply; the arbiter has a few rounds for it."""
        self.number += 1
        self.send({"id": self.number, "op": op, **fields})
        for _ in range(4):
            self._arbiter.step()
            for reply in self.replies():
                if reply["id"] in (self.number, None):
                    return reply
        raise AssertionError(f"no reply to {op} {fields}")

    @property
    def open(self) -> bool:
        """Whether the arbiter has not closed it; what came is left out."""
        self._arbiter.step()
        try:
            while self.sock.recv(1 << 20):
                pass
        except BlockingIOError:
            return True
        except ConnectionResetError:
            pass
        return False

    def writes(
        self, *lines: str, client: str = "grip", token: str = "a" * 32, **more: object
    ) -> dict[str, Any]:
        return self.ask("hello", client=client, token=token, lines=lines, **more)

    def proves(self, token: str = "b" * 32) -> dict[str, Any]:
        return self.ask("hello", role="sensors", client="pressure", token=token)

    def tell(self, **predicates: bool) -> dict[str, Any]:
        return self.ask("tell", predicates=predicates, at_us=self._arbiter.at)

    def close(self) -> None:
        self.sock.close()


class Stepped:
    """The arbiter, its clock, and those who connect to it."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, policy: Policy = GUARDED) -> None:
        self.at = 1_000 * S
        for module in (_server, _requests, _connections):
            monkeypatch.setattr(module, "now_us", lambda: self.at)
        self.chip = VirtualChip.create(folder / "chip", policy.lines).path
        self.socket, self.record = folder / "sock", folder / "sock.sessions"
        self.arbiter = ArbiterServer(VirtualLines(self.chip), self.socket, policy)
        self.peers: list[Peer] = []
        monkeypatch.chdir(folder)  # the folders above it may be closed to others
        self.to(1 * S)

    @property
    def rules(self) -> Any:
        return self.arbiter._arbiter

    def step(self) -> None:
        self.arbiter.step(0)

    def to(self, later: int) -> None:
        """So many µs later, in one round."""
        self.at += later
        self.step()

    def peer(self, uid: int | None = None) -> Peer:
        """Somebody connects, as another user if one is given (who runs the tests is root)."""
        if uid is not None:
            self.socket.chmod(0o666)
            self.socket.parent.chmod(0o711)
            os.seteuid(uid)
        try:
            made = Peer(self)
        finally:
            os.seteuid(os.getuid())
        self.peers.append(made)
        return made

    def close(self) -> None:
        for peer in self.peers:
            peer.close()
        self.arbiter.close()
