"""The first page of a report: goals, failures, durations beside worst cases, and the results of replay and monitor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.recording import GripDecision, ReleaseCause, RunTables, read_story
from end_effector_hal.verification.proof import Verdict
from end_effector_hal.verification.replay import Review, SegmentEnd, review
from end_effector_hal.vocabulary import EndEffectorState

from ._files import RecordingFiles
from ._tables import RecordedTables

_CAUSES = {
    ReleaseCause.ABORT: "Release after an aborted grip",
    ReleaseCause.CANCEL: "Release after a cancelled grip",
    ReleaseCause.DROP: "Drop",
    ReleaseCause.LOSS: "Release after a loss",
    ReleaseCause.START: "Release at the start",
}
_BAD = (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)
MOST_GOALS = 500


def summary(
    tool: Description, tables: RunTables, reasons: Sequence[tuple[float, str]], proven: Verdict | None
) -> dict[str, Any]:
    """Return the story in one sentence, and a row for each goal, as JSON; times in seconds since time zero.

    Args:
        tables: the states, the events and the facts about the run.
        reasons: reasons that the status gave, each with the time from which it did, s.
        proven: the stored verdict about the tool.
    """

    def reason(at_s: float) -> list[str]:
        """Return the reason that the status gave at that time, as a list of at most one text."""
        return [text for time_s, text in reasons if at_s - 1e-6 <= time_s <= at_s + 0.2][:1]

    story = read_story(tables.log, tables.info)
    bounds, goals = tool.durations, list[dict[str, Any]]()
    for grip in story.grips:
        ok, why = grip.decision is GripDecision.GRIPPED, [str(attempt) for attempt in grip.failed]
        why += reason(grip.decided_s) if not ok and grip.decided_s is not None else []
        what, ended = f"Grip {grip.part}".rstrip(), str(grip.decision)
        goals.append(_goal(grip.start_s, grip.decided_s, what, ended, bounds.grip_ms, why, ok=ok))
    for release in story.releases:
        bound_ms = bounds.cancel_ms if release.cause is ReleaseCause.CANCEL else bounds.release_ms
        ended = "UNFINISHED" if release.ended is None else release.ended.label
        ok, end_s = release.ended is not None and release.ended not in _BAD, release.end_s
        why = reason(end_s) if not ok and end_s is not None else []
        goals.append(_goal(release.start_s, end_s, _CAUSES[release.cause], ended, bound_ms, why, ok=ok))
    for loss in story.losses:
        what, why = f"{loss.who or 'The part'} was lost", reason(loss.time_s)
        goals.append(_goal(loss.time_s, None, what, "LOST", None, why, ok=False))
    goals.sort(key=lambda goal: goal["at_s"])
    return {
        "story": story.verdict,
        "goals": goals[:MOST_GOALS],
        "more_goals": max(0, len(goals) - MOST_GOALS),
        "proven": str(proven) if proven is not None else "",
        "holds": proven is not None and proven.holds,
    }


def _goal(
    at_s: float,
    end_s: float | None,
    what: str,
    outcome: str,
    bound_ms: int | None,
    why: list[str],
    *,
    ok: bool,
) -> dict[str, Any]:
    return {
        "at_s": round(at_s, 3),
        "what": what,
        "outcome": outcome,
        "took_s": None if end_s is None else round(end_s - at_s, 3),
        "at_most_s": None if bound_ms is None else bound_ms / 1000,
        "why": why,
        "ok": ok,
    }


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
