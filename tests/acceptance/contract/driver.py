"""A client of ROS in a process of its own, asked by JSON lines: the checks import nothing of ROS.

`Operations` is the protocol: `drivers/ros1.py` and `drivers/ros2.py` implement it, each in its environment. Names are
full names, types ``package/Name``; a message is a dict, its stamps are nanoseconds. Events come with the monotonic time
of the driver, which is that of this machine.
"""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from tests.support.patience import PATIENCE_S, wait_until
from tests.support.places import ROOT

Json = Any
Message = dict[str, Json]


class Operations(Protocol):
    """What a driver does when it is asked; each returns JSON."""

    def graph(self) -> list[dict[str, str]]:
        """Entities: ``is`` (publisher, subscriber, service, action), ``name``, ``type``, ``node``."""

    def nodes(self) -> list[str]: ...

    def service_type(self, name: str) -> str | None: ...

    def latched(self, topic: str, kind: str, timeout_s: float) -> bool: ...

    def subscribe(self, topic: str, kind: str, latched: bool) -> int: ...

    def advertise(self, topic: str, kind: str) -> int: ...

    def publish(self, of: int, message: Message) -> int: ...

    def leave(self, of: int) -> None: ...

    def call(self, service: str, kind: str, request: Message, timeout_s: float) -> Message: ...

    def constants(self, kind: str) -> dict[str, int]: ...

    def send(self, action: str, kind: str, goal: Message, timeout_s: float) -> int: ...

    def cancel(self, of: int) -> bool | None:
        """Whether it was taken; None: ROS 1 does not say."""

    def cancel_all(self, action: str, kind: str) -> None: ...

    def served(self, action: str, kind: str) -> bool: ...

    def parameter(self, node: str, name: str) -> Json: ...

    def set_parameter(self, node: str, name: str, value: str) -> tuple[bool, str]: ...

    def clock(self, seconds: float) -> None:
        """Publish the simulated time."""


@dataclass
class Heard:
    """Everything that came on a topic, and when."""

    number: int = 0
    messages: list[Message] = field(default_factory=list)
    times_s: list[float] = field(default_factory=list)

    @property
    def newest(self) -> Message:
        return self.messages[-1]


@dataclass
class Goal:
    """A goal that was sent, with everything that came of it."""

    driver: Driver
    number: int
    feedback: list[Message] = field(default_factory=list)
    ends: list[tuple[str, Message | None]] = field(default_factory=list)

    def cancel(self) -> bool | None:
        """Ask for a cancel; whether it was taken, None: nobody says."""
        taken: bool | None = self.driver.ask("cancel", of=self.number)
        return taken

    def end(self, timeout_s: float = PATIENCE_S) -> tuple[str, Message]:
        """Status and result, once they are there."""
        wait_until("a result", lambda: self.ends, timeout_s)
        (ended,) = self.ends
        assert ended[1] is not None, "a result, not a loss"
        return ended[0], ended[1]


class Driver:
    """Starts a driver; `close` ends it in good order, `vanish` kills it.

    Args:
        generation: of ROS, 1 or 2.
        env: its whole environment.
        log: what it prints beside JSON lines.
    """

    def __init__(self, generation: int, env: Mapping[str, str], log: Path) -> None:
        self._log = log
        with log.open("ab") as errors:
            self._process = subprocess.Popen(
                [sys.executable, "-m", f"tests.acceptance.contract.drivers.ros{generation}"],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, env=dict(env), cwd=ROOT,
            )  # fmt: skip
        self._numbers = itertools.count(1)
        self._answers: dict[int, Message] = {}
        self._sinks: dict[int, Callable[[Message], None]] = {}
        self._early: list[Message] = []
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def ask(self, operation: str, **arguments: Json) -> Json:
        """The answer of one of `Operations`; raises AssertionError with what went wrong."""
        number = next(self._numbers)
        line = json.dumps({"id": number, "do": operation, **arguments})
        assert self._process.stdin
        self._process.stdin.write(f"{line}\n".encode())
        self._process.stdin.flush()
        with self._changed:
            came = self._changed.wait_for(
                lambda: number in self._answers or self._process.poll() is not None, 2 * PATIENCE_S
            )
            answer = self._answers.pop(number, None)
        assert answer is not None, (
            f"{operation}: {'the driver has ended' if came else 'no answer'}, see {self._log}"
        )
        assert "error" not in answer, answer["error"]
        return answer["answer"]

    def subscribe(self, topic: str, kind: str, *, latched: bool = False) -> Heard:
        """Hear a topic from now on."""
        heard = Heard(self.ask("subscribe", topic=topic, kind=kind, latched=latched))

        def keep(event: Message) -> None:
            heard.times_s.append(event["at"])
            heard.messages.append(event["message"])

        self._sink(heard.number, keep)
        return heard

    def leave(self, *heard: Heard) -> None:
        """Hear them no more."""
        for each in heard:
            self.ask("leave", of=each.number)

    def send(self, action: str, kind: str, goal: Message | None = None) -> Goal:
        """Send a goal, once its server is there."""
        sent = self.ask("send", action=action, kind=kind, goal=goal or {}, timeout_s=PATIENCE_S)
        made = Goal(self, sent)

        def keep(event: Message) -> None:
            if event["kind"] == "feedback":
                made.feedback.append(event["message"])
            else:
                made.ends.append((event["status"], event["result"]))

        self._sink(sent, keep)
        return made

    def call(self, service: str, kind: str, **request: Json) -> Message:
        """The response of a service."""
        response: Message = self.ask(
            "call", service=service, kind=kind, request=request, timeout_s=PATIENCE_S
        )
        return response

    def graph(self) -> list[dict[str, str]]:
        """Every entity, see `Operations.graph`."""
        found: list[dict[str, str]] = self.ask("graph")
        return found

    def vanish(self) -> None:
        """Be killed: nobody is told."""
        self._process.kill()
        self._leave()

    def close(self) -> None:
        """Leave the graph; may be called again."""
        if self._process.stdin:
            self._process.stdin.close()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._leave()

    def _leave(self) -> None:
        self._process.wait()
        self._thread.join(5.0)
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe:
                pipe.close()

    def _sink(self, number: int, keep: Callable[[Message], None]) -> None:
        with self._changed:
            early = [each for each in self._early if each["of"] == number]
            self._early = [each for each in self._early if each["of"] != number]
            for event in early:
                keep(event)
            self._sinks[number] = keep

    def _read(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            said = json.loads(line)
            with self._changed:
                if "id" in said:
                    self._answers[said["id"]] = said
                elif said["of"] in self._sinks:
                    self._sinks[said["of"]](said)
                else:
                    self._early.append(said)
                self._changed.notify_all()
        with self._changed:
            self._changed.notify_all()
