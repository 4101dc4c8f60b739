"""The results of replay and monitor for a recording, in words for the page."""

from __future__ import annotations

from typing import Any

from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.verification.replay import Review, SegmentEnd, review

from ._files import RecordingFiles
from ._tables import RecordedTables

MOST_OBJECTIONS = 20


def judge_recording(files: RecordingFiles | RecordedTables) -> dict[str, Any]:
    """Replay every trace and check it against its network; return whether all is well (None: unknown), and why."""
    if isinstance(files, RecordedTables):
        return {"ok": None, "text": "Replay and monitor: there is no trace to judge.", "traces": []}
    rows: list[dict[str, Any]] = []
    before: SegmentEnd | None = None
    for each in files.paths:
        try:
            found = review(files.load(each), None, before)
        except ReportedError as error:
            text = error.what if isinstance(error, UsageError) else str(error)
            rows.append({"trace": each.name, "ok": False, "text": text, "notes": []})
        else:
            before = found.end
            rows.append(_row(each.name, found))
    ok = all(row["ok"] for row in rows)
    notes = any(row["notes"] for row in rows)
    if ok:
        text = "Replay and monitor: identical decisions; every step is allowed by the automata."
    else:
        bad = [row["trace"] for row in rows if not row["ok"]]
        text = f"Replay and monitor: decisions differ, or the trace is incomplete ({', '.join(bad[:5])})."
    return {"ok": ok, "text": text + (" See the notes." if notes else ""), "traces": rows}


def _row(name: str, found: Review) -> dict[str, Any]:
    trace, replay = found.trace, found.replay
    if replay.difference is None:
        said = f"{replay.compared} decisions, all identical"
    else:
        said = f"DIFFERS at {trace.seconds(replay.difference.at):.3f} s: {replay.difference}"
    judged = f"{found.steps} steps, {found.requirements} requirements of the file were judged"
    run = (
        f"not all steps are allowed by the automata ({judged})"
        if found.objections
        else f"every step is allowed by the automata ({judged} and held)"
    )
    if found.objections and all(objection.kind == "missed" for objection in found.objections):
        run = f"every step is allowed by the automata but for missed reaction bounds that the trace records ({judged})"
    objections = [
        f"At {trace.seconds(each.at):.3f} s, {each.kind}: {each.what}"
        for each in found.objections[:MOST_OBJECTIONS]
    ]
    return {
        "trace": name,
        "ok": found.ok,
        "text": f"Replay: {said}. Monitor: {run}.",
        # where the file ends is among the notes of the recording
        "notes": [
            *objections,
            *(note for note in found.notes if not trace.file.note or trace.file.note not in note),
        ],
    }
