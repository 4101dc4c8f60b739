"""Robotiq's EPick and 2F-85 as their registers show them, by the tables of their manuals and drivers.

Times that no document gives are guesses, and say so. µs, whatever comes.
"""

from __future__ import annotations

OUTPUTS, INPUTS = 0x03E8, 0x07D0
SILENCE_US = 1_000_000
"""Without any message for so long: fault 9."""
STANDS_IDLE = 9
MAJOR = range(0x0A, 0x10)
"""Faults that only an activation clears, by the drivers that give their codes."""
TRAVEL_US = 700_000
"""Of the fingers, from open to closed at full speed; a guess."""
ACTIVATION_US = 1_500_000
"""Of the fingers' closing and opening; a guess, real ones take a few seconds."""
PART_AT = 140
"""Position at which a part stops the fingers."""
CLOSED_AT = 230
"""Position at which the fingers meet."""


class _Robotiq:
    """Three registers in each direction, an activation, and the watch over silence."""

    ACTIVATION_US = ACTIVATION_US

    def __init__(self, at: int = 0) -> None:
        self.has_part = True
        self.fault = 0
        """Its fault status, beside that of a silent bus."""
        self.written: list[tuple[int, ...]] = []
        """All that was commanded, in order."""
        self.power_up(at)

    def power_up(self, at: int) -> None:
        """Without anything that it was told before."""
        self.commands = [0] * 6
        self._activated_at: int | None = None
        self._heard_at, self._lost = at, False
        self._moved_at = at

    def read(self, function: int, address: int, count: int, at: int) -> list[int] | None:
        """Registers of its status."""
        self._hear(at)
        if not INPUTS <= address < address + count <= INPUTS + 3:
            return None
        status = self._status(at)
        words = [status[2 * i] << 8 | status[2 * i + 1] for i in range(3)]
        return words[address - INPUTS : address - INPUTS + count]

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        """Set its command registers, all three at once."""
        self._hear(at)
        if address != OUTPUTS or len(values) != 3:
            return False
        self.written.append(values)
        before = self.commands
        self.advance(at)
        self.commands = [byte for word in values for byte in (word >> 8, word & 0xFF)]
        active, was_active = self.commands[0] & 1, before[0] & 1
        if not active:
            self._activated_at, self._lost = None, False
            self.fault = 0 if self.fault in MAJOR else self.fault
        elif not was_active:
            self._activated_at = at + self.ACTIVATION_US
        self._commanded(before, at)
        return True

    def activated(self, at: int) -> bool:
        """Whether its activation is over."""
        return self._activated_at is not None and at >= self._activated_at

    def advance(self, at: int) -> None:
        """Time has come to ``at``."""
        self._moved_at = at

    def _hear(self, at: int) -> None:
        if at - self._heard_at > SILENCE_US:
            self._silent(at)
        self._heard_at = at

    def _silent(self, at: int) -> None:
        self._lost = True

    def _gsta(self, at: int) -> int:
        return 0 if self._activated_at is None else 3 if self.activated(at) else 1

    @property
    def _fault(self) -> int:
        return self.fault or (STANDS_IDLE if self._lost else 0)

    def _status(self, at: int) -> list[int]:
        raise NotImplementedError

    def _commanded(self, before: list[int], at: int) -> None:
        raise NotImplementedError


class Gripper2F85(_Robotiq):
    """Fingers, 0 open to 255 closed; self-locking, so that silence and power leave them where they are."""

    def __init__(self, at: int = 0) -> None:
        self.position = 0.0
        self._object = 0
        super().__init__(at)

    @property
    def holds(self) -> bool:
        """Whether the part is between the fingers."""
        return self.has_part and self.position >= PART_AT

    def advance(self, at: int) -> None:
        """The fingers move while rACT and rGTO are set; an activation closes and opens them."""
        step = (at - self._moved_at) * 255 / TRAVEL_US
        super().advance(at)
        if self._activated_at is not None and not self.activated(at):
            self.position = 0.0  # they have closed and opened
            return
        if not self.activated(at) or not self.commands[0] & 0x08:
            return
        wanted = float(self.commands[3])
        end = min(wanted, PART_AT if self.has_part else CLOSED_AT)
        self.position = (
            min(self.position + step, end) if self.position < end else max(self.position - step, end)
        )
        arrived = self.position == end
        self._object = 0 if not arrived else 2 if wanted > end and self.has_part else 3

    def _commanded(self, before: list[int], at: int) -> None:
        if before[3] != self.commands[3]:
            self._object = 0

    def _status(self, at: int) -> list[int]:
        self.advance(at)
        act, goto = self.commands[0] & 1, self.commands[0] & 8
        first = act | goto | self._gsta(at) << 4 | (self._object if goto else 0) << 6
        return [first, 0, self._fault, self.commands[3], round(self.position), 0]


class SimulatedEPick(_Robotiq):
    """A pump; after 1 s without a message it stops, and releases: what its driver's authors saw, a guess here."""

    ACTIVATION_US = 500_000
    PUMP_US = 300_000
    """Until the vacuum stands; a guess."""

    def __init__(self, at: int = 0) -> None:
        self._sucks_since: int | None = None
        self._released = False
        super().__init__(at)

    def power_up(self, at: int) -> None:
        """Without vacuum, and it wants a release before the first grip."""
        super().power_up(at)
        self._sucks_since, self._released = None, False

    @property
    def holds(self) -> bool:
        """Whether a part hangs on the cup."""
        return self.has_part and self._sucks_since is not None

    def _silent(self, at: int) -> None:
        super()._silent(at)
        self._sucks_since = None

    def _commanded(self, before: list[int], at: int) -> None:
        regulates = self.activated(at) and self.commands[0] & 0x08 and not self._lost
        wants = bool(regulates) and self.commands[3] < 100
        if regulates and not wants:
            self._released = True
        if not wants or not self._released:
            self._sucks_since = None
        elif self._sucks_since is None:
            self._sucks_since = at

    def _status(self, at: int) -> list[int]:
        stands = self._sucks_since is not None and at - self._sucks_since >= self.PUMP_US
        kpa = (30 if self.has_part else 92) if stands else 100
        found = (2 if self.has_part else 3) if stands else 0
        first = (
            self.commands[0] & 1 | self.commands[0] & 8 | (3 if self.activated(at) else 0) << 4 | found << 6
        )
        return [first, int(self._sucks_since is not None), self._fault, self.commands[3], kpa, 0]
