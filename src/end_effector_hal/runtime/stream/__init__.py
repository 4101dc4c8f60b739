"""The records of a running program, live: who may command its lines may read them, and give it commands."""

from ._protocol import COMMAND_VALID_US, LONGEST, PROGRAM_WORDS, program_of, program_socket
from ._readers import MOST_BYTES, MOST_READERS
from ._record_stream import MOST_WAITING, Commander, Entry, RecordStream

__all__ = [
    "COMMAND_VALID_US",
    "LONGEST",
    "MOST_BYTES",
    "MOST_READERS",
    "MOST_WAITING",
    "PROGRAM_WORDS",
    "Commander",
    "Entry",
    "RecordStream",
    "program_of",
    "program_socket",
]
