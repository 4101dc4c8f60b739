"""Combines several back-ends into one: the lines of the board, and registers on buses."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

from end_effector_hal.errors import WireError
from end_effector_hal.wires.lines._backend import LineBackend, LineHandover, RemoteLines


class RemoteBackend(LineBackend, RemoteLines, Protocol):
    """Lines that a device writes."""


class ComposedLines:
    """A `LineBackend`, `LineHandover` and `RemoteLines` that combines the back-end of the board with others.

    Args:
        board: has all lines that are not in ``others``; it is not used if there are none.
        others: the other back-ends, by the names of their lines.
    """

    def __init__(self, board: LineBackend, others: Mapping[str, RemoteBackend]) -> None:
        self._board, self._others = board, others
        self._claimed: list[LineBackend] = []

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """Claim and adopt the lines; see `LineBackend.request`."""
        levels: dict[str, bool] = {}
        try:
            for backend, mine in self._shares(names):
                levels |= backend.request(mine)
                self._claimed.append(backend)
        except BaseException:
            self.close()
            raise
        return levels

    def levels(self) -> dict[str, bool]:
        """Return the levels of the claimed lines, read back."""
        return {line: level for backend in self._claimed for line, level in backend.levels().items()}

    def set(self, levels: Mapping[str, bool]) -> None:
        """Write some of the claimed lines; the lines of one back-end are written at once."""
        failed: Exception | None = None
        for backend, mine in self._shares(levels):
            try:
                backend.set({line: levels[line] for line in mine})
            except (WireError, OSError) as error:  # the others are written all the same
                failed = failed or error
        if failed is not None:
            raise failed

    def close(self) -> None:
        """Release all claims."""
        while self._claimed:
            self._claimed.pop().close()

    def descriptors(self) -> Mapping[str, int]:
        """Return the descriptors of the board's lines; see `LineHandover`."""
        held = self._board in self._claimed and isinstance(self._board, LineHandover)
        return self._board.descriptors() if held and isinstance(self._board, LineHandover) else {}

    def restore(self, descriptors: Mapping[str, int]) -> None:
        """Use the descriptors of a predecessor; see `LineHandover`."""
        if isinstance(self._board, LineHandover):
            self._board.restore(descriptors)
        else:
            for fd in descriptors.values():
                os.close(fd)

    def unsure(self) -> frozenset[str]:
        """Return the lines of unknown state."""
        return frozenset[str]().union(*(each.unsure() for each in self._remote))

    def owed(self) -> frozenset[str]:
        """Return the lines whose deactivation no device has acknowledged."""
        return frozenset[str]().union(*(each.owed() for each in self._remote))

    def activating(self) -> frozenset[str]:
        """Return the lines whose activation has been in progress for longer than one write takes."""
        return frozenset[str]().union(*(each.activating() for each in self._remote))

    def withdraw(self, lines: Iterable[str], why: str) -> None:
        """Cancel activations of these lines that are not done yet."""
        named = frozenset(lines)
        for each in self._remote:
            each.withdraw(named, why)

    def prepare(
        self, lines: Iterable[str], values: Mapping[str, tuple[int, ...]], given: Mapping[str, int]
    ) -> None:
        """See `RemoteLines`."""
        named = frozenset(lines)
        for each in self._remote:
            each.prepare(named, values, given)

    def acknowledge(self) -> None:
        """Clear the faults of all devices."""
        for each in self._remote:
            each.acknowledge()

    def troubles(self) -> dict[str, str]:
        """Return the troubles, a clause by line."""
        return {line: why for each in self._remote for line, why in each.troubles().items()}

    def filenos(self) -> list[int]:
        """Return the descriptors of all remote back-ends."""
        return [fd for each in self._remote for fd in each.filenos()]

    def heard(self) -> None:
        """Clear the notifications of all remote back-ends."""
        for each in self._remote:
            each.heard()

    @property
    def _remote(self) -> list[RemoteBackend]:
        return list(dict.fromkeys(self._others.values()))

    def _shares(self, names: Sequence[str] | Mapping[str, bool]) -> list[tuple[LineBackend, list[str]]]:
        """Return each back-end with its part of these names, the board first."""
        shares: list[tuple[LineBackend, list[str]]] = []
        for backend in dict.fromkeys((self._board, *self._others.values())):
            mine = [name for name in names if self._others.get(name, self._board) is backend]
            shares += [(backend, mine)] if mine else []
        return shares
