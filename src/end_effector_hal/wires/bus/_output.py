"""An output that consists of registers: its pending writes and its known state. Pure: time is an argument."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import NamedTuple

from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.signals import Value

GIVE_UP_US = 1_000_000
"""Time after which an activation without acknowledgement is given up, µs."""
RETRY_US = 100_000
"""Time between two attempts of one write, µs; reads in between ensure that a late answer is discarded as noise."""
DOUBT_US = 500_000
"""Time after which a pending or contradicted command is reported as trouble, µs."""
LEAST_FRESH_US, FRESH_PERIODS = 150_000, 3


def fresh_for_us(period_us: int) -> int:
    """Return how long a device's report is valid on a bus that is read with this period, µs."""
    return max(LEAST_FRESH_US, FRESH_PERIODS * period_us)


class Row(NamedTuple):
    """Registers that are written in one request."""

    address: int
    values: tuple[int, ...]


class Awaited(NamedTuple):
    """A bit that the device must report after the last write; ``late``: the reason to give if it does not."""

    channel: str
    level: bool
    late: str


LAST = 2**63 - 1
"""A time after all others, µs."""
NOT_READY = "the device was not activated in time"
MOST_LATE_US, LATE_FOR_US = 400_000, 10_000_000
"""Longest delay of an activation after a release that was acknowledged late (after a longer one the bus was lost), and
the time after which that release no longer delays any.
"""


class BusOutput:
    """One output: its command, its pending steps, and the reports of its device.

    Args:
        name: the name of the output.
        stanza: its stanza in the description.
        fresh_us: how long a report is valid.
    """

    def __init__(self, name: str, stanza: RegisterOutput, fresh_us: int) -> None:
        self.name, self.stanza, self._fresh_us = name, stanza, fresh_us
        self.gripping = stanza.command_on
        """The values that make it grip; not those of a bitmask, which depend on no part."""
        self.level: bool | None = None
        """The commanded level; None: no command since the start."""
        self.turn = 0
        """Number of the last command: outputs of one unit are written in the order of their commands."""
        self.retry_at = 0
        self.refused = False
        """Whether the device refused the last write for good; other outputs of the unit then need not wait for it."""
        self.in_vain = 0
        """Number of attempts of the last command that failed although the unit answered its reads."""
        self.alone = False
        """Whether the output is written without its neighbours, because the joint write was not acknowledged."""
        self.why = ""
        """Why the last command was given up, a clause; empty: it was not given up."""
        self.refusal = ""
        """The exception with which the device refused the last write, in words; empty: it did not refuse."""
        self._steps: deque[Row | Awaited] = deque()
        self._sent: Row | None = None  # of the last command; its answer is awaited
        self._undecided = False  # whether the device must be activated first is not known yet
        self._drop = False  # the last command is a Drop: it may acknowledge and activate the device first
        self._doubtful = False  # it was not known to grip as it was commanded, before the last command
        self._was_off = False  # before the last command
        self._waits = False  # for an activation of its device that another output has begun
        self._open = stanza.handshake is not None  # a handshake may have begun and not ended
        self._repeats = False  # a handshake of this command has begun again
        self._activates = stanza.commands_activate
        self._ends = [Row(*each) for each in stanza.rests]
        # of a pulse; also at the start: an earlier master may have begun one
        self._resting = deque(self._ends if stanza.pulse_s is not None else [])
        self._pulses = (
            False  # a command of the pulsed output may have reached the device, and its end has not
        )
        self._quiet_until = 0  # the end of the pulse, or of the pause after it
        self._ordered_at = 0  # of the last command, also where a reset writes it once more
        self._follows: dict[str, int] = {}  # times before which it is not written, by earlier releases
        self._give_up_at: int | None = None
        self._commanded_at = self._progress_at = self._written_at = self._late_us = 0
        self._reports: dict[str, tuple[bool, int, int]] = {}

    @property
    def pending(self) -> bool:
        """Whether a part of the last command is still to be done."""
        return bool(self._steps) or self._undecided

    @property
    def rests(self) -> bool:
        """Whether a pulse is to be ended next."""
        return bool(self._resting)

    @property
    def owed(self) -> bool:
        """Whether a deactivation was commanded that the device has not acknowledged."""
        return self.level is False and self.pending

    @property
    def waits_for_device(self) -> bool:
        """Whether the command is not done by writing alone: a report of the device must come in between."""
        return self._undecided or any(isinstance(step, Awaited) for step in self._steps)

    @property
    def shakes_us(self) -> int:
        """How long a handshake may take, µs; 0: the output needs none."""
        return round(self.stanza.handshake.within_s * 1e6) if self.stanza.handshake else 0

    def command(self, level: bool, at: int, *, drop: bool = False, given_at: int | None = None) -> None:
        """Set the wanted level; the pending steps of an earlier command are discarded.

        ``drop``: a person asked for this release. The device may be acknowledged and activated first. ``given_at``:
        when the command was given first, if that was to an earlier arbiter.
        """
        self._doubtful = self.level is not True or self.known(at) is not True
        self._was_off, self._waits = self.known(at) is False, False
        self._drop = drop and not level
        # not before a late answer to the write before would be noise, nor sooner after a late release than commanded
        self.level, self.why, self.retry_at = (
            level,
            "",
            max(self.retry_at, at + (self._late_us if level and at - self._written_at < LATE_FOR_US else 0)),
        )
        self._commanded_at = self._progress_at = at
        self._ordered_at = at if given_at is None else min(given_at, at)
        self._follows = {}
        self.alone = self._repeats = self.refused = False
        self.refusal, self.in_vain = "", 0
        self._sent = None  # the device may have restarted since, and have lost what it had
        self._end_pulse()
        activation, handshake = self.stanza.activation, self.stanza.handshake
        # a command that would activate the device is not written before that shows that it is active
        asks = level or self._drop or self._activates
        self._undecided = (activation is not None and asks) or (self._drop and bool(self.stanza.acknowledge))
        limit_s = activation.ready_within_s if activation else 0.0
        limit_s += handshake.within_s * (2 if activation else 1) if handshake else 0.0
        limit_s += (self.stanza.pulse_s or 0) + (self.stanza.pause_s or 0)  # of the command before
        # what shall release does so, however late; but it activates nothing late
        ends = level or (self._drop and activation is not None)
        self._give_up_at = at + GIVE_UP_US + round(limit_s * 1e6) if ends else None
        self._steps = deque([] if self._undecided else self._told(level))

    def may_hold(self, at: int) -> bool:
        """Return whether the output may hold a part that no command has released."""
        return self.level is True or (self.level is None and self.known(at) is not False)

    def acknowledge(self, at: int) -> None:
        """Clear a fault of the device; call this only if none of its outputs may hold a part."""
        if self.stanza.acknowledge is None:
            return
        self._commanded_at = self._progress_at = at
        # a device with a fault may not have obeyed a release
        self._drop, self._undecided = False, self.level is False and self._activates
        off = self._told(level=False) if self.level is False and not self._undecided else []
        self._steps = deque([*self._clears, *off])

    def report(self, values: Mapping[str, Value], at: int, asked_at: int) -> None:
        """Record the channels of the bus as read at ``at``; several reads requested them, the first at ``asked_at``."""
        stanza = self.stanza
        ready, taken = (
            stanza.activation and stanza.activation.ready,
            stanza.handshake and stanza.handshake.taken,
        )
        for channel in (stanza.verify, ready, taken):
            value = values.get(channel) if channel else None
            if channel and isinstance(value, bool):
                self._reports[channel] = value, at, asked_at

    def reported(self, channel: str | None, at: int) -> bool | None:
        """Return the last report of a bit; None: there is no fresh one."""
        value, when, _ = self._reports.get(channel or "", (None, 0, 0))
        return value if at - when <= self._fresh_us else None

    @property
    def begins(self) -> bool:
        """Whether the output was inactive, and no step of its activation is done yet."""
        return self._undecided and self._was_off

    @property
    def activates(self) -> bool:
        """Whether the activation of its device is in progress."""
        return any(isinstance(step, Awaited) and step.late == NOT_READY for step in self._steps)

    def advance(self, at: int, *, others_may_hold: bool, is_activated: bool) -> None:
        """Process the passing of time.

        Args:
            at: the time now, µs.
            others_may_hold: another output of the unit is or may be active.
            is_activated: another output of the unit has begun an activation that is in progress.
        """
        if self._give_up_at is not None and self.pending and at >= self._give_up_at:
            step = self._steps[0] if self._steps else None
            unheard = (
                f"its device refused it with {self.refusal}" if self.refusal else "no device acknowledged it"
            )
            late = step.late if isinstance(step, Awaited) else unheard
            self._give_up(NOT_READY if self.activates else late)
        self._look(at)
        ready = self._ready(at)
        if (
            ready is False
            and self._activates
            and self._is_told
            and not (self.activates or self._undecided or self.why)
        ):
            # it was restarted since: what is still to be written would activate it
            self._undecided, self._sent = True, None
            self._steps.clear()
        if self._undecided and (ready is not None or not (self.level or self._activates)):
            self._decide(ready=ready is not False, others_may_hold=others_may_hold, is_activated=is_activated)

    def withdraw(self, why: str) -> None:
        """Cancel an activation that is not done yet; steps that the device has executed are not undone."""
        if self._may_activate and not self.why:
            self._give_up(why)

    def lasts(self, at: int) -> bool:
        """Return whether an activation has been in progress for longer than one write takes."""
        return self._may_activate and not self.why and at - self._commanded_at > RETRY_US

    def reopened(self, at: int) -> None:
        """Record that the port is open again: what is pending is due now, after a pulse or pause that is not over."""
        self.retry_at = max(at, self._quiet_until)

    def next_row(self, at: int) -> Row | None:
        """Return the registers to write now; None: nothing."""
        step = self._resting[0] if self._resting else self._steps[0] if self._steps else None
        return step if isinstance(step, Row) and at >= self.due_at else None

    @property
    def due_at(self) -> int:
        """The time, µs, before which nothing is written; the end of a pulse follows no other output."""
        return self.retry_at if self.rests else max([self.retry_at, *self._follows.values()])

    def sent(self, row: Row) -> None:
        """Record that a row was sent."""
        handshake = self.stanza.handshake
        self._sent = row
        self._pulses = self._pulses or (self.stanza.pulse_s is not None and row not in self._ends)
        self._open = self._open or (handshake is not None and row == self._control(handshake.request))

    def acknowledged(self, at: int) -> None:
        """Record that the device has acknowledged the last write."""
        if self._resting and self._sent == self._resting[0]:
            self._resting.popleft()
            self.alone, self.refused, self.in_vain = False, False, 0
            if not self._resting:
                self._pulses = False
                self._be_quiet(at, self.stanza.pause_s)
        elif self._sent is not None and self._steps and self._steps[0] == self._sent:
            self._steps.popleft()
            self._progress_at = self._written_at = at
            self.alone, self.refused, self.in_vain = False, False, 0
            late_us = min(at - self._commanded_at, MOST_LATE_US)
            self._late_us = (
                0 if self.level or self.pending or self._drop else late_us
            )  # a Drop ends all attempts
            if self._pulses:
                self._end_pulse()
                self._be_quiet(at, self.stanza.pulse_s)

    def follow(self, other: BusOutput, release_us: int, at: int) -> None:
        """Keep the interval of the commands after an earlier release, which is acknowledged at ``at``.

        Releases that had to wait for a device would otherwise be written together, those of a Drop as well. No
        interval is longer than ``release_us``, which the release of the other takes.
        """
        if self.owed and self.turn > other.turn:
            self._follows[other.name] = at + min(self._ordered_at - other._ordered_at, release_us)

    def failed(self, at: int) -> None:
        """Record that the last write was not acknowledged: it is repeated.

        The device may have it all the same. So a pulse and its end follow each other also then, until both are
        acknowledged: no coil stays active, and a release is done by a device that cannot be heard. Of two coils that
        are written one after the other, none becomes active before the other one is known to be inactive: the command
        begins again, after a pulse whose end is acknowledged.
        """
        self.retry_at, pair = at + RETRY_US, self.stanza.opposite is not None
        if pair and self._steps:
            self._steps = deque(self._told(bool(self.level)))
        if not self._pulses:
            return
        if self._sent not in self._ends:
            self._end_pulse()
            self._be_quiet(self.retry_at, self.stanza.pulse_s)
        elif pair:  # its other coil next, which may be the active one
            self._end_pulse()
            self._resting.rotate(self._resting[0] == self._sent)
        elif self.pending:
            self._resting.clear()
            self._be_quiet(self.retry_at, self.stanza.pause_s)

    def known(self, at: int) -> bool | None:
        """Return the level if command and device agree; None: the state is unknown."""
        seen = self.reported(self.stanza.verify, at)
        if self.level is None:
            return seen
        # what it showed before it acknowledged the last write says nothing against that
        newer = seen is not None and self._is_answer(self.stanza.verify or "")
        if self.pending or self.why or (newer and seen != self.level):
            return None
        return self.level

    def was_inactive(self, since: int, at: int) -> bool:
        """Return whether the output has been inactive since then; without a command only a report can deny it."""
        if self.level is None:
            return self.known(at) is not True
        return self.known(at) is False and self._written_at < since

    def bits(self, at: int) -> int | None:
        """Return the bits of an output with a bitmask for a write of its neighbours; None: they are not known.

        They are those of a command that is due (a release always is), else the output stays as it is.
        """
        if (row := self.next_row(at if self.level else LAST)) is not None:
            return row.values[0]
        seen = self.reported(self.stanza.verify, at)
        if self.level is not None and not (seen is not None and self._is_answer(self.stanza.verify or "")):
            seen = None if self.why or self.pending else self.level
        return None if seen is None else self.stanza.values(seen)[0]

    def trouble(self, at: int) -> str:
        """Return the trouble of the output, a clause; empty: there is none that has lasted."""
        if self.level is None:
            return ""
        if self.why:
            return f"was not activated: {self.why}"
        if self.pending:
            return self._lateness(at)
        if self._pulses and at - max(self._progress_at, self._quiet_until) > DOUBT_US:
            return "was pulsed, and no device acknowledges the end of the pulse: its coil may still be active"
        if at - self._progress_at <= DOUBT_US:
            return ""
        activation = self.stanza.activation
        if self.level and activation and self.reported(activation.ready, at) is False:
            return "is not activated any more: its device was restarted, or has a fault"
        if self.reported(self.stanza.verify, at) is (not self.level):
            told = "active" if self.level else "inactive"
            why = "it was restarted, or another program writes to it"
            return f"was commanded {told}, but its device reports otherwise: {why}"
        return ""

    @property
    def gives_up_at(self) -> int | None:
        """The time at which `advance` gives up the pending command; None: never."""
        return self._give_up_at if self.pending else None

    def _end_pulse(self) -> None:
        """End a pulse that may have begun next: all of it, if a part of that is done."""
        if self._pulses:
            self._resting = deque(self._ends)

    def _be_quiet(self, at: int, seconds: float | None) -> None:
        """Write nothing for some time: while a pulse is active, or during the pause after it."""
        self.retry_at = self._quiet_until = at + round((seconds or 0) * 1e6)

    @property
    def _may_activate(self) -> bool:
        """Whether a pending step of the last command may activate the output or its device."""
        may = bool(self.level) or (self._drop and self.stanza.activation is not None)
        return self.pending and may

    @property
    def _is_told(self) -> bool:
        """Whether a command still has to be written."""
        commands = self._values(level=True), self._values(level=False)
        return any(isinstance(step, Row) and step.values in commands for step in self._steps)

    @property
    def _clears(self) -> list[Row]:
        """The rows that clear a fault of the device."""
        return [Row(self.stanza.address, row) for row in self.stanza.acknowledge or ()]

    def _ready(self, at: int) -> bool | None:
        """Return whether the device is activated (True if it needs no activation); None: there is no fresh report."""
        activation = self.stanza.activation
        return self.reported(activation.ready, at) if activation else True

    def _decide(self, *, ready: bool, others_may_hold: bool, is_activated: bool) -> None:
        """Choose the steps before the command by the present state of the device; a release that must not activate it
        waits.
        """
        if not ready and is_activated and (not self.level or self.begins):
            self._waits = bool(self.level)
            return
        clears = self._clears if self._drop and (self._doubtful or not ready) and not others_may_hold else []
        prepares = not ready and (bool(self.level) or (self._drop and not others_may_hold))
        if not ready and not prepares and self._activates:
            return
        self._undecided = False
        if prepares and others_may_hold:
            self._give_up("the device must be activated, and another actuator of it may hold a part")
            return
        activation = self.stanza.activation
        if prepares and activation is not None:
            start = self.stanza.address if activation.address is None else activation.address
            self._steps.extend([*clears, *(Row(start, row) for row in activation.write)])
            self._steps.append(Awaited(activation.ready, True, NOT_READY))
        else:
            self._steps.extend(clears)
        off_first = bool(self.level) and (not ready or self._waits)
        self._steps.extend([*(self._told(level=False) if off_first else []), *self._told(bool(self.level))])

    def _is_answer(self, channel: str) -> bool:
        """Return whether a report was requested after the last write; older reports do not show its effect."""
        return self._reports[channel][2] > self._written_at

    def _told(self, level: bool) -> list[Row | Awaited]:
        """Return the steps that command this level, with the handshake around them."""
        *before, command = (Row(*each) for each in self.stanza.writes(level))
        command = command._replace(values=self._values(level)) if level else command
        handshake = self.stanza.handshake
        if handshake is None or before:
            return [*before, command]
        end: list[Row | Awaited] = [
            self._control(handshake.end),
            Awaited(handshake.taken, False, "the device did not end the handshake in time"),
        ]
        taken = Awaited(handshake.taken, True, "the device did not accept the command in time")
        shaken = [*(end if self._open else []), self._control(handshake.request), taken, *end]
        return [*shaken, command] if handshake.order == "before" else [command, *shaken]

    def _values(self, level: bool) -> tuple[int, ...]:
        return self.gripping if level and not self.stanza.bitmask else self.stanza.values(level)

    def _control(self, values: tuple[int, ...]) -> Row:
        """Return the row that writes these values to the registers of the handshake."""
        own = self.stanza.handshake.address if self.stanza.handshake else None
        return Row(self.stanza.address if own is None else own, values)

    def _look(self, at: int) -> None:
        """Complete awaited steps that the device has reported; restart a release whose handshake takes too long."""
        handshake = self.stanza.handshake
        while self._steps and isinstance(step := self._steps[0], Awaited):
            shown = self.reported(step.channel, at)
            if shown is not step.level or not self._is_answer(step.channel):
                break
            self._steps.popleft()
            self._progress_at = at
            if handshake is not None and step.channel == handshake.taken and not step.level:
                self._open = False
        else:
            return
        if handshake is not None and not self.level and at - self._written_at >= handshake.within_s * 1e6:
            self._open = self._repeats = True
            self._steps = deque(self._told(level=False))

    def _lateness(self, at: int) -> str:
        late = self._repeats or at - self._progress_at > DOUBT_US
        if not late or self.activates:
            return ""
        if self._undecided and not self.level:
            known = self._ready(at) is not None
            return (
                "is to be deactivated, and its device is not activated, so that it would not obey: a Drop or a grip "
                "activates it first"
                if known
                else "is to be deactivated, and its device does not say whether it is activated"
            )
        shakes = self._repeats or (bool(self._steps) and isinstance(self._steps[0], Awaited))
        why = "its device does not answer the handshake" if shakes else "no device acknowledges it"
        why = f"its device refuses it with {self.refusal}" if self.refusal and not shakes else why
        again = ": the release is repeated until it is acknowledged"
        return f"is to be activated, and {why}" if self.level else f"is to be deactivated, and {why}{again}"

    def _give_up(self, why: str) -> None:
        self._give_up_at = None
        if not self.level:  # it is released as soon as that activates nothing
            self._drop, self._undecided = False, True
            self._steps.clear()
            return
        self.why, self._undecided = why, False
        self._end_pulse()
        handshake = self.stanza.handshake
        # or the device would take later what was asked of it
        self._steps = deque([self._control(handshake.end)] if handshake and self._open else [])
