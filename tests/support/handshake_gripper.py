"""An electric gripper that takes data by a handshake, after the manuals of Zimmer's GEP2000 and GPP5000 series.

They speak IO-Link; here an IO-Link master hands their process data on as registers. Times are guesses. All are in µs.
"""

from __future__ import annotations

COMMANDS, STATUS = 0x0000, 0x0100
"""Control word and gripping force; status word."""
TRANSFER, MOVE_TO_BASE, MOVE_TO_WORK, ERROR_RESET = 0x0001, 0x0100, 0x0200, 0x8000
BOOTED, AT_BASE, AT_TEACH, AT_WORK, TAKEN, ERROR = 1 << 6, 1 << 8, 1 << 9, 1 << 10, 1 << 12, 1 << 15
TRAVEL_US = 300_000


class HandshakeGripper:
    """Each motion needs data that it has taken; none begins while a handshake is open or an error stands."""

    def __init__(self) -> None:
        self.has_part = True
        self.error = False
        """Stands until an error reset."""
        self.takes_us: int | None = 20_000
        """From the request until the data are taken; None: never."""
        self.ends_us: int | None = 0
        """From the end of the handshake until its bit goes; None: never. A request meanwhile is not seen."""
        self.missed = 0
        """Requests that it has not seen."""
        self.written: list[tuple[int, ...]] = []
        self.power_up(0)

    def power_up(self, at: int) -> None:
        """Nothing of its data is there any more; self-locking, it stays where it is."""
        self._control = self._data = 0
        self._has_data = self._taken = False
        self._asked_at = self._ended_at = self._moved_at = at - TRAVEL_US
        self._asked = False
        self.closes = getattr(self, "closes", False)

    def holds(self, at: int) -> bool:
        """Whether the part is between the jaws."""
        return self.has_part and self.closes and at - self._moved_at >= TRAVEL_US

    def read(self, function: int, address: int, count: int, at: int) -> list[int] | None:
        """Its status word."""
        self._advance(at)
        if address != STATUS or count != 1:
            return None
        there = at - self._moved_at >= TRAVEL_US
        stands = (AT_TEACH if self.has_part else AT_WORK) if self.closes else AT_BASE
        return [
            BOOTED | (stands if there else 0) | (TAKEN if self._taken else 0) | (ERROR if self.error else 0)
        ]

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        """Control word and data, in one request."""
        if address != COMMANDS or len(values) != 2:
            return False
        self._advance(at)
        self.written.append(values)
        before, (self._control, self._data) = self._control, values
        if self._control == TRANSFER and before != TRANSFER:
            self.missed += self._taken
            self._asked, self._asked_at = not self._taken, at
        elif self._control != TRANSFER and before == TRANSFER:
            self._asked, self._ended_at = False, at
        self._advance(at)
        if self._control == ERROR_RESET:
            self.error = False
        wanted = {MOVE_TO_WORK: True, MOVE_TO_BASE: False}.get(self._control)
        if wanted is not None and self._has_data and not self._taken and not self.error:
            if wanted != self.closes:
                self._moved_at = at
            self.closes, self._has_data = wanted, False
        return True

    def _advance(self, at: int) -> None:
        if self._asked and self.takes_us is not None and at - self._asked_at >= self.takes_us:
            self._taken = self._has_data = True
        if self._control != TRANSFER and self.ends_us is not None and at - self._ended_at >= self.ends_us:
            self._taken = False
