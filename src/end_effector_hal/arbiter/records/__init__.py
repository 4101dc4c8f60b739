"""The records for the next arbiter: sessions in memory that outlives the process, latched faults on a disk."""

from ._journal import NO_ANSWER, Journal, JournalEntry, JournalThread
from ._records import Records, recorded_left_behind
from ._session_store import SessionStore, this_boot
from ._storage import FileStorage
