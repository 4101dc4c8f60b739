"""Endings: what an actuator does when a grip or the program ends.

The whole tool has defaults; an actuator may override them.

Safe is not "all off": while a part is held, it is safe to hold.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from ._base import BaseStanza

Ending = Literal["hold", "release"]
ProgramEnding = Literal["hold", "release", "leave"]
"""What a program's end does; `leave` moves nothing, as `hold`, but nobody is responsible for the level."""

_CANCEL = "a grip is cancelled; hold: stays active, latched GRIP_ERROR"
_TIMEOUT = "between two attempts; hold: stays active"
_ABORT = "a grip is given up; hold: stays active, latched GRIP_ERROR"
_LOST = "one actuator's feedback is lost; hold: latched GRIP_ERROR, this one stays active"
_SIGTERM = "the program receives SIGTERM"
_DEATH = "the program dies; the line arbiter does this"
_POWER_UP = "found active at the start; hold: stays and is judged; release: deactivated"


class GrippingEndings(BaseStanza):
    """What an ending does before GRIPPED, when nothing is held yet; a release keeps the release order."""

    cancel: Ending = Field(default="release", description=_CANCEL)
    timeout: Ending = Field(default="release", description=_TIMEOUT)
    abort: Ending = Field(default="release", description=_ABORT)
    sigterm: ProgramEnding = Field(default="release", description=_SIGTERM)
    process_death: ProgramEnding = Field(default="release", description=_DEATH)


class HeldEndings(BaseStanza):
    """What an ending does while a part is held; `release` is only allowed if IL-09 is switched off."""

    lost: Ending = Field(default="hold", description=_LOST)
    sigterm: ProgramEnding = Field(default="hold", description=_SIGTERM)
    process_death: ProgramEnding = Field(default="hold", description=_DEATH)


class Endings(BaseStanza):
    """The endings of every actuator without its own. A Drop releases all actuators, whatever is declared."""

    gripping: GrippingEndings = Field(
        default=GrippingEndings.model_construct(), description="before GRIPPED: nothing is held yet"
    )
    held: HeldEndings = Field(default=HeldEndings.model_construct(), description="while a part is held")
    power_up: Ending = Field(default="hold", description=_POWER_UP)


class OwnGrippingEndings(BaseStanza):
    """The endings of this actuator alone before GRIPPED; null: as in `endings` of the whole tool."""

    cancel: Ending | None = Field(default=None, description=_CANCEL)
    timeout: Ending | None = Field(default=None, description=_TIMEOUT)
    abort: Ending | None = Field(default=None, description=_ABORT)
    sigterm: ProgramEnding | None = Field(default=None, description=_SIGTERM)
    process_death: ProgramEnding | None = Field(default=None, description=_DEATH)


class OwnHeldEndings(BaseStanza):
    """The endings of this actuator alone while a part is held; null: as in `endings` of the whole tool."""

    lost: Ending | None = Field(default=None, description=_LOST)
    sigterm: ProgramEnding | None = Field(default=None, description=_SIGTERM)
    process_death: ProgramEnding | None = Field(default=None, description=_DEATH)


class OwnEndings(BaseStanza):
    """The endings of one actuator; a key that is not written is taken from `endings` of the whole tool."""

    gripping: OwnGrippingEndings = Field(
        default=OwnGrippingEndings.model_construct(), description="before GRIPPED: nothing is held yet"
    )
    held: OwnHeldEndings = Field(default=OwnHeldEndings.model_construct(), description="while a part is held")
    power_up: Ending | None = Field(default=None, description=_POWER_UP)

    def over(self, default: Endings) -> Endings:
        """Return the endings of the tool, with those of this actuator replacing them where given."""
        return Endings(
            gripping=default.gripping.model_copy(update=_written(self.gripping)),
            held=default.held.model_copy(update=_written(self.held)),
            power_up=self.power_up or default.power_up,
        )


class ChangerEndings(BaseStanza):
    """What an ending does to the unlock output; when the output is inactive, a spring locks the changer."""

    sigterm: ProgramEnding = Field(
        default="release", description="the program receives SIGTERM; hold: active until IL-03 ends it"
    )
    process_death: ProgramEnding = Field(
        default="release", description="the program dies; hold: active until IL-03 ends it"
    )


def _written(stanza: BaseStanza) -> dict[str, str]:
    return {key: value for key, value in stanza if value is not None}
