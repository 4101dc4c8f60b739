"""The predicates that the line arbiter needs, from frames and time."""

from __future__ import annotations

from end_effector_hal.codecs import Carrier, carrier_of
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ToolEvidence

from ._device_faults import DeviceFaults
from ._sensor_set import SensorSet

LOCKED = "locked"
"""The tool is proven to be locked, and present where a sensor shows it (IL-05)."""
PRESENT = "present"
"""The tool is present, where no other sensor of the tool changer is fitted (IL-05)."""
NOTHING_GRIPPED = "nothing_gripped"
"""Everything with sensors is released, and the rest of a vacuum has been vented for a while (IL-01)."""
PARKED = "parked"
"""The tool is in its stand, or there is no tool (IL-02)."""
E_STOP_CLOSED = "e_stop_closed"
"""The e-stop input is closed (IL-13); without a valid reading the predicate is left out."""


NO_FAULT, NO_LATCHED_FAULT = "no_fault:", "no_latching_fault:"
"""Prefixes of a channel's name: a fresh reading shows no fault of its device that prevents a grip (IL-07)."""


def predicates_fitted(description: Description, carrier: Carrier) -> frozenset[str]:
    """Return the predicates whose channels are carried; others are off, with their interlocks."""
    carried, changer, e_stop = carrier.channels, description.tool_changer, description.e_stop
    fitted = set()
    if changer and changer.locked_bit in carried and changer.unlocked_bit in carried:
        fitted.add(LOCKED)
    elif changer and changer.present_bit in carried:
        fitted.add(PRESENT)
    proving = (
        channel
        for _, actuator in description.ordered
        for channel in kind_of(actuator).channel_names(actuator)
    )
    if changer and any(channel in carried for channel in proving):
        fitted.add(NOTHING_GRIPPED)
    if changer and changer.stand_bit in carried:
        fitted.add(PARKED)
    if e_stop and e_stop.channel in carried:
        fitted.add(E_STOP_CLOSED)
    faults = DeviceFaults(description)
    fitted |= {NO_FAULT + channel for channel in faults.refusing(latching=False)}
    fitted |= {NO_LATCHED_FAULT + channel for channel in faults.refusing(latching=True)}
    return frozenset(fitted)


def proven_by_arbiter(description: Description, carrier: Carrier) -> frozenset[str]:
    """Return the fitted predicates that the line arbiter proves alone, as it reads all their channels."""
    changer, e_stop, own = description.tool_changer, description.e_stop, description.arbiter_inputs
    needs: dict[str, tuple[str, ...]] = {E_STOP_CLOSED: (e_stop.channel,)} if e_stop else {}
    if changer:
        needs[LOCKED] = changer.locked_bit, changer.unlocked_bit, changer.present_bit
        needs[PRESENT] = (changer.present_bit,)
        needs[PARKED] = changer.stand_bit, changer.present_bit
    fitted = predicates_fitted(description, carrier)
    return frozenset(
        name
        for name, channels in needs.items()
        if name in fitted and own.issuperset(channel for channel in channels if channel in carrier.channels)
    )


class Predicates:
    """Computes predicates from frames and time; sans-IO. Without a fresh reading nothing is proven.

    Args:
        description: the tool.
        carrier: carries its channels; default: the one in the description.
        senses: the sensors of the program in this process, which processes the frames; None: its own, and `frame`
            processes them.
        wanted: the predicates to compute; None: all that are fitted.
    """

    def __init__(
        self,
        description: Description,
        carrier: Carrier | None = None,
        senses: SensorSet | None = None,
        wanted: frozenset[str] | None = None,
    ) -> None:
        carrier = carrier or carrier_of(description)
        self._senses = senses or SensorSet(description, carrier)
        fitted = predicates_fitted(description, carrier)
        self._wanted = fitted if wanted is None else fitted & wanted
        self._e_stop = description.e_stop.channel if description.e_stop else None
        self._present = description.tool_changer.present_bit if description.tool_changer else None

    def frame(self, frame: Frame, now: int | None = None) -> dict[str, bool]:
        """Return the wanted predicates after a frame, by name, and whether each holds.

        A frame with a refused stamp proves nothing, but the objections in it are returned all the same.

        Args:
            frame: a frame of the link.
            now: the time now, µs; default: the arrival of the frame, in virtual time.
        """
        now = frame.at if now is None else now
        if not self._senses.accepts(frame, now):
            return self.objections(frame) if frame.at <= now else {}
        # after a silence everything must be proven again, as in the program
        expired = self._senses.deadline(self.at)
        if expired is not None and expired < frame.at:
            self._senses.advance(expired)
        self._senses.frame(frame)
        return self.said(self.at)

    @property
    def at(self) -> int:
        """Time of the newest valid frame, µs."""
        return self._senses.now.readings.last_frame

    def advance(self, at: int) -> dict[str, bool]:
        """Return the predicates at ``at`` µs, if no frame came since the last one."""
        self._senses.advance(at)
        return self.said(at)

    def objections(self, frame: Frame) -> dict[str, bool]:
        """Return the wanted predicates disproved by a frame that came too late: such a fault is latched."""
        objections = {E_STOP_CLOSED} if self._e_stop and frame.values.get(self._e_stop) is False else set()
        for word, latching in ((NO_FAULT, False), (NO_LATCHED_FAULT, True)):
            objections |= {
                word + channel for channel in self._senses.now.faults.shown(frame.values, latching=latching)
            }
        return dict.fromkeys(sorted(objections & self._wanted), False)

    def said(self, at: int) -> dict[str, bool]:
        """Return the wanted predicates at ``at`` µs, by name, from what the sensors have shown until then."""
        now = self._senses.now
        said = {
            LOCKED: now.tool is ToolEvidence.LOCKED,
            NOTHING_GRIPPED: now.nothing_gripped,
            PARKED: now.in_stand,
        }
        if PRESENT in self._wanted:
            said[PRESENT] = bool(now.readings.get(self._present, at)) and now.tool is not ToolEvidence.ABSENT
        # that nothing was read is no news of an open one, which would be latched
        if (closed := now.readings.get(self._e_stop, at)) is not None:
            said[E_STOP_CLOSED] = bool(closed)
        for word, latching in ((NO_FAULT, False), (NO_LATCHED_FAULT, True)) if now.faults.channels else ():
            well = now.faults.well(now.readings, at, latching=latching)
            said |= {word + channel: holds for channel, holds in well.items()}
        for name in said.keys() - self._wanted:
            del said[name]
        return said
