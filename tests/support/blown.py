"""The shipped tool with a blow-off at its vacuums."""

from __future__ import annotations

from typing import Any

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.kinds.stanza import BlowOff

BOTTOM_AIR, TOP_AIR = "SODIMM_214", "SODIMM_216"


def blown(description: Description | None = None, **keys: Any) -> Description:
    """The tool with both blow-offs driven: for 0.2 s, or as ``keys`` say."""
    description = description or load(profile_path())
    parts = dict(description.actuators)
    for name, line in (("bottom_vacuum", BOTTOM_AIR), ("top_vacuum", TOP_AIR)):
        blow_off = BlowOff(line=line, **{"duration_s": 0.2, **keys})
        parts[name] = parts[name].model_copy(update={"blow_off": blow_off})
    bounds = description.bounds.model_copy(update={"grip_s": None, "release_s": None, "cancel_s": None})
    return description.model_copy(update={"actuators": parts, "bounds": bounds})
