"""How far a new arbiter believes the records of the one before it."""

from __future__ import annotations

import logging
from dataclasses import replace

from end_effector_hal.arbiter.records._journal import JournalEntry
from end_effector_hal.arbiter.rules import ArbiterState

_log = logging.getLogger("end_effector_hal.arbiter")


def recall(record: ArbiterState | None, journal: JournalEntry) -> ArbiterState:
    """The state to begin with: from the session record of this boot; without one, the faults of the journal.

    In doubt more faults are latched rather than fewer, and no last will is executed.
    """
    if record is not None and not record.doubt:
        return record
    if journal.doubt:
        _log.error("latched faults may be missing: %s", journal.doubt)
    faults = dict(journal.faults)
    if journal.doubt:
        faults["journal"] = f"Faults that were latched before the start may be missing: {journal.doubt}."
    if record is not None:
        return replace(record, faults={**faults, **record.faults})
    known = journal.clean and journal.boot  # an arbiter that ended in order has left nothing to be done
    return ArbiterState(faults, clean=journal.clean, doubt="" if known else "no session record was found")
