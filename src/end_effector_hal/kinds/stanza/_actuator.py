"""What every actuator of a gripping sequence has, whatever its kind."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ._endings import OwnEndings
from ._part import LineName, MaybeSeconds, Name, Part, RosName, Seconds, Word


class Actuator(Part):
    """What every actuator has: a line that drives it, a channel that proves it, and its times.

    The stanza of a kind inherits it, with ``kind: Literal["…"]`` and its own keys. The keys here are also the
    constants that an actuator gives the automata: ``timeout_s`` is T_CONFIRM, ``reset_s`` T_RESET, ``release_s``
    T_GONE, ``attempts`` ATTEMPTS, ``endings`` the …_KEEPS.
    """

    if TYPE_CHECKING:  # a field of each kind's own stanza, where it is one word
        kind: str

    line: LineName = Field(description="name of the GPIO line, as gpioinfo shows it")
    pin: Word = Field(default="", description="where it is found on the board; for people")
    channel: Name = Field(
        description="pressure channel of the link that proves it; none, where a bit proves it: no such sensor"
    )
    timeout_s: Seconds = Field(default=5.0, description="not confirmed within: one failed attempt")
    reset_s: Seconds = Field(default=1.0, description="inactive between two attempts")
    attempts: Annotated[int, Field(ge=1, le=20)] = Field(default=3, description="failed attempts that abort")
    release_s: Seconds = Field(default=2.0, description="longest wait for the feedback to be gone")
    frozen_s: MaybeSeconds = Field(
        default=None,
        description="a pressure that does not move by a count for so long is invalid; null: never",
    )
    endings: OwnEndings = Field(
        default=OwnEndings(), description="what each ending does to this one; default: as for the whole tool"
    )
    service: RosName | None = Field(default=None, description="ROS service; default: Set + name in CamelCase")
    topic: RosName | None = Field(
        default=None, description="ROS topic; default: Pressure + name in CamelCase"
    )
