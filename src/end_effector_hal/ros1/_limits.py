"""The limits of a recording, from the private parameters of a node."""

from __future__ import annotations

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import RecordingLimits

from ._node import Node
from ._table import KEEP_MB, SEGMENT_MB, Parameter


def recording_limits(node: Node) -> RecordingLimits:
    """What ``~segment_mb`` and ``~keep_mb`` say, or the defaults; raises UsageError when they are no such limits."""
    return RecordingLimits.of_megabytes(_number(node, SEGMENT_MB, "64"), _number(node, KEEP_MB, "1000"))


def _number(node: Node, parameter: Parameter, default: str) -> float:
    text = node.parameter(parameter) or default
    try:
        return float(text)
    except ValueError:
        raise UsageError(
            f"The parameter ~{parameter.name} is {text[:40]!r}, expected are megabytes."
        ) from None
