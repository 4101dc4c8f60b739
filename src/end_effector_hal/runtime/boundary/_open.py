"""Beginning the trace of a program: its header, and the tool as it is at that time."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from secrets import token_hex

from end_effector_hal.control import model_constants
from end_effector_hal.description import Description, socket_path
from end_effector_hal.recording import Opening, RecordingLimits, TraceWriter, content_hash, product_version
from end_effector_hal.runtime.stream import PROGRAM_WORDS, RELOAD_WORDS, RecordStream, program_socket
from end_effector_hal.wires import now_us

from ._recorder import Recorder
from ._records import KINDS, Header

DESCRIPTION, MODEL = "description.json", "end_effector.xml"


def open_recorder(
    folder: str | Path,
    description: Description,
    program: str,
    *,
    at: int | None = None,
    limits: RecordingLimits | None = None,
    stream: RecordStream | None = None,
    observe: Callable[[str, int, object], None] | None = None,
) -> Recorder:
    """A recorder that writes ``<program>.mcap`` and its further segments into a folder; does not wait for the disk.

    ``at``: the time of the run now, µs; by default that of the monotonic clock. ``stream`` and
    ``observe`` get the same records.
    """
    at = now_us() if at is None else at
    model = description.automata_path.read_bytes()
    attachments = {DESCRIPTION: whole(description), MODEL: model}
    first = header_of(description, program, at)

    def header(opening: Opening) -> Header:
        return replace(
            first,
            at=opening.at,
            started=datetime.now(UTC).isoformat(),
            segment=opening.segment,
            follows=opening.follows,
            gap=opening.gap,
        )

    return Recorder(
        TraceWriter(folder, program, KINDS, now=at, attachments=attachments, header=header, limits=limits),
        stream,
        observe,
    )


def open_stream(description: Description, program: str) -> RecordStream:
    """The stream of a program, which is not served yet."""
    first = header_of(description, program, now_us())
    path, beside = program_socket(description, program), socket_path(description)
    return RecordStream(
        path, beside, lambda at: replace(first, at=at), (*PROGRAM_WORDS[program], *RELOAD_WORDS)
    )


def header_of(description: Description, program: str, at: int) -> Header:
    """Where a trace comes from."""
    return Header(
        at=at,
        run=token_hex(8),
        program=program,
        description=description.name,
        hash=content_hash(description),
        model=model_hash(description),
        version=product_version(),
        started=datetime.now(UTC).isoformat(),
        source=str(description.source),
        constants=model_constants(description),
    )


def model_hash(description: Description) -> str:
    """Twelve hex digits of the UPPAAL file."""
    return hashlib.sha256(description.automata_path.read_bytes()).hexdigest()[:12]


def whole(description: Description) -> bytes:
    """The description with every default written out, so that it means the same tomorrow; JSON is YAML, too."""
    content = description.model_dump(mode="json", by_alias=True)
    content["automata"]["file"] = MODEL
    return json.dumps(content, indent=1, ensure_ascii=False).encode()
