"""One question to a running program over its socket, where nobody follows its records."""

from __future__ import annotations

import socket
import time
from pathlib import Path

from pydantic_core import from_json, to_json

from end_effector_hal.control import Answer
from end_effector_hal.wires import now_us

from ._protocol import COMMAND_VALID_US
from ._readers import MOST_BYTES

PATIENCE_S = 10.0
"""For an answer: a description is loaded and checked meanwhile."""
NUMBER = 1


def ask_program(path: Path, program: str, command: str) -> Answer:
    """Ask for a command and wait for the answer; an answer in any case: one that is not decided, if none came."""
    asked = {"id": NUMBER, "command": command, "until_us": now_us() + COMMAND_VALID_US}
    until = time.monotonic() + PATIENCE_S
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as sock:
            sock.settimeout(PATIENCE_S)
            sock.connect(str(path))
            sock.sendall(to_json(asked) + b"\n")
            with sock.makefile("rb") as lines:
                while line := lines.readline(MOST_BYTES):  # a longer one is cut, and is no JSON then
                    said = from_json(line)
                    if said["kind"] == "answer-to" and said["id"] == NUMBER:
                        return Answer(said["accepted"] is True, str(said["reason"]), said["decided"] is True)
                    if time.monotonic() > until:
                        break
    except (FileNotFoundError, ConnectionRefusedError):
        why = f"The {program} program of this tool does not run: nothing listens at {path}."
        return Answer(False, why, decided=False)
    except (OSError, ValueError, KeyError, TypeError) as error:
        why = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        return Answer(False, f"The {program} program cannot be asked ({path}): {why}.", decided=False)
    return Answer(False, f"The {program} program does not answer ({path}).", decided=False)
