"""A file that stands for a GPIO chip; it survives every process, like gpio-mxc keeps its registers."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

from end_effector_hal.errors import WireError
from end_effector_hal.wires._claim import Claim
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires.lines._chip_log import ChipLog, ChipState, header

Pull = Literal["up", "down"]


class VirtualChip:
    """The chip that stands in a file; see `_chip_log` for the format."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)

    @classmethod
    def create(
        cls,
        path: str | Path,
        names: Sequence[str],
        pulls: Mapping[str, Pull] | None = None,
        *,
        label: str = "virtual",
        exist_ok: bool = False,
    ) -> VirtualChip:
        """Power a chip up: all lines are inputs, at the level of their pull (default: down).

        Args:
            path: its file; replaced in one step, watchers see the change.
            names: its lines.
            pulls: by line.
            label: its name, for people.
            exist_ok: a chip that exists stays as it is.

        Raises:
            LineBusyError: somebody holds the lines of the chip at this path.
            WireError: the file cannot be written.
        """
        chip = cls(path)
        if exist_ok and chip.path.exists():
            return chip
        claim = chip.claim()
        fresh = chip.path.with_name(f".{chip.path.name}.{os.getpid()}")
        try:
            pull_of = {name: (pulls or {}).get(name, "down") for name in names}
            fresh.write_bytes(header(label, pull_of, now_us()))
            fresh.replace(chip.path)
        except OSError as error:
            raise WireError(
                f"the virtual chip cannot be made: {error.strerror}.",
                where=str(path),
                todo="Give a path in a directory that can be written.",
            ) from error
        finally:
            claim.release()
        return chip

    def claim(self, fd: int = -1) -> Claim:
        """Exclusive, until it is released or the process ends.

        Args:
            fd: of a claim of this chip that was handed on; one of another file is closed.

        Raises:
            LineBusyError: another process has it; says who.
        """
        lock = Path(f"{self.path}.lock")
        if fd >= 0 and not (lock.exists() and _same(fd, lock)):
            os.close(fd)
            fd = -1
        return Claim(lock, "the virtual chip", fd=fd)

    def read(self) -> ChipState:
        """As it stands now.

        Raises:
            WireError: there is no such file, or it is not a chip's.
        """
        log = ChipLog()
        try:
            log.feed(self.path.read_bytes())
        except OSError as error:
            raise WireError(
                f"there is no virtual chip: {error.strerror}.",
                where=str(self.path),
                todo="Start `eehal testbench` with the same description: it makes the chip.",
            ) from error
        if not log.state.lines:
            raise WireError(
                "this file is not that of a virtual chip.",
                where=str(self.path),
                todo="Give another path, or delete the file.",
            )
        return log.state


def _same(fd: int, path: Path) -> bool:
    return os.path.samestat(os.fstat(fd), path.stat())


def read_chip(path: str | Path) -> ChipState:
    """Direction and level of each line of the virtual chip at ``path``; see `VirtualChip.read`."""
    return VirtualChip(path).read()
