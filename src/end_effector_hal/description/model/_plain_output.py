"""An output beside the grip: a lamp, an air knife, a fan."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from end_effector_hal.kinds.stanza import LineName, Part, RosName


class PlainOutput(Part):
    """Switched whenever somebody asks, but for an open e-stop (IL-13). No step of a grip, never evidence."""

    line: LineName = Field(description="name of the GPIO line; active means on")
    service: RosName | None = Field(default=None, description="ROS service; default: Set + name in CamelCase")
    on_death: Literal["deactivate", "keep"] = Field(
        default="deactivate",
        description="what the line arbiter does when the process that switches it ends or dies",
    )
