"""Outputs that are registers: what is to be written to them, and what is known of them. Pure: time is an argument."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping

from end_effector_hal.codecs.modbus import RegisterWrite
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.signals import Value

GIVE_UP_US = 1_000_000
"""An activation that no device has acknowledged so long after it was commanded is not done any more."""
RETRY_US = 100_000
"""Between two attempts of one write: the answers to some reads come in between, so that a late one is noise."""
LONGEST_WRITE = 100
"""Registers; the standard allows 123, and one output has at most 16."""
DOUBT_US = 500_000
"""What stands otherwise for so long is told."""
LEAST_FRESH_US, FRESH_PERIODS = 150_000, 3


def fresh_for_us(period_us: int) -> int:
    """How long what a device reports counts on a bus that is read with this period."""
    return max(LEAST_FRESH_US, FRESH_PERIODS * period_us)


class BusOutput:
    """One output: what it was told, what is still to be written, what the device reports of it.

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
        self._rows: deque[tuple[int, ...]] = deque()
        self._undecided = False  # whether the device must be activated first is not known yet
        self._was_off = False  # before the last command
        self._waits = False  # for an activation of its device that another output has begun
        self._awaits_ready: int | None = None  # reported after this time, µs
        self._give_up_at: int | None = None
        self._commanded_at = self._progress_at = 0
        self._reports: dict[str, tuple[bool, int]] = {}

    @property
    def pending(self) -> bool:
        """Whether something of the last command is not done yet."""
        return bool(self._rows) or self._undecided or self._awaits_ready is not None

    def command(self, level: bool, at: int) -> None:
        """What it is to be from now on; what was still to be written is forgotten."""
        self._was_off, self._waits = self.known(at) is False, False
        # not before a late answer to the write before would be noise
        self.level, self.why, self.retry_at = level, "", max(self.retry_at, at)
        self._commanded_at = self._progress_at = at
        self.alone = False
        self._rows.clear()
        self._awaits_ready = None
        activation = self.stanza.activation
        self._undecided = level and activation is not None
        limit_us = GIVE_UP_US + (round(activation.ready_within_s * 1e6) if activation else 0)
        self._give_up_at = at + limit_us if level else None  # what shall release does so, however late
        if not self._undecided:
            self._rows.append(self.stanza.command_on if level else self.stanza.command_off)

    def report(self, values: Mapping[str, Value], at: int) -> None:
        """What the channels of the bus show at ``at``."""
        activation = self.stanza.activation
        for channel in (self.stanza.verify, activation and activation.ready):
            value = values.get(channel) if channel else None
            if channel and isinstance(value, bool):
                self._reports[channel] = value, at

    def reported(self, channel: str | None, at: int) -> bool | None:
        """The last report of a bit; None: there is no fresh one."""
        value, when = self._reports.get(channel or "", (None, 0))
        return value if at - when <= self._fresh_us else None

    @property
    def begins(self) -> bool:
        """Whether it was inactive, and nothing of its activation is done yet."""
        return self._undecided and self._was_off

    @property
    def activates(self) -> bool:
        """Whether the activation of its device is under way."""
        return self._awaits_ready is not None

    def advance(self, at: int, *, others_may_hold: bool, is_activated: bool) -> None:
        """Time has come to ``at``.

        Args:
            at: µs.
            others_may_hold: another output of the unit is active, or may be.
            is_activated: another output of the unit has begun an activation that is under way.
        """
        activation = self.stanza.activation
        if self._give_up_at is not None and self.pending and at >= self._give_up_at:
            not_ready = self._awaits_ready is not None
            self._give_up(
                "the device was not activated in time" if not_ready else "no device acknowledged it"
            )
        if activation is None:
            return
        ready = self.reported(activation.ready, at)
        if self._undecided and ready is not None:
            if not ready and is_activated and self.begins:
                self._waits = True
                return
            self._undecided = False
            if ready:
                self._rows.extend((self.stanza.command_off, self.stanza.command_on)[not self._waits :])
            elif others_may_hold:
                self._give_up("the device must be activated, and another actuator of it may hold a part")
            else:
                self._rows.extend(activation.write)
                self._awaits_ready = NEVER
        awaited = self._awaits_ready
        if awaited is not None and not self._rows and ready and self._reports[activation.ready][1] > awaited:
            self._awaits_ready, self._progress_at = None, at
            self._rows.extend((self.stanza.command_off, self.stanza.command_on))

    def withdraw(self, why: str) -> None:
        """An activation that is not done yet is not done any more; what the device has done of it stays."""
        if self.level and self.pending:
            self._give_up(why)

    def lasts(self, at: int) -> bool:
        """Whether an activation has been under way for longer than one write takes."""
        return bool(self.level) and self.pending and at - self._commanded_at > RETRY_US

    def next_row(self, at: int) -> tuple[int, ...] | None:
        """What is to be written now."""
        return self._rows[0] if self._rows and at >= self.retry_at else None

    def acknowledged(self, row: tuple[int, ...], at: int) -> None:
        """The device has done it."""
        if self._rows and self._rows[0] == row:
            self._rows.popleft()
            self._progress_at, self.alone = at, False
            if self._awaits_ready is not None and not self._rows:
                self._awaits_ready = at

    def known(self, at: int) -> bool | None:
        """Its level, as far as command and device agree; None: nobody knows how it stands."""
        seen = self.reported(self.stanza.verify, at)
        if self.level is None:
            return seen
        if self.pending or self.why or (seen is not None and seen != self.level):
            return None
        return self.level

    def trouble(self, at: int) -> str:
        """What is wrong with it, a clause; empty: nothing that has lasted."""
        if self.level is None:
            return ""
        if self.why:
            return f"was not activated: {self.why}"
        if self.pending:
            what = "activated" if self.level else "deactivated"
            late = at - self._progress_at > DOUBT_US and self._awaits_ready is None
            return f"is to be {what}, and no device acknowledges it" if late else ""
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
        times = [self.retry_at] if self._rows else []
        times += [self._give_up_at] if self._give_up_at is not None and self.pending else []
        return min(times, default=None)

    def _give_up(self, why: str) -> None:
        self.why, self._undecided, self._awaits_ready = why, False, None
        self._rows.clear()


NEVER = 2**63 - 1


class BusOutputs:
    """All outputs of one bus.

    Args:
        stanzas: by the name of the output.
        fresh_us: how long what a device reports counts.
    """

    def __init__(self, stanzas: Mapping[str, RegisterOutput], fresh_us: int) -> None:
        self._outputs = {name: BusOutput(name, each, fresh_us) for name, each in stanzas.items()}

    def command(self, levels: Mapping[str, bool], at: int) -> None:
        """These levels, from now on."""
        for name, level in levels.items():
            self._outputs[name].command(level, at)

    def report(self, values: Mapping[str, Value], at: int) -> None:
        """What the channels of the bus show."""
        for each in self._outputs.values():
            each.report(values, at)

    def advance(self, at: int) -> None:
        """Time has come to ``at``."""
        for each in self._outputs.values():
            of_unit = [other for other in self._outputs.values() if other.stanza.unit == each.stanza.unit]
            others = [other for other in of_unit if other is not each]
            each.advance(
                at,
                others_may_hold=any(not o.begins and o.known(at) is not False for o in others),
                is_activated=any(other.activates for other in others),
            )

    def next_write(self, at: int) -> RegisterWrite | None:
        """What is to be written now; registers of one unit that stand side by side are written together."""
        self.advance(at)
        due = [each for each in self._outputs.values() if each.next_row(at) is not None]
        if not due:
            return None
        # or a device that is dead would keep the others waiting
        first = min(due, key=lambda each: each.retry_at)
        return self._together(first, first.next_row(at) or (), at)

    def acknowledged(self, write: RegisterWrite, at: int) -> None:
        """A device has done it."""
        for each, row in self._rows_of(write):
            each.acknowledged(row, at)

    def failed(self, write: RegisterWrite, at: int) -> None:
        """It was refused, or not acknowledged."""
        failed = [each for each, _ in self._rows_of(write)]
        for each in failed:
            each.retry_at, each.alone = at + RETRY_US, each.alone or len(failed) > 1

    def withdraw(self, names: Iterable[str], why: str) -> None:
        """Activations of these that are not done yet are not done any more."""
        for name in self._outputs.keys() & set(names):
            self._outputs[name].withdraw(why)

    def activating(self, at: int) -> frozenset[str]:
        """Those whose activation has been under way for longer than one write takes."""
        return frozenset(name for name, each in self._outputs.items() if each.lasts(at))

    def known(self, at: int) -> dict[str, bool]:
        """The levels of those of which somebody knows how they stand."""
        found = {name: each.known(at) for name, each in self._outputs.items()}
        return {name: level for name, level in found.items() if level is not None}

    def troubles(self, at: int) -> dict[str, str]:
        """What is wrong, a clause by output."""
        found = {name: each.trouble(at) for name, each in self._outputs.items()}
        return {name: why for name, why in found.items() if why}

    @property
    def pending(self) -> bool:
        """Whether a command is not done yet."""
        return any(each.pending for each in self._outputs.values())

    @property
    def due(self) -> int | None:
        """When `next_write` is to be asked at the latest."""
        return min((each.due for each in self._outputs.values() if each.due is not None), default=None)

    def _together(self, first: BusOutput, row: tuple[int, ...], at: int) -> RegisterWrite:
        """With the rows of others that stand right before or behind it and are due as well."""
        ready = {
            (each.stanza.unit, each.stanza.register_type, each.stanza.address): other
            for each in self._outputs.values()
            if (other := each.next_row(at)) is not None
            and len(other) == len(each.stanza.command_on)
            and not each.alone
        }
        unit, table, address = first.stanza.unit, first.stanza.register_type, first.stanza.address
        if len(row) == len(first.stanza.command_on) and not first.alone:
            ends = {(*key[:2], key[2] + len(row)): (key[2], row) for key, row in ready.items()}
            while (before := ends.get((unit, table, address))) and len(row) < LONGEST_WRITE:
                address, row = before[0], before[1] + row
            while (behind := ready.get((unit, table, address + len(row)))) and len(row) < LONGEST_WRITE:
                row += behind
        return RegisterWrite(unit, address, row, table == "coil")

    def _rows_of(self, write: RegisterWrite) -> Iterable[tuple[BusOutput, tuple[int, ...]]]:
        """The outputs that a write was made of, with the part of each."""
        for each in self._outputs.values():
            row = each.next_row(NEVER)
            start = each.stanza.address - write.address
            same = (each.stanza.unit, each.stanza.register_type == "coil") == (write.unit, write.coils)
            if row and same and start >= 0 and write.values[start : start + len(row)] == row:
                yield each, row
