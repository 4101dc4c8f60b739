"""What the owner must know after a restart: plain data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from end_effector_hal.arbiter.protocol import is_token
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import LastWill, printable, read_last_will


class SessionRecord(NamedTuple):
    """What one client has left.

    Attributes:
        client, token, lines: who, and what it writes; a token that is empty is nobody's.
        will: the one that is valid.
        ended: the client has gone, the will is being executed.
        pid: for people only; another process may have it meanwhile.
    """

    client: str
    token: str
    lines: tuple[str, ...]
    will: LastWill
    ended: bool
    pid: int = 0


@dataclass(frozen=True)
class ArbiterState:
    """Of an owner at one moment.

    Attributes:
        faults: sentences by name, latched until a reset.
        clients: those that write lines, and those whose will runs.
        clean: the owner ended in order.
        levels: of the lines; a line that is not in here is not compared with what is found.
        dead: names and tokens of clients that were declared dead and have not come back.
        doubt: why the wills of these clients must not be executed, a clause; empty: they may.
    """

    faults: Mapping[str, str] = field(default_factory=dict)
    clients: tuple[SessionRecord, ...] = ()
    clean: bool = True
    levels: Mapping[str, bool] = field(default_factory=dict)
    dead: tuple[tuple[str, str], ...] = ()
    doubt: str = ""

    def as_json(self) -> dict[str, object]:
        """As it stands in the record of the sessions, without the doubt: that is found in reading."""
        return {
            "faults": dict(self.faults),
            "clients": [
                [*each[:3], [step.as_json() for step in each.will], each.ended, each.pid]
                for each in self.clients
            ],
            "clean": self.clean,
            "levels": dict(self.levels),
            "dead": self.dead,
        }


def read_arbiter_state(given: Any) -> ArbiterState:
    """The other way round.

    Raises:
        UsageError: it is none; perhaps of another version.
    """
    try:
        clients = tuple(_read_client(*client) for client in given["clients"])
        levels = {str(line): level is True for line, level in given["levels"].items()}
        dead = tuple((str(client), str(token)) for client, token in given["dead"])
        return ArbiterState(read_faults(given["faults"]), clients, bool(given["clean"]), levels, dead)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise UsageError(f"this is no memory of a line owner: {error}.") from error


def read_faults(given: Any) -> dict[str, str]:
    """Sentences by name, from JSON.

    Raises:
        UsageError: it is no such object.
    """
    if not isinstance(given, dict):
        raise UsageError("faults is an object of sentences by name.")
    return {printable(str(name)): printable(str(why)) for name, why in given.items()}


def _read_client(
    client: object, token: object, lines: Iterable[object], will: object, ended: object, pid: object
) -> SessionRecord:
    known = token if is_token(token) else ""
    number = pid if type(pid) is int else 0
    return SessionRecord(
        printable(str(client)), known, tuple(map(str, lines)), read_last_will(will), bool(ended), number
    )
