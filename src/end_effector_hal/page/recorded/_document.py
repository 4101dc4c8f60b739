"""A recording as one JSON document: the view at each moment, the log, the timeline and the summary."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

from end_effector_hal.control import Status
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import kind_of
from end_effector_hal.page.view import ToolView
from end_effector_hal.recording import RunTables, product_version, run_info
from end_effector_hal.runtime.boundary import Published
from end_effector_hal.runtime.stream import PUBLISHED
from end_effector_hal.verification.proof import kept_verdict
from end_effector_hal.verification.replay import Entry
from end_effector_hal.vocabulary import printable

from ._differences import ComparedRecording, TablesBuilder
from ._files import TOLD, RecordingFiles
from ._samples import Samples, Tracks
from ._summary import summary
from ._tables import RecordedTables

MOST_STEPS = 18_000
"""Largest number of shown moments in which only readings have changed: 0.1 s apart in half an hour."""
LEAST_STEP_US = 20_000
MOST_MOMENTS = 60_000
MOST_EVENTS = 20_000
MOST_CHANGES = 1_500_000
"""Largest number of changes of single values; these three limits bound the size of a document."""
_READINGS = ("frame", "time")
"""Kinds of records that change nothing but readings; other changes appear in a step or a status."""

Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True)
class RecordingPart:
    """The shown part of a recording, in seconds since its beginning; None: from its beginning, to its end."""

    since_s: float | None = None
    until_s: float | None = None


@dataclass(frozen=True, slots=True)
class FoldedRecording:
    """A recording that has been read.

    Attributes:
        document: the JSON document for the browser.
        compared: the data for a comparison with another recording.
    """

    document: dict[str, Any]
    compared: ComparedRecording


def read_recording(
    files: RecordingFiles | RecordedTables,
    part: RecordingPart | None = None,
    progress: Progress = lambda _: None,
) -> FoldedRecording:
    """Convert a recording into a document and into tables.

    Args:
        files: the traces, or the tables.
        part: the part that is shown; default: the whole recording.
        progress: called with the finished share, 0 to 1.

    Raises:
        ModelError, UsageError: the recorded tool can no longer be loaded.
    """
    return _Fold(files, part or RecordingPart(), progress).run()


class _Fold:
    def __init__(
        self, files: RecordingFiles | RecordedTables, part: RecordingPart, progress: Progress
    ) -> None:
        self._files, self._progress = files, progress
        self._epoch = files.begin
        self._since = files.begin + round((part.since_s or 0.0) * 1e6)
        self._until = files.end if part.until_s is None else files.begin + round(part.until_s * 1e6)
        shown_us = max(0, min(self._until, files.end) - self._since)
        self._step_us = max(LEAST_STEP_US, shown_us // MOST_STEPS)
        self._view = ToolView(files.description, files.begin, files.header.hash)
        self._tracks = Tracks()
        self._samples = Samples(self._view.timeline.curves, files.begin, self._step_us)
        self._info = run_info(files.description)
        self._tables = TablesBuilder(files.description, self._info, files.begin, self._since, self._step_us)
        self._log: list[dict[str, Any]] = []
        self._edges: dict[str, int] = {}
        self._edge_list: list[dict[str, Any]] = []
        self._changes: list[dict[str, Any]] = []
        self._seen = [0, 0, 0]
        self._lost, self._run = False, ""
        self._ended = ""

    def run(self) -> FoldedRecording:
        at, due, moved = self._files.begin, self._since, False
        for count, entry in enumerate(self._files.entries()):
            if entry.at > at:
                if moved or at >= due:
                    due = at + self._step_us
                    moved = False
                    self._moment(at)
                at = entry.at
                if at > self._until or self._full():
                    break
            moved = self._take(entry) or moved
            if count % 2000 == 0:
                self._progress((at - self._files.begin) / max(1, self._files.end - self._files.begin))
        else:
            self._moment(at)
        self._samples.flush()
        # no path: the report may be mailed
        tables = self._tables.tables(self._files.name, has_events=self._files.has_events)
        document = self._document(min(at, self._until), tables)
        shown = document["recording"]
        part = shown["begin_s"], shown["end_s"], shown["step_s"]
        return FoldedRecording(document, ComparedRecording(shown["name"], tables, *part, shown["whole"]))

    def _full(self) -> bool:
        if self._ended:
            return True
        if (
            len(self._tracks.times) >= MOST_MOMENTS
            or len(self._log) >= MOST_EVENTS
            or self._tracks.changes >= MOST_CHANGES
        ):
            at_s = (self._tracks.times[-1] - self._epoch) / 1e6 if self._tracks.times else 0
            self._ended = (
                f"Too many events for one page: it ends at {at_s:.1f} s; continue with --from {at_s:.0f}."
            )
        return bool(self._ended)

    def _take(self, entry: Entry) -> bool:
        """Process one record and return whether more than readings may have changed."""
        at, kind, record = entry
        view = self._view
        if kind == "header":
            self._lost = False
            self._begin(record)
        elif kind == "unreadable":
            self._lose(at, "The rest of this trace cannot be read.")
        if self._lost or record is None:
            return kind == "unreadable"
        if kind == TOLD:
            view.log.told(at, record)
            return True
        try:
            if kind == "status":
                self._check(record)
            view.take(kind, at, record, at)
            if kind == "frame":
                self._tables.frame(at, record.values)
            if kind == "status":
                view.take(PUBLISHED, at, Published(record.at, record, {}), at)
        except Exception as error:  # noqa: BLE001 what was damaged, or is of another version, ends no page
            self._files.notes.append(
                f"From {(at - self._epoch) / 1e6:.3f} s on the HAL is not shown: its record {kind} does not fit "
                f"what came before ({str(error) or type(error).__name__})."[:600]
            )
            self._files.whole = False
            self._lose(at, f"Its record {kind} does not fit what came before.")
            return True
        self._drain()
        if kind in ("status", PUBLISHED) and (status := view.status()) is not None:
            self._tables.status(status, (record.status if kind == PUBLISHED else record).events)
        return kind not in _READINGS

    def _check(self, status: Status) -> None:
        """Check that a status fits this tool; raises UsageError."""
        if status.part and status.part not in self._files.description.part_names:
            raise UsageError(f"the tool has no part {printable(status.part)!r}")
        actuators = self._files.description.ordered
        if {len(status.actuators), len(status.outputs), len(status.evidence)} != {len(actuators)}:
            raise UsageError(f"it is not that of a tool with {len(actuators)} actuators")
        for (_, actuator), value in zip(actuators, status.actuators, strict=True):
            kind_of(actuator).states(value)

    def _begin(self, header: Any) -> None:
        if self._run == header.run:
            if header.gap is not None:
                text = f"{header.gap.records} records of the HAL are missing: {header.gap.why}."
                self._view.log.add(header.at, "alarm", text)
            return
        again = " again" if self._run else ""
        self._run = header.run
        self._view.log.add(header.at, "command", f"The HAL begins{again}.")

    def _lose(self, at: int, why: str) -> None:
        self._lost = True
        self._view.log.add(at, "alarm", f"The recording breaks off. {why}")
        self._view.lose(why, at)

    def _drain(self) -> None:
        log, line = self._view.log, self._view.timeline
        if log.newest > self._seen[0]:
            entries = [entry for entry in log.since(self._seen[0]) if entry["kind"] != "page"]
            self._log += [self._short(entry) for entry in entries if self._since <= entry["at"]]
        new = line.since(*self._seen[1:])
        self._seen = [log.newest, line.sampled, line.changed]
        for row in new["samples"]:
            if self._since <= row[0]:
                self._samples.take(row)
        for change in new["changes"]:
            self._changes.append({**change, "at": max(change["at"], self._since)})

    def _short(self, entry: dict[str, Any]) -> dict[str, Any]:
        """Replace the edges of a log entry by their numbers, so that the document has every edge once."""
        if (detail := entry["detail"]) is None:
            return entry
        numbers = []
        for edge in detail["edges"]:
            number = self._edges.setdefault(
                f"{edge['process']} {edge['number']} {edge['source']}", len(self._edges)
            )
            if number == len(self._edge_list):
                self._edge_list.append(edge)
            numbers.append(number)
        return {**entry, "detail": {**detail, "edges": numbers}}

    def _moment(self, at: int) -> None:
        if at < self._since or self._ended:
            return
        try:
            view = self._files.known(self._view.moment())
        except Exception as error:  # noqa: BLE001 a state that fits its form, and nothing else
            why = str(error) or type(error).__name__
            self._ended = (
                f"From {(at - self._epoch) / 1e6:.3f} s on it contradicts itself and is not shown ({why})."
            )
            self._files.whole = False
        else:
            self._tracks.note(at - self._epoch, _rounded(view, self._view.cards.decimals))

    def _document(self, end: int, tables: RunTables) -> dict[str, Any]:
        files, header = self._files, self._files.header
        proven = None
        with suppress(OSError):
            proven = kept_verdict(files.description)
        notes = [*files.notes, *([self._ended] if self._ended else [])]
        if header.version != product_version():
            notes.append(
                f"It was recorded by version {header.version or 'unknown'}; this is version {product_version()}."
            )
        drawn = self._view.drawn()
        del drawn["buttons"]
        return {
            "drawn": {**drawn, "source": PurePath(header.source).name},  # it may be mailed
            "recording": {
                "name": files.name,
                "started": header.started,
                "version": header.version,
                "shown_by": product_version(),
                "hash": header.hash,
                "model": header.model,
                "whole": files.whole,
                "notes": notes,
                "begin_s": max(0.0, (self._since - self._epoch) / 1e6),
                "end_s": max(0.0, (end - self._epoch) / 1e6),
                "step_s": self._step_us / 1e6,
            },
            "summary": summary(files.description, tables, self._tables.reasons, proven),
            "times": self._tracks.times,
            "tracks": self._tracks.as_json(),
            "log": self._log,
            "edges": self._edge_list,
            "samples": self._samples.columns,
            "changes": self._changes,
        }


def _rounded(view: dict[str, Any], decimals: list[list[int]]) -> dict[str, Any]:
    for card, digits in zip(view["cards"] or (), decimals, strict=False):
        if card["margin_kpa"] is not None:
            card["margin_kpa"] = round(card["margin_kpa"], 1)
        shown = zip(card["values"], digits, strict=True)
        card["values"] = [None if value is None else round(value, finest) for value, finest in shown]
    return view
