"""All outputs of a bus: chooses the next write, and the outputs that are written together. Pure: time is an
argument.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from end_effector_hal.codecs.modbus import RegisterWrite
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.signals import Value

from ._output import LAST, BusOutput, Row

LONGEST_WRITE = 100
"""Most registers in one write; the standard allows 123, and one output has at most 16."""
MOST_IN_VAIN = 50
"""Attempts (of 0.1 s) of a unit that answers its reads, after which releases of its other outputs do not wait."""


class BusOutputs:
    """All outputs of one bus.

    Args:
        stanzas: their parts of the description, by name.
        fresh_us: how long the report of a device is valid.
        release_us: how long the release of an output takes, µs, by its name; default: no time.
    """

    def __init__(
        self,
        stanzas: Mapping[str, RegisterOutput],
        fresh_us: int,
        release_us: Mapping[str, int] = MappingProxyType({}),
    ) -> None:
        self._outputs = {name: BusOutput(name, each, fresh_us) for name, each in stanzas.items()}
        self._release_us = release_us
        every = self._outputs.values()
        # looked for once: a bus may have many outputs, and each of its requests asks for them
        self._neighbours = {
            each.name: [o for o in every if o is not each and o.stanza.unit == each.stanza.unit]
            for each in every
        }
        self._drops = set[str]()
        self._gripping: dict[str, tuple[int, ...]] = {}
        self._given: dict[str, int] = {}
        self._sent: list[BusOutput] = []  # those of the write that is on its way
        self._heard = frozenset[int]()  # the units that answered a read of the last cycle
        self._commands = self._now = 0

    def prepare(
        self,
        names: Iterable[str],
        values: Mapping[str, tuple[int, ...]],
        given: Mapping[str, int] = MappingProxyType({}),
    ) -> None:
        """See `RemoteLines.prepare`."""
        mine = self._outputs.keys()
        self._drops |= mine & set(names)
        self._gripping |= {name: values[name] for name in mine & values.keys()}
        self._given |= {name: given[name] for name in mine & given.keys()}

    def command(self, levels: Mapping[str, bool], at: int) -> None:
        """Set the wanted levels of some outputs."""
        self._commands += 1
        for name, level in levels.items():
            self._outputs[name].turn = self._commands
            if level:  # those of an earlier part are not written again
                own = self._outputs[name].stanza.command_on
                self._outputs[name].gripping = self._gripping.pop(name, own)
            given_at = self._given.pop(name, at)
            self._outputs[name].command(level, at, drop=name in self._drops, given_at=given_at)
        self._drops -= levels.keys()

    def report(self, values: Mapping[str, Value], at: int, asked_at: int) -> None:
        """Record the channels of the bus; see `BusOutput.report`."""
        for each in self._outputs.values():
            each.report(values, at, asked_at)

    def heard(self, units: frozenset[int]) -> None:
        """Record the units that answered a read of the last cycle."""
        self._heard = units
        for each in self._outputs.values():
            each.in_vain = each.in_vain if each.stanza.unit in units else 0

    def advance(self, at: int) -> None:
        """Process the passing of time up to ``at``."""
        self._now = at
        for each in self._outputs.values():
            others = self._others(each)
            each.advance(
                at,
                others_may_hold=any(
                    not o.begins and o.known(at) is not False if each.level else o.may_hold(at)
                    for o in others
                ),
                is_activated=any(other.activates for other in others),
            )

    def acknowledge(self, at: int) -> None:
        """Clear the faults of the devices at a reset, where the description says how and no output of the unit may
        hold a part.
        """
        for each in self._outputs.values():
            if not any(other.may_hold(at) for other in (each, *self._others(each))):
                each.acknowledge(at)

    def next_write(self, at: int) -> RegisterWrite | None:
        """Return the next write, None: nothing is due; adjacent registers of one unit are written together."""
        self.advance(at)
        due = [each for each in self._in_turn() if each.due_at <= at]
        if not due:
            return None
        # or a device that is dead would keep the others waiting
        first = min(due, key=lambda each: (each.due_at, each.turn))
        row = first.next_row(at)
        assert row is not None
        return self._together(first, row, at)

    def reopened(self, at: int) -> None:
        """Record that the port is open again: all that is pending is due now, in the order of the commands.

        A release that its device must first answer is not done at once: later ones keep their interval after its end,
        or after the time that its handshake may take.
        """
        for each in self._outputs.values():
            each.reopened(at)
            if each.owed and each.waits_for_device:
                self._followed(each, at + each.shakes_us)

    def sent(self, write: RegisterWrite) -> None:
        """Record that a write was sent."""
        rows = list(self._rows_of(write))
        self._sent = [each for each, _ in rows]
        for each, row in rows:
            each.sent(row)

    def acknowledged(self, at: int) -> None:
        """Record that the device has acknowledged the last write."""
        for each in self._sent:
            owed = each.owed
            each.acknowledged(at)
            if owed and not each.owed:
                self._followed(each, at)

    def _followed(self, released: BusOutput, at: int) -> None:
        for each in self._outputs.values():
            each.follow(released, self._release_us.get(released.name, 0), at)

    def failed(self, at: int, refusal: str = "", *, for_good: bool = False) -> None:
        """Record that the last write was not acknowledged, or was refused with an exception.

        ``for_good``: the exception says that the device will refuse the same write again.
        """
        for each in self._sent:  # also where something else is commanded by now: its answer may come late
            each.failed(at)
            each.alone = each.alone or len(self._sent) > 1
            each.refusal, each.refused = refusal, for_good
            each.in_vain += each.stanza.unit in self._heard

    def withdraw(self, names: Iterable[str], why: str) -> None:
        """Cancel the activations of these outputs that are not done yet."""
        for name in self._outputs.keys() & set(names):
            self._outputs[name].withdraw(why)

    def activating(self, at: int) -> frozenset[str]:
        """Return the outputs whose activation has been in progress for longer than one write takes."""
        return frozenset(name for name, each in self._outputs.items() if each.lasts(at))

    @property
    def owed(self) -> frozenset[str]:
        """The outputs with a deactivation that their device has not acknowledged."""
        return frozenset(name for name, each in self._outputs.items() if each.owed)

    def known(self, at: int) -> dict[str, bool]:
        """Return the known levels."""
        found = {name: each.known(at) for name, each in self._outputs.items()}
        return {name: level for name, level in found.items() if level is not None}

    def inactive(self, since: int, at: int) -> tuple[str, ...]:
        """Return the outputs that were inactive at ``since`` and still are, as far as anything shows it."""
        return tuple(name for name, each in self._outputs.items() if each.was_inactive(since, at))

    def unknown(self, at: int) -> frozenset[str]:
        """Return the outputs without a command and without a fresh report."""
        return frozenset(
            name for name, each in self._outputs.items() if each.level is None and each.known(at) is None
        )

    def troubles(self, at: int) -> dict[str, str]:
        """Return the troubles, a clause by output."""
        found = {name: each.trouble(at) for name, each in self._outputs.items()}
        return {name: why for name, why in found.items() if why}

    @property
    def pending(self) -> bool:
        """Whether a command is not done yet, or a pulse has not ended."""
        return any(each.pending or each.rests for each in self._outputs.values())

    @property
    def due(self) -> int | None:
        """The latest time for the next call of `next_write`; None: nothing is pending."""
        times = [each.due_at for each in self._in_turn()]
        times += [each.gives_up_at for each in self._outputs.values() if each.gives_up_at is not None]
        return min(times, default=None)

    def _in_turn(self) -> list[BusOutput]:
        """Return the outputs that may be written next: of each unit the one that was commanded first, and those before
        it that the device has refused. Releases do not wait for ever for one that is tried in vain.
        """
        found, units, stuck = list[BusOutput](), set[int](), set[int]()
        for each in sorted(self._outputs.values(), key=lambda each: (each.turn, each.due_at)):
            unit = each.stanza.unit
            waits = unit in units or (unit in stuck and each.level)
            if (waits and not each.rests) or each.next_row(LAST) is None:
                continue
            if each.stanza.bitmask and not each.stanza.use_mask_write and self._register(each) is None:
                continue
            found.append(each)
            if not each.pending:
                continue  # the end of a pulse keeps nothing waiting
            if each.in_vain >= MOST_IN_VAIN:
                stuck.add(unit)
            elif not each.refused:
                units.add(unit)
        return found

    def _others(self, output: BusOutput) -> list[BusOutput]:
        """Return the other outputs of the same unit."""
        return self._neighbours[output.name]

    def _together(self, first: BusOutput, row: Row, at: int) -> RegisterWrite:
        """Return a write of this row and of all due rows with adjacent registers that were commanded with it."""
        unit, table, (address, values) = first.stanza.unit, first.stanza.register_type, row
        if first.stanza.use_mask_write:
            return RegisterWrite(unit, address, values, mask=first.stanza.bitmask_at(address))
        if (whole := self._register(first)) is not None:
            return RegisterWrite(unit, address, (whole,), multiple=first.stanza.use_write_multiple)
        ready = {
            other.address: other.values
            for each in self._outputs.values()
            if (each.stanza.unit, each.stanza.register_type, each.turn) == (unit, table, first.turn)
            and (other := each.next_row(at)) is not None
            and _shares(each, other)
        }
        if _shares(first, row):
            ends = {start + len(each): (start, each) for start, each in ready.items()}
            while (before := ends.get(address)) and len(values) < LONGEST_WRITE:
                address, values = before[0], before[1] + values
            while (behind := ready.get(address + len(values))) and len(values) < LONGEST_WRITE:
                values += behind
        return RegisterWrite(unit, address, values, table == "coil", first.stanza.use_write_multiple)

    def _register(self, output: BusOutput) -> int | None:
        """Return the whole register of an output with a bitmask; None: it has none, or a bit is not known."""
        mine, whole = output.stanza, 0
        for each in self._outputs.values() if mine.bitmask else ():
            if each.stanza.bitmask and (each.stanza.unit, each.stanza.address) == (mine.unit, mine.address):
                row = each.next_row(LAST) if each is output else None
                bits = row.values[0] if row else each.bits(self._now)
                if bits is None:
                    return None
                whole |= bits
        return whole if mine.bitmask else None

    def _rows_of(self, write: RegisterWrite) -> Iterable[tuple[BusOutput, Row]]:
        """Yield the outputs in a write, with the row of each."""
        for each in self._outputs.values():
            row = each.next_row(LAST)
            same = (each.stanza.unit, each.stanza.register_type == "coil") == (write.unit, write.coils)
            mask = each.stanza.bitmask_at(row.address) if row is not None else None
            if row is None or not same or (write.mask is not None and write.mask != mask):
                continue
            start = row.address - write.address
            if mask:
                if start == 0 and (write.values[0] & mask,) == row.values:
                    yield each, row
            elif start >= 0 and write.values[start : start + len(row.values)] == row.values:
                yield each, row


def _shares(output: BusOutput, row: Row) -> bool:
    """Return whether a row may be written with its neighbours: it is a command in one write, without a handshake."""
    whole = len(row.values) == len(output.stanza.command_on) and not output.stanza.bitmask
    single = output.stanza.handshake is None and output.stanza.opposite is None
    return whole and single and not output.alone
