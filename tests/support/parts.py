"""A tool that grips two parts: the whole sequence grips a panel, the top vacuum alone a lid."""

from __future__ import annotations

from end_effector_hal.description import Description
from end_effector_hal.description.model._stanzas import GrippedPart

LOST_KPA = 25.0
"""Of the top vacuum, where it grips a lid."""


def with_parts(tool: Description) -> Description:
    """The paper's tool with the parts ``panel``, the default, and ``lid``."""
    lighter = {"confirmed_kpa": 30.0, "lost_kpa": LOST_KPA, "lost_at_once_kpa": 15.0}
    lid = GrippedPart(uses=("top_vacuum",), actuators={"top_vacuum": lighter})
    return tool.model_copy(update={"parts": {"panel": GrippedPart(), "lid": lid}})
