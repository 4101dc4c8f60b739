"""A trace: the boundary record of a run, written to an MCAP file as it happens."""

from __future__ import annotations

import json
import logging
import os
import queue
import threading
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from time import time_ns
from typing import TYPE_CHECKING

from pydantic_core import to_json

from end_effector_hal.errors import UsageError
from end_effector_hal.trace._json_schema import plain_schema

if TYPE_CHECKING:
    from mcap.writer import Writer

_log = logging.getLogger("end_effector_hal.trace")
SUFFIX = ".mcap"
MOST_WAITING = 20_000
"""Batches: minutes of a disk that does not answer."""

_Item = tuple[str, int, object]


class TraceWriter:
    """Writes records in a thread of its own, each batch at once: what was written is there after a kill.

    `put` and `flush` never wait and never raise: recording does not stand in the way of a reaction. They belong to
    one thread. Trouble with the file ends the recording, with a warning in the log.

    Args:
        folder: made if it is missing; the file is named after the program, or `-2`, `-3` … if that is there.
        program: whose trace it is; topics are ``program/kind``.
        kinds: name of each kind of record, and the dataclass of its content.
        now: µs on the monotonic clock of the run, now: the file carries the time of day, which fits other recordings.
        attachments: name and content of files that belong to the run.

    Raises:
        UsageError: the file cannot be made.
    """

    def __init__(
        self,
        folder: str | Path,
        program: str,
        kinds: Mapping[str, type],
        *,
        now: int,
        attachments: Mapping[str, bytes],
    ) -> None:
        from mcap.writer import CompressionType, Writer

        self.path, self._fd = _create(Path(folder), program)
        self.day_us = time_ns() // 1000 - now
        self._sink = _Sink()
        # without chunks: each record stands alone; a checksum of all of them comes last
        self._writer = Writer(
            self._sink, use_chunking=False, compression=CompressionType.NONE, enable_data_crcs=True
        )
        self._waiting: list[_Item] = []
        self._queue: queue.SimpleQueue[list[_Item] | None] = queue.SimpleQueue()
        self._whole = True
        self._channels = self._begin(self._writer, program, kinds, attachments)
        self._thread = threading.Thread(target=self._run, name=f"trace-{program}", daemon=True)
        self._thread.start()

    def put(self, kind: str, at: int, content: object) -> None:
        """A record of what happened at ``at`` µs on the monotonic clock; it is written after :meth:`flush`."""
        self._waiting.append((kind, at, content))

    def flush(self) -> None:
        """Have written what was put; returns at once."""
        if self._waiting:
            if self._queue.qsize() > MOST_WAITING:
                self._stop("the disk takes too long")
            batch, self._waiting = self._waiting, []
            if self._whole:
                self._queue.put(batch)

    def close(self) -> None:
        """Write the rest and the index; may be called again."""
        self.flush()
        self._queue.put(None)
        self._thread.join(10.0)

    # From here on: in the writer's thread.

    def _begin(
        self, writer: Writer, program: str, kinds: Mapping[str, type], attachments: Mapping[str, bytes]
    ) -> dict[str, int]:
        writer.start(profile="", library="end-effector-hal")
        for name, content in attachments.items():
            media = "application/json" if name.endswith(".json") else "application/xml"
            writer.add_attachment(time_ns(), time_ns(), name, media, content)
        channels = {}
        for kind, type_ in kinds.items():
            schema = json.dumps(plain_schema(type_)).encode()
            number = writer.register_schema(f"end_effector_hal.{type_.__name__}", "jsonschema", schema)
            channels[kind] = writer.register_channel(f"/{program}/{kind}", "json", number)
        self._write()
        return channels

    def _run(self) -> None:
        while (batch := self._queue.get()) is not None:
            for kind, at, content in batch:
                self._encode(kind, at, content)
            self._write()
        if self._whole:
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._write()
        os.close(self._fd)

    def _encode(self, kind: str, at: int, content: object) -> None:
        data = to_json(content, fallback=_plain)
        time = (at + self.day_us) * 1000
        self._writer.add_message(self._channels[kind], time, data, time)

    def _write(self) -> None:
        data = self._sink.take()
        try:
            while data and self._whole:
                data = data[os.write(self._fd, data) :]
        except OSError as error:
            self._stop(error.strerror or str(error))

    def _stop(self, why: str) -> None:
        if self._whole:
            self._whole = False
            _log.warning("%s: nothing more is recorded: %s", self.path, why)


class _Sink(BytesIO):
    """What the library writes to: forgets what was taken away, and still knows how much there was."""

    _taken = 0

    def tell(self) -> int:
        return self._taken + super().tell()

    def take(self) -> bytes:
        data = self.getvalue()
        self._taken += len(data)
        self.seek(0)
        self.truncate()
        return data


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else str(value)


def _create(folder: Path, program: str) -> tuple[Path, int]:
    number = 1
    while True:
        path = folder / f"{program}{'' if number == 1 else f'-{number}'}{SUFFIX}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            return path, os.open(
                path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | os.O_CLOEXEC, 0o644
            )
        except FileExistsError:
            number += 1
            if folder.exists() and not folder.is_dir():
                raise UsageError("This is no folder.", where=str(folder)) from None
        except OSError as error:
            raise UsageError(f"Cannot be written: {error.strerror}.", where=str(path)) from None
