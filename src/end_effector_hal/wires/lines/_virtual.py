"""The ``virtual`` line back-end: a file that represents a GPIO chip and outlives every process."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal

from end_effector_hal.errors import WireError
from end_effector_hal.owned import open_owned, write_owned
from end_effector_hal.wires._claim import Claim
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires.lines._backend import line_not_found, wire_errors
from end_effector_hal.wires.lines._chip_log import (
    ChipLog,
    ChipState,
    Direction,
    Edge,
    LineState,
    header,
    record,
)

Pull = Literal["up", "down"]


class VirtualChip:
    """A chip that is stored in a file; see `_chip_log` for the format."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)

    @classmethod
    def create(
        cls,
        path: str | Path,
        names: Sequence[str],
        pulls: Mapping[str, Pull] | None = None,
        levels: Mapping[str, bool] | None = None,
        *,
        label: str = "virtual",
        exist_ok: bool = False,
    ) -> VirtualChip:
        """Create a chip as after power-up: all lines are inputs, at the level of their pull (default: down) or driven
        from outside.

        Args:
            path: the file of the chip; replaced in one step, and watchers see the change.
            names: the names of its lines.
            pulls: pull by line.
            levels: levels of lines that are driven from outside from the beginning.
            label: name of the chip, for messages.
            exist_ok: keep an existing chip unchanged.

        Raises:
            LineBusyError: another process holds the lines of the chip at this path.
            WireError: the file cannot be written.
        """
        chip = cls(path)
        if exist_ok and chip.path.exists():
            return chip
        claim = chip.claim()
        pull_of = {name: (pulls or {}).get(name, "down") for name in names}
        at, pid, driven = now_us(), os.getpid(), (levels or {}).items()
        records = [record(Edge(at, name, "in", level, pid)) for name, level in driven]
        todo = "Give a path in a directory that can be written."
        try:
            with wire_errors("the virtual chip cannot be made", path, todo):
                # by the umask also for a group: the line arbiter may be another user
                write_owned(chip.path, header(label, pull_of, at) + b"".join(records), 0o664)
        finally:
            claim.release()
        return chip

    def claim(self, fd: int = -1) -> Claim:
        """Claim the chip exclusively, until the claim is released or the process ends.

        Args:
            fd: descriptor of an inherited claim of this chip; a descriptor of another file is closed.

        Raises:
            LineBusyError: another process has the chip; the message names it.
        """
        lock = Path(f"{self.path}.lock")
        if fd >= 0 and not (lock.exists() and _same(fd, lock)):
            os.close(fd)
            fd = -1
        return Claim(lock, "the virtual chip", fd=fd)

    def read(self) -> ChipState:
        """Return the present state of the chip.

        Raises:
            WireError: there is no such file, or it does not contain a chip.
        """
        log, todo = ChipLog(), "Start `eehal testbench` with the same description: it makes the chip."
        with wire_errors("there is no virtual chip", self.path, todo):
            log.feed(self.path.read_bytes())
        if not log.state.label:  # one without lines is a chip as well
            raise WireError(
                "this file is not that of a virtual chip.",
                where=str(self.path),
                todo="Give another path, or delete the file.",
            )
        return log.state


def _same(fd: int, path: Path) -> bool:
    return os.path.samestat(os.fstat(fd), path.stat())


def read_chip(path: str | Path) -> ChipState:
    """Return the direction and level of each line of the virtual chip at ``path``; see `VirtualChip.read`."""
    return VirtualChip(path).read()


class VirtualPins:
    """Drives the inputs of a virtual chip from outside.

    Args:
        path: the file of the chip; it must exist when the pins are driven.
        clock: source of the records' time stamps, µs.
    """

    def __init__(self, path: str | Path, *, clock: Callable[[], int] = now_us) -> None:
        self._path, self._clock = Path(path), clock
        self._log, self._fd, self._read = ChipLog(), -1, 0

    def drive(self, levels: Mapping[str, bool], direction: Direction = "in") -> None:
        """Set some lines to these levels at once. A line that the chip drives is an output and is not changed.

        Args:
            levels: levels by line.
            direction: "out": the levels show outputs of a device beside the chip.

        Raises:
            WireError: there is no chip, or it cannot be written.
        """
        todo = "Restart `eehal testbench`: it makes the chip."
        with wire_errors("the virtual chip cannot be driven", self._path, todo):
            lines = self._lines()
            at, pid = self._clock(), os.getpid()
            changed = [
                record(Edge(at, name, direction, level, pid))
                for name, level in levels.items()
                if name in lines
                and lines[name].level != level
                and (direction == "out" or lines[name].direction == "in")
            ]
            if changed:  # what somebody's death has torn ends with the first byte
                os.write(self._fd, b"\n" + b"".join(changed))

    def close(self) -> None:
        """Stop driving; the levels stay."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _lines(self) -> Mapping[str, LineState]:
        """Return the present state of the lines of the chip that is now at the path; raises OSError."""
        if self._fd >= 0 and not _same(self._fd, self._path):
            self.close()
        if self._fd < 0:
            self._fd = open_owned(self._path, os.O_RDWR | os.O_APPEND, shared=True)
            self._log, self._read = ChipLog(), 0
        while data := os.pread(self._fd, 1 << 16, self._read):
            self._log.feed(data)
            self._read += len(data)
        return self._log.state.lines


STORED_NAME = "virtual-chip"


class VirtualLines:
    """A `LineBackend` on a virtual chip; a request and a set are each one write to the file, atomic for watchers.

    Args:
        path: the file of the chip.
        clock: source of the records' time stamps, µs.
    """

    def __init__(self, path: str | Path, *, clock: Callable[[], int] = now_us) -> None:
        self._chip = VirtualChip(path)
        self._clock = clock
        self._claim: Claim | None = None
        self._fd = -1
        self._levels: dict[str, bool] = {}
        self._stored = -1

    def restore(self, descriptors: Mapping[str, int]) -> None:
        """Use the stored claim of the chip; see `LineHandover`."""
        for name, fd in descriptors.items():
            if name == STORED_NAME:
                self._stored = fd
            else:
                os.close(fd)

    def descriptors(self) -> dict[str, int]:
        """Return the descriptor of the claim; see `LineHandover`."""
        return {STORED_NAME: self._claim.fd} if self._claim else {}

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """Claim and adopt the lines; see `LineBackend.request`."""
        self._chip.read()
        claim, self._stored = self._chip.claim(self._stored), -1
        todo = "Delete the file, or run as the user who made it."
        try:
            found = self._chip.read().lines
            missing = [name for name in names if name not in found]
            if missing:
                raise line_not_found(missing, list(found), looked_at=[str(self._chip.path)])
            with wire_errors("the virtual chip cannot be written", self._chip.path, todo):
                self._fd = open_owned(self._chip.path, os.O_WRONLY | os.O_APPEND, shared=True)
            self._levels = {name: found[name].direction == "out" and found[name].level for name in names}
            self._write({name: False for name in names if found[name].direction == "in"}, begin=b"\n")
        except BaseException:
            claim.release()
            self.close()
            raise
        self._claim = claim
        return self.levels()

    def levels(self) -> dict[str, bool]:
        """Return the levels of the claimed lines."""
        return dict(self._levels)

    def set(self, levels: Mapping[str, bool]) -> None:
        """Write some of the claimed lines; only changes are recorded."""
        self._write({name: level for name, level in levels.items() if self._levels[name] != level})

    def close(self) -> None:
        """Release the claim; the chip keeps its levels."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1
        if self._claim:
            self._claim.release()
            self._claim = None

    def _write(self, changes: Mapping[str, bool], begin: bytes = b"") -> None:
        """Write records at once. The first write begins with a newline, which ends a record that a predecessor's death
        tore.
        """
        if not changes:
            return
        at, pid = self._clock(), os.getpid()
        text = begin + b"".join(record(Edge(at, name, "out", level, pid)) for name, level in changes.items())
        with wire_errors("the virtual chip cannot be written", self._chip.path, "Make room on the disk."):
            if os.write(self._fd, text) != len(text):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._levels |= changes
