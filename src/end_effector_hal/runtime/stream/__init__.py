"""The records of a running program, live: who may command its lines may read them, and give it commands."""

from ._protocol import (
    COMMAND_VALID_US,
    LONGEST,
    MAINTENANCE_WORDS,
    PROGRAM_WORDS,
    TOO_LATE,
    ProgramCommand,
    program_of,
    program_socket,
)
from ._readers import MOST_BYTES, MOST_READERS, StreamReader, StreamReaders
from ._record_stream import MOST_WAITING, Commander, Entry, RecordStream

__all__ = [
    "COMMAND_VALID_US",
    "LONGEST",
    "MAINTENANCE_WORDS",
    "MOST_BYTES",
    "MOST_READERS",
    "MOST_WAITING",
    "PROGRAM_WORDS",
    "TOO_LATE",
    "Commander",
    "Entry",
    "ProgramCommand",
    "RecordStream",
    "StreamReader",
    "StreamReaders",
    "program_of",
    "program_socket",
]
