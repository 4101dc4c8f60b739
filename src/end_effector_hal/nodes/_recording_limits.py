"""Read the limits of a recording from the private parameters of a node."""

from __future__ import annotations

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import RecordingLimits

from .interface import KEEP_MB, SEGMENT_MB, Parameter
from .transport import NodeTransport


def recording_limits(node: NodeTransport) -> RecordingLimits:
    """Return the limits of ``~segment_mb`` and ``~keep_mb``, or the defaults; raises UsageError if they are invalid."""
    return RecordingLimits.of_megabytes(_number(node, SEGMENT_MB, "64"), _number(node, KEEP_MB, "1000"))


def _number(node: NodeTransport, parameter: Parameter, default: str) -> float:
    text = node.parameter(parameter) or default
    try:
        return float(text)
    except ValueError:
        raise UsageError(
            f"The parameter {parameter.name} is {text[:40]!r}, expected are megabytes."
        ) from None
