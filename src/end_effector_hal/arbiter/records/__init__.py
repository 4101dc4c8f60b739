"""The records for the next arbiter: sessions in memory that outlives the process, latched faults on a disk."""

from ._journal import NO_ANSWER, Journal, JournalEntry
from ._records import Records
from ._session_store import SessionStore
