"""When a reading can prove that an actuator on a commanded bus is gone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Evidence

OPEN, ACTIVE = -1, 2**63 - 1
"""Stand for a time, µs: any reading proves that the actuator is gone, or none does."""


class OutputGate:
    """Decides which actuators count as gone if their sensors say so; sans-IO.

    A write over a bus may be late or lost, and then a device moves later than its sensors show. From its activation on
    an actuator is therefore not gone, whatever is read, until it was deactivated and its device has obeyed: a frame
    that came later says that the output was inactive when its values were requested. Lines of the board obey at once
    and need no gate.

    Args:
        description: the tool.
    """

    MEMORY: ClassVar = {"_after": tuple[int, ...]}

    def __init__(self, description: Description) -> None:
        outputs = description.register_outputs
        self._lines = tuple(
            actuator.line if actuator.line in outputs else "" for _, actuator in description.ordered
        )
        self._after = (OPEN,) * len(self._lines)  # only a later frame opens the gate, µs

    def switch(self, index: int, at: int, *, active: bool) -> None:
        """Process that an actuator, by its position in the sequence, was commanded at ``at`` µs."""
        if self._lines[index]:
            after = ACTIVE if active else at
            self._after = (*self._after[:index], after, *self._after[index + 1 :])

    def see(self, frame: Frame) -> None:
        """Process what a frame says about the outputs."""
        if frame.inactive and any(OPEN < after < frame.at for after in self._after):
            self._after = tuple(
                OPEN if line in frame.inactive and after < frame.at else after
                for line, after in zip(self._lines, self._after, strict=True)
            )

    def withheld(self, evidence: Sequence[Evidence]) -> tuple[int, ...]:
        """Return the actuators whose sensors say that they are gone and whose gate is closed."""
        pairs = enumerate(zip(evidence, self._after, strict=True))
        return tuple([i for i, (level, after) in pairs if level is Evidence.GONE and after != OPEN])
