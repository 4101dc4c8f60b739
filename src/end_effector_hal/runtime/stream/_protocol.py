"""The messages on a program's socket: JSON lines.

From the program, one line for each record: ``{"kind": …, "at": µs, "content": {…}}``, in the words of the recording
(docs/reference/recordings.md). The first is the ``header``; then comes ``state``, where the program stands (nothing,
if it has not started yet), and from there on every record. Three kinds are in no recording: ``published`` (the status
with what the program knows beside its automata), ``alive`` (each 0.4 s in which nothing else is sent, while the program
works) and ``answer-to``. ``header`` comes again, with a new ``state``, when records were lost.

To the program: ``{"id": any, "command": "grip", "until_us": µs}``, in maintenance with ``"actuator": name``. The answer
is ``{"kind": "answer-to", "id": …, "accepted": …, "reason": …}``. Only the automata accept a command or refuse it; in
maintenance the answer comes when the line is written, before a sensor shows anything. After ``until_us`` on the
monotonic clock (at most 2 s from now) a command is not executed any more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field, TypeAdapter, ValidationError
from pydantic_core import to_json

from end_effector_hal.control import Answer
from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import UsageError

LONGEST = 1000
"""Bytes of a message to the program."""
COMMAND_VALID_US = 2_000_000
TOO_LATE = "The command came too late and was not executed."
MAINTENANCE_WORDS = ("activate", "deactivate")
"""Of one actuator (IL-12)."""
RELOAD, GO_ON = "reload", "go-on"
RELOAD_WORDS = (RELOAD, GO_ON)
"""Of either program: whether its description can be taken over as it is in the file now; if so, nothing is activated
for 30 s, or until it is told to go on."""
PROGRAM_WORDS: Mapping[str, tuple[str, ...]] = {
    "grip": ("grip", "drop", "cancel", "acknowledge", *MAINTENANCE_WORDS),
    "tool_change": ("lock", "unlock", "arm", "reset"),
}
"""What each program can be asked; ``acknowledge``: alarms that are over were seen."""


def program_socket(description: Description, program: str) -> Path:
    """The socket of a program: beside that of the line arbiter; raises WireError as `socket_path` does."""
    arbiter = socket_path(description)
    return arbiter.with_name(f"{arbiter.name}.{program}")


def program_of(word: str) -> str:
    """The program that takes a command."""
    return next(name for name, words in PROGRAM_WORDS.items() if word in words)


@dataclass(frozen=True, slots=True)
class ProgramCommand:
    """One command of a client."""

    id: Annotated[int, Field(ge=0, le=2**53)]
    command: Annotated[str, Field(max_length=40)]
    until_us: Annotated[int, Field(ge=0, le=2**62)]
    actuator: Annotated[str, Field(max_length=100)] = ""


_COMMAND = TypeAdapter(ProgramCommand)


def read_command_message(line: bytes) -> ProgramCommand:
    """Raises UsageError."""
    try:
        return _COMMAND.validate_json(line, strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "message"
        raise UsageError(f"This is not a command: {place}: {first['msg']}.") from None


def record_line(kind: str, at: int, content: object) -> bytes:
    """One record."""
    return to_json({"kind": kind, "at": at, "content": content}, fallback=_plain) + b"\n"


def answer_line(number: int | None, answer: Answer) -> bytes:
    """What became of a command; ``number`` None: it belongs to none."""
    said = {"kind": "answer-to", "id": number, "accepted": answer.accepted, "reason": answer.reason}
    return to_json({**said, "decided": answer.decided}) + b"\n"


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else str(value)
