"""An output that is registers: what is to be written to it, and what is known of it. Pure: time is an argument."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import NamedTuple

from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.signals import Value

GIVE_UP_US = 1_000_000
"""An activation that no device has acknowledged so long after it was commanded is not done any more."""
RETRY_US = 100_000
"""Between two attempts of one write: the answers to some reads come in between, so that a late one is noise."""
DOUBT_US = 500_000
"""What stands otherwise for so long is told."""
LEAST_FRESH_US, FRESH_PERIODS = 150_000, 3


def fresh_for_us(period_us: int) -> int:
    """How long what a device reports counts on a bus that is read with this period."""
    return max(LEAST_FRESH_US, FRESH_PERIODS * period_us)


class Row(NamedTuple):
    """Registers that are to be written in one request."""

    address: int
    values: tuple[int, ...]


class Awaited(NamedTuple):
    """A bit that the device must show, later than what was written last; ``late``: what it means if it does not."""

    channel: str
    level: bool
    late: str


NOT_READY = "the device was not activated in time"


class BusOutput:
    """One output: what it was told, what is still to be done, what the device reports of it.

    Args:
        name: of the output.
        stanza: of the description.
        fresh_us: how long a report counts.
    """

    def __init__(self, name: str, stanza: RegisterOutput, fresh_us: int) -> None:
        self.name, self.stanza, self._fresh_us = name, stanza, fresh_us
        self.level: bool | None = None
        """As it was commanded; None: nobody has, since the start."""
        self.retry_at = 0
        self.alone = False
        """Whether it is written by itself: together with its neighbours it was not acknowledged."""
        self.why = ""
        """Why the last command was given up, a clause; empty: it was not."""
        self.refusal = ""
        """With which exception the device refused what was written last, in words; empty: it did not."""
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
        self._give_up_at: int | None = None
        self._commanded_at = self._progress_at = self._written_at = 0
        self._reports: dict[str, tuple[bool, int, int]] = {}

    @property
    def pending(self) -> bool:
        """Whether something of the last command is not done yet."""
        return bool(self._steps) or self._undecided

    def command(self, level: bool, at: int, *, drop: bool = False) -> None:
        """What it is to be from now on; what was still to be done is forgotten.

        ``drop``: a person asked for this release. It may acknowledge and activate the device first.
        """
        self._doubtful = self.level is not True or self.known(at) is not True
        self._was_off, self._waits = self.known(at) is False, False
        self._drop = drop and not level
        # not before a late answer to the write before would be noise
        self.level, self.why, self.retry_at = level, "", max(self.retry_at, at)
        self._commanded_at = self._progress_at = at
        self.alone = self._repeats = False
        self.refusal = ""
        self._sent = None  # the device may have restarted since, and have lost what it had
        activation, handshake = self.stanza.activation, self.stanza.handshake
        # a command that would activate the device is not written before that shows that it is active
        asks = level or self._drop or self._activates
        self._undecided = (activation is not None and asks) or (self._drop and bool(self.stanza.acknowledge))
        limit_s = activation.ready_within_s if activation else 0.0
        limit_s += handshake.within_s * (2 if activation else 1) if handshake else 0.0
        # what shall release does so, however late; but it activates nothing late
        ends = level or (self._drop and activation is not None)
        self._give_up_at = at + GIVE_UP_US + round(limit_s * 1e6) if ends else None
        self._steps = deque([] if self._undecided else self._told(level))

    def may_hold(self, at: int) -> bool:
        """Whether it may hold a part that nobody has asked it to release."""
        return self.level is True or (self.level is None and self.known(at) is not False)

    def acknowledge(self, at: int) -> None:
        """A fault of the device is cleared; nothing of it may hold a part."""
        if self.stanza.acknowledge is None:
            return
        self._commanded_at = self._progress_at = at
        # a device with a fault may not have obeyed a release
        self._drop, self._undecided = False, self.level is False and self._activates
        off = self._told(level=False) if self.level is False and not self._undecided else []
        self._steps = deque([*self._clears, *off])

    def report(self, values: Mapping[str, Value], at: int, asked_at: int) -> None:
        """What the channels of the bus show at ``at``; it was asked for from ``asked_at`` on, by several reads."""
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
        """The last report of a bit; None: there is no fresh one."""
        value, when, _ = self._reports.get(channel or "", (None, 0, 0))
        return value if at - when <= self._fresh_us else None

    @property
    def begins(self) -> bool:
        """Whether it was inactive, and nothing of its activation is done yet."""
        return self._undecided and self._was_off

    @property
    def activates(self) -> bool:
        """Whether the activation of its device is under way."""
        return any(isinstance(step, Awaited) and step.late == NOT_READY for step in self._steps)

    def advance(self, at: int, *, others_may_hold: bool, is_activated: bool) -> None:
        """Time has come to ``at``.

        Args:
            at: µs.
            others_may_hold: another output of the unit is active, or may be.
            is_activated: another output of the unit has begun an activation that is under way.
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
        """An activation that is not done yet is not done any more; what the device has done of it stays."""
        if self._may_activate and not self.why:
            self._give_up(why)

    def lasts(self, at: int) -> bool:
        """Whether an activation has been under way for longer than one write takes."""
        return self._may_activate and not self.why and at - self._commanded_at > RETRY_US

    def next_row(self, at: int) -> Row | None:
        """What is to be written now."""
        step = self._steps[0] if self._steps else None
        return step if isinstance(step, Row) and at >= self.retry_at else None

    def sent(self, row: Row) -> None:
        """It is on its way."""
        handshake = self.stanza.handshake
        self._sent = row
        self._open = self._open or (handshake is not None and row == self._control(handshake.request))

    def acknowledged(self, at: int) -> None:
        """The device has done what was sent last."""
        if self._sent is not None and self._steps and self._steps[0] == self._sent:
            self._steps.popleft()
            self._progress_at = self._written_at = at
            self.alone = False

    def known(self, at: int) -> bool | None:
        """Its level, as far as command and device agree; None: nobody knows how it stands."""
        seen = self.reported(self.stanza.verify, at)
        if self.level is None:
            return seen
        # what it showed before it acknowledged the last write says nothing against that
        newer = seen is not None and self._is_answer(self.stanza.verify or "")
        if self.pending or self.why or (newer and seen != self.level):
            return None
        return self.level

    def trouble(self, at: int) -> str:
        """What is wrong with it, a clause; empty: nothing that has lasted."""
        if self.level is None:
            return ""
        if self.why:
            return f"was not activated: {self.why}"
        if self.pending:
            return self._lateness(at)
        if at - self._progress_at <= DOUBT_US:
            return ""
        activation = self.stanza.activation
        if self.level and activation and self.reported(activation.ready, at) is False:
            return "is not activated any more: its device was restarted, or has a fault"
        if self.reported(self.stanza.verify, at) is (not self.level):
            told = "active" if self.level else "inactive"
            return f"was commanded {told}, and its device does not say so: it was restarted, or somebody else writes"
        return ""

    @property
    def due(self) -> int | None:
        """When `advance` or the next write is due."""
        times = [self.retry_at] if self._steps and isinstance(self._steps[0], Row) else []
        times += [self._give_up_at] if self._give_up_at is not None and self.pending else []
        return min(times, default=None)

    @property
    def _may_activate(self) -> bool:
        """Whether something of the last command that is not done yet may activate."""
        may = bool(self.level) or (self._drop and self.stanza.activation is not None)
        return self.pending and may

    @property
    def _is_told(self) -> bool:
        """Whether a command is still to be written."""
        commands = self.stanza.command_on, self.stanza.command_off
        return any(isinstance(step, Row) and step.values in commands for step in self._steps)

    @property
    def _clears(self) -> list[Row]:
        """What clears a fault of the device."""
        return [Row(self.stanza.address, row) for row in self.stanza.acknowledge or ()]

    def _ready(self, at: int) -> bool | None:
        """Whether the device is activated, as far as it needs that; None: it has not said so lately."""
        activation = self.stanza.activation
        return self.reported(activation.ready, at) if activation else True

    def _decide(self, *, ready: bool, others_may_hold: bool, is_activated: bool) -> None:
        """What comes before the command, as the device is now; a release that must not activate it waits."""
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
        """Whether a report was asked for after the last write: what was read before it says nothing of it."""
        return self._reports[channel][2] > self._written_at

    def _told(self, level: bool) -> list[Row | Awaited]:
        """The steps that make it so."""
        command = Row(self.stanza.address, self.stanza.command_on if level else self.stanza.command_off)
        handshake = self.stanza.handshake
        if handshake is None:
            return [command]
        end: list[Row | Awaited] = [
            self._control(handshake.end),
            Awaited(handshake.taken, False, "the device did not end the handshake in time"),
        ]
        taken = Awaited(handshake.taken, True, "the device did not take it in time")
        shaken = [*(end if self._open else []), self._control(handshake.request), taken, *end]
        return [*shaken, command] if handshake.order == "before" else [command, *shaken]

    def _control(self, values: tuple[int, ...]) -> Row:
        """The registers of its handshake with these values."""
        own = self.stanza.handshake.address if self.stanza.handshake else None
        return Row(self.stanza.address if own is None else own, values)

    def _look(self, at: int) -> None:
        """What the device shows ends what is awaited; a release whose handshake takes too long begins again."""
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
        return f"is to be {'activated' if self.level else 'deactivated'}, and {why}"

    def _give_up(self, why: str) -> None:
        self._give_up_at = None
        if not self.level:  # it is released as soon as that activates nothing
            self._drop, self._undecided = False, True
            self._steps.clear()
            return
        self.why, self._undecided = why, False
        handshake = self.stanza.handshake
        # or the device would take later what was asked of it
        self._steps = deque([self._control(handshake.end)] if handshake and self._open else [])
