"""A blow-off: a second line that pushes off what was released."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ._part import LineName, Part, Seconds


class BlowOff(Part):
    """Compressed air that pushes a part off, never active together with what holds it (IL-08).

    With `duration_s` a release blows: after the gap for so long, and goes on after another one.
    """

    line: LineName = Field(description="name of the GPIO line; active means blowing")
    gap_s: Seconds = Field(
        default=0.05,
        description="IL-08: between the end of suction, or of what else holds, and blowing, and back",
    )
    duration_s: Annotated[float | None, Field(ge=0.05, le=10)] = Field(
        default=None,
        description="a release blows for so long; null: nothing drives it, the line arbiter guards it",
    )
    until_gone: bool = Field(
        default=False,
        description="it ends earlier, as soon as the feedback is gone, and does not begin if it is; with duration_s",
    )
