"""What the owner must know after a restart: plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from end_effector_hal.errors import UsageError
from end_effector_hal.wires.will import Will, read_will


class Bequest(NamedTuple):
    """What one client has left.

    Attributes:
        client, pid, lines: who, and what it writes.
        will: the one that is valid.
        ended: the client has gone, the will is being executed.
    """

    client: str
    pid: int
    lines: tuple[str, ...]
    will: Will
    ended: bool


@dataclass(frozen=True)
class Memory:
    """Of an owner at one moment.

    Attributes:
        faults: sentences by name, latched until a reset.
        clients: those that write lines, and those whose will runs.
        clean: the owner ended in order.
    """

    faults: Mapping[str, str] = field(default_factory=dict)
    clients: tuple[Bequest, ...] = ()
    clean: bool = True

    def as_json(self) -> dict[str, object]:
        """As it stands in the journal."""
        return {
            "faults": dict(self.faults),
            "clients": [
                [each.client, each.pid, each.lines, [step.as_json() for step in each.will], each.ended]
                for each in self.clients
            ],
            "clean": self.clean,
        }


def read_memory(given: Any) -> Memory:
    """The other way round.

    Raises:
        UsageError: it is none; perhaps of another version.
    """
    try:
        clients = tuple(
            Bequest(str(client), int(pid), tuple(map(str, lines)), read_will(will), bool(ended))
            for client, pid, lines, will, ended in given["clients"]
        )
        faults = {str(name): str(why) for name, why in given["faults"].items()}
        return Memory(faults, clients, bool(given["clean"]))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise UsageError(f"this is no memory of a line owner: {error}.") from error
