"""What a line arbiter of version 0.1 left for the next one is believed: last wills, levels, latched faults."""

from __future__ import annotations

import json
from pathlib import Path

from end_effector_hal.arbiter.records._journal import Journal, JournalEntry
from end_effector_hal.arbiter.records._record_file import RecordFile
from end_effector_hal.arbiter.records._session_store import SessionStore
from end_effector_hal.arbiter.records._storage import FileStorage
from end_effector_hal.vocabulary import LastWillStep
from end_effector_hal.wires.lines import read_chip

BOTTOM, CYLINDER, TOP, UNLOCK = "SODIMM_208", "SODIMM_210", "SODIMM_212", "SODIMM_206"
NOT_EXECUTED = (
    "No last will was executed, because no record of the sessions was found: what was active stays active."
)


def storage(path: Path) -> FileStorage:
    return FileStorage(path, durable=False)


def test_the_session_record(earlier: Path) -> None:
    folder = earlier / "arbiter"
    found = json.loads(RecordFile(storage(folder / "sessions")).read().payload)
    record = SessionStore(
        storage(folder / "sessions"), storage(folder / "generation"), found["boot"], lambda: 0
    )
    memory = record.read()
    assert memory is not None
    assert memory.doubt == ""
    assert memory.levels == {BOTTOM: True, CYLINDER: True, TOP: True, UNLOCK: False}
    grip, changer = memory.clients
    assert (grip.client, grip.lines, grip.ended) == ("grip", (BOTTOM, CYLINDER, TOP), False)
    assert grip.will == (
        LastWillStep(TOP),
        LastWillStep(CYLINDER, after_us=2_000_000),
        LastWillStep(BOTTOM, after_us=4_000_000),
    )
    assert (changer.client, changer.lines, changer.will) == ("tool_change", (UNLOCK,), ())
    assert grip.faults == changer.faults == ()


def test_the_journal(earlier: Path) -> None:
    entry = Journal(storage(earlier / "arbiter" / "journal"), "another boot", lambda: 0).read()
    assert entry == JournalEntry(
        {"last wills": NOT_EXECUTED}, clean=True, boot="9fc90ba6-1b5f-4baa-9cc3-4798f7b25ad6"
    )


def test_the_virtual_chip(earlier: Path) -> None:
    lines = read_chip(earlier / "arbiter" / "chip").lines
    assert {name for name, line in lines.items() if line.level} == {BOTTOM, CYLINDER, TOP}
