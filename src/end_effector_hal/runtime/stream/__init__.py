"""The records of a running program, live: who may command its lines may read them, and give it commands."""

from ._protocol import (
    MAINTENANCE_WORDS,
    PROGRAM_WORDS,
    TOO_LATE,
    ProgramCommand,
    program_of,
    program_socket,
)
from ._readers import MOST_BYTES, MOST_READERS, StreamReader, StreamReaders
from ._record_stream import MOST_WAITING, Commander, Entry, RecordStream
