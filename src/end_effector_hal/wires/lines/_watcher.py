"""Watches all changes of a virtual chip, as a testbench watches pins: by events, without polling."""

from __future__ import annotations

import logging
import os
import select
import threading
from collections.abc import Callable
from pathlib import Path

from end_effector_hal.errors import WireError
from end_effector_hal.wires.lines._backend import wire_errors
from end_effector_hal.wires.lines._chip_log import ChipLog, ChipState, Edge

_log = logging.getLogger("end_effector_hal.wires")


class ChipWatcher:
    """Calls ``on_edge`` in its own thread for every record, in order, with the writer's time stamp.

    If a chip is created again at the same path (power-up), each line whose state that changes gives an edge.

    Args:
        path: the file of the chip; its folder must exist, the file may be created later.
        on_edge: must not block for long; an exception is logged.
    """

    def __init__(self, path: str | Path, on_edge: Callable[[Edge], None]) -> None:
        self._path = Path(path)
        self._on_edge = on_edge
        self._chip = ChipLog()
        self._fd = -1
        self._thread: threading.Thread | None = None

    def start(self) -> ChipState:
        """Start watching; every record after the returned state becomes an edge.

        Raises:
            WireError: the folder does not exist.
        """
        from inotify_simple import INotify, flags  # on Linux only

        self._modify = flags.MODIFY
        self._inotify = INotify()
        folder = self._path.parent
        try:
            with wire_errors("the virtual chip cannot be watched", folder, "Make the directory first."):
                self._inotify.add_watch(folder, flags.CREATE | flags.MOVED_TO | flags.ONLYDIR)
        except WireError:
            self._inotify.close()
            raise
        self._wake_read, self._wake = os.pipe()
        self._open()
        self._read()
        state = self._chip.state
        self._thread = threading.Thread(target=self._run, name=f"chip {self._path.name}", daemon=True)
        self._thread.start()
        return state

    @property
    def state(self) -> ChipState:
        """The state after the last edge."""
        return self._chip.state

    def close(self) -> None:
        """Stop watching; no edge is delivered afterwards (unless called from ``on_edge``)."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        os.write(self._wake, b"x")
        if thread is not threading.current_thread() and thread.ident is not None:
            thread.join()

    def __enter__(self) -> ChipWatcher:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        while self._wake_read not in select.select([self._inotify, self._wake_read], [], [])[0]:
            again = any(event.name == self._path.name for event in self._inotify.read(timeout=0))
            self._report(self._read())
            if again:
                self._open()
                self._report(self._read())
        self._inotify.close()
        for fd in (self._wake_read, self._wake, self._fd):
            if fd >= 0:
                os.close(fd)

    def _open(self) -> None:
        """Open the file that is now at the path; the folder is already watched, so no change is missed."""
        try:
            fd = os.open(self._path, os.O_RDONLY | os.O_CLOEXEC)
        except OSError:
            return
        self._inotify.add_watch(f"/proc/self/fd/{fd}", self._modify)
        if self._fd >= 0:
            os.close(self._fd)
        self._fd = fd
        self._chip.start_new_file()

    def _read(self) -> list[Edge]:
        edges: list[Edge] = []
        while self._fd >= 0 and (data := os.read(self._fd, 1 << 16)):
            edges += self._chip.feed(data)
        return edges

    def _report(self, edges: list[Edge]) -> None:
        for edge in edges:
            try:
                self._on_edge(edge)
            except Exception:  # noqa: BLE001 a callback may raise anything; the next edge counts
                _log.exception("a watcher of %s failed at %s", self._path, edge)
