"""What a kind watches while a part is held: it warns, and never releases."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from typing import Any, ClassVar, NamedTuple, Protocol

from ._evidence import ChannelReadings


class AlarmKind(Enum):
    """What is found while a part is held."""

    WEAK = "weak grip"
    LEAK = "leak"
    STALE = "no valid reading"
    SUPPLY = "supply pressure"


class HoldFinding(NamedTuple):
    """Something that an operator must know; ``over``: it has ended."""

    kind: AlarmKind
    text: str
    over: bool = False


class HoldWatch(Protocol):
    """The watch over one actuator while a part is held."""

    MEMORY: ClassVar[dict[str, Any]]
    secure: bool
    """Whether the grip is more than confirmed."""

    def sample(self, readings: ChannelReadings, at: int, *, held: bool) -> None:
        """Look at the newest readings, at ``at`` µs."""
        ...

    def findings(self, who: str, since: int, at: int) -> Iterator[HoldFinding]:
        """What is to be told of ``who``, which is held since ``since`` µs and confirmed."""
        ...

    def dropped(self) -> None:
        """Nothing is held any more."""
        ...
