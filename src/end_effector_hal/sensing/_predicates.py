"""What the line arbiter must know of the sensors (section 6 of the contract): predicates, from frames and time."""

from __future__ import annotations

from end_effector_hal.codecs import Carrier
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ToolEvidence

from ._frame_judge import FrameJudge
from ._sensor_set import SensorSet

LOCKED = "locked"
"""The tool is proven to be locked (IL-05)."""
NOTHING_GRIPPED = "nothing_gripped"
"""Everything is released, and what is left of a vacuum is vented for a while: by what is fitted (IL-01)."""
PARKED = "parked"
"""The tool is in its stand, or there is none (IL-02)."""
E_STOP_CLOSED = "e_stop_closed"
"""The e-stop input is read and closed (IL-13)."""


def predicates_fitted(description: Description, carrier: Carrier) -> frozenset[str]:
    """Those whose channels the carrier carries; the others are off, as are the interlocks that need them."""
    carried, changer, e_stop = carrier.channels, description.tool_changer, description.e_stop
    fitted = set()
    if changer and changer.locked_bit in carried and changer.unlocked_bit in carried:
        fitted.add(LOCKED)
    proving = (channel for _, part in description.ordered for channel in kind_of(part).channel_names(part))
    if changer and any(channel in carried for channel in proving):
        fitted.add(NOTHING_GRIPPED)
    if changer and changer.stand_bit in carried:
        fitted.add(PARKED)
    if e_stop and e_stop.channel in carried:
        fitted.add(E_STOP_CLOSED)
    return frozenset(fitted)


class Predicates:
    """Sans-IO: frames and time in, what is proven out; without a fresh reading nothing is.

    It does not depend on the programs whose lines it guards: it gets each frame before they do, and looks at it itself.

    Args:
        description: the tool.
        carrier: of its channels.
        judge: shared with those in this process who get the same frames.
    """

    def __init__(self, description: Description, carrier: Carrier, judge: FrameJudge | None = None) -> None:
        self._senses = SensorSet(description, carrier, judge)
        self._fitted = predicates_fitted(description, carrier)
        self._e_stop = description.e_stop.channel if description.e_stop else None

    def frame(self, frame: Frame, now: int | None = None) -> dict[str, bool]:
        """What holds after a frame, by name; only what is fitted, and nothing if its stamp does not count.

        Args:
            frame: of the link.
            now: µs; default: when the frame came, in virtual time.
        """
        if not self._senses.accepts(frame, frame.at if now is None else now):
            return {}
        self._senses.frame(frame)
        return self._said(frame.at)

    def advance(self, at: int) -> dict[str, bool]:
        """What holds at ``at`` µs, if nothing came since the last frame."""
        self._senses.advance(at)
        return self._said(at)

    def _said(self, at: int) -> dict[str, bool]:
        now = self._senses.now
        all_said = {
            LOCKED: now.tool is ToolEvidence.LOCKED,
            NOTHING_GRIPPED: now.nothing_gripped,
            PARKED: now.in_stand,
            E_STOP_CLOSED: bool(now.readings.get(self._e_stop, at)),
        }
        return {name: holds for name, holds in all_said.items() if name in self._fitted}
