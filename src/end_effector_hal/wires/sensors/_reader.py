"""Reads whatever brings the channels of a tool, and delivers their frames one after the other."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace

from end_effector_hal.codecs import codec_of
from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from end_effector_hal.wires.link import LinkHealth, LinkReader


class SensorReader:
    """Frames of the sensor link, if there is one.

    Both callbacks come from threads of the reader, one call at a time, and must not block for long.

    Args:
        description: the tool.
        on_frame: each frame, at once; no frame is stamped before the one that was delivered before it.
        on_change: each change of the state of a source.

    Raises:
        UsageError: its codec cannot be used.
    """

    def __init__(
        self,
        description: Description,
        on_frame: Callable[[Frame], None],
        on_change: Callable[[LinkHealth], None] | None = None,
    ) -> None:
        link = description.link
        self.where = link.port if link else description.sensors
        """Where the readings come from, for people."""
        self._on_frame = on_frame
        self._lock = threading.Lock()
        self._last = 0
        self._link = LinkReader(
            self.where,
            codec_of(description),
            link.baudrate if link else None,
            on_frame=self._deliver,
            on_change=on_change,
            parity=link.parity if link else None,
        )

    def start(self) -> None:
        """Begin; raises LinkBusyError when somebody else reads the sensor link."""
        self._link.start()

    def close(self) -> None:
        """End; nothing is delivered after it."""
        self._link.close()

    @property
    def health(self) -> LinkHealth:
        """As it is now; for any thread."""
        return self._link.health

    def _deliver(self, frame: Frame) -> None:
        with self._lock:
            if frame.at < self._last:  # of another source, and overtaken by microseconds
                frame = replace(frame, at=self._last)
            self._last = frame.at
            self._on_frame(frame)
