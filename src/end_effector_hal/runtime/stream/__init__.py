"""The records of a running program, live: who may command its lines may read them, and give it commands."""

from ._ask import ask_program
from ._protocol import (
    GO_ON,
    MAINTENANCE_WORDS,
    PROGRAM_WORDS,
    RELOAD,
    RELOAD_WORDS,
    TOO_LATE,
    ProgramCommand,
    program_of,
    program_socket,
)
from ._readers import MOST_BYTES, MOST_READERS, StreamReader, StreamReaders
from ._record_stream import MOST_WAITING, Commander, Entry, RecordStream
