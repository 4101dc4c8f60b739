"""How a link is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum


class LinkState(Enum):
    """What is known of the port; whether readings are stale is judged by time, elsewhere."""

    OPENING = "opening"
    """Not opened yet."""
    SILENT = "silent"
    """Open, and no frame since."""
    UP = "up"
    """Open, and a frame has come; ``last_frame`` tells when the last one did."""
    DOWN = "down"
    """It could not be opened, or was lost; it is tried again."""


@dataclass(frozen=True, slots=True)
class LinkHealth:
    """A snapshot.

    Attributes:
        state: see `LinkState`.
        since: µs, when it became so.
        error: why it is down; a sentence, else "".
        last_frame: µs, when the last frame came; None: none has.
        opened: how many times the port was opened.
        bytes, frames, lost, reboots, errors: counters of the decoders since the start, see `Decoder`;
            ``errors["codec"]``: how often the codec itself failed.
    """

    state: LinkState
    since: int
    error: str = ""
    last_frame: int | None = None
    opened: int = 0
    bytes: int = 0
    frames: int = 0
    lost: int = 0
    reboots: int = 0
    errors: Mapping[str, int] = field(default_factory=dict)
