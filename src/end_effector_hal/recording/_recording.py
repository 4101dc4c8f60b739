"""Write the files of a run's recording as the run happens, and track the rows that could not be written."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from end_effector_hal._closing import Closing
from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import EventKind, ToolEvent
from end_effector_hal.description import Description, measures_of
from end_effector_hal.errors import ReportedError, UsageError, os_errors
from end_effector_hal.sensing import Readings
from end_effector_hal.signals import Frame, Value
from end_effector_hal.vocabulary import Alarm, ChangerState, printable
from end_effector_hal.wires import now_us

from ._alarms import AlarmsWriter
from ._events import EventRow, EventsWriter, event_row
from ._files import RecordingLimits, RunFile
from ._levels import ChangerWriter, PartsWriter, SwitchesWriter, is_part_name
from ._of_tool import pressure_channels, run_info, switch_channels
from ._pressures import PressuresWriter
from ._run import RunInfo, read_run
from ._states import StatesWriter


class Losses:
    """The write failures of one recording folder; not thread-safe.

    Attributes:
        failing: files that could not be written at the last attempt, with the reason.
        gaps: sentences about missing rows, one for each interval, for run.json.
        info_due: whether run.json must be written.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.failing: dict[str, str] = {}
        self.gaps: list[str] = []
        self.info_due = False
        self._since_s: float | None = None
        self._rows = 0
        self._why = ""

    def write(self, name: str, time_s: float, write: Callable[[], bool], *, again: bool = False) -> bool:
        """Write a row of time ``time_s``; return False if the row was not needed or cannot be written.

        ``write`` returns whether it has proven that the file can be written; ``again``: the row has already been
        counted as lost.
        """
        try:
            written = write()
        except (ReportedError, OSError) as error:
            self._rows += not again
            self.fail(name, time_s, error)
            return False
        if written:
            self.failing.pop(name, None)
        return written

    def fail(self, name: str, time_s: float, error: Exception) -> None:
        """Note that a file could not be written."""
        self._why = self._why or (error.what if isinstance(error, ReportedError) else str(error))
        self._since_s = time_s if self._since_s is None else self._since_s
        self.failing[name] = str(error)

    def over(self, time_s: float) -> bool:
        """Return whether a loss has occurred since the last call; if rows were lost, add a sentence to :attr:`gaps`."""
        if self._since_s is None:
            return False
        if self._rows:
            span = f"From {self._since_s:.3f} s to {time_s:.3f} s"
            self.gaps.append(f"{span} {self._rows} rows of this recording could not be written. {self._why}")
        self._since_s, self._rows, self._why = None, 0, ""
        return True

    def complain(self) -> None:
        """Raise ReportedError, with the text of the first failure, while a file cannot be written."""
        if self.failing:
            what = f"Rows of the recording cannot be written; writing is retried: {self._why}"
            raise ReportedError(what, where=str(self._folder))


_log = logging.getLogger("end_effector_hal.runtime")
MOST_DUE = 1000
"""Maximum number of events that wait while events.csv cannot be written; the newest are kept."""
MOST_GAPS = 100
"""Maximum number of gaps in run.json; the newest are kept."""


class Recording(Closing):
    """Writes ``run.json`` and the tables of a run into a folder; thread-safe.

    Times are µs on the monotonic clock. The recording starts with its first state; older rows get the time of the
    start. A recording that is already in the folder is continued on its own time.

    While a row cannot be written, each call retries the failed writes and raises the same error. Lost rows are
    reported in ``run.json``.

    Args:
        folder: the folder; created if it is missing.
        tool: the description of the tool; or the known facts of a tool without a description, of which neither
            pressures nor switches are recorded.
        scenario: scenario of the testbench; empty: the scenario in the folder's run.json.
        seed: seed of the testbench; None: the seed in the folder's run.json.
        ros: generation of ROS that carries the states; 0: no ROS.
        limits: limits of the folder; None: the default limits.
        events: whether events are recorded; if not, there is no ``events.csv``.
        started: start of the recording, time of day; None: now.
        now: returns the time on the monotonic clock, µs.

    Raises:
        UsageError: the folder cannot be written, or contains the recording of another tool.
    """

    def __init__(
        self,
        folder: str | Path,
        tool: Description | RunInfo,
        *,
        scenario: str = "",
        seed: int | None = None,
        ros: int = 0,
        limits: RecordingLimits | None = None,
        events: bool = True,
        started: datetime | None = None,
        now: Callable[[], int] = now_us,
    ) -> None:
        self.folder, self._now = Path(folder), now
        limits = limits or RecordingLimits()
        with os_errors("The folder cannot be made", folder):
            self.folder.mkdir(parents=True, exist_ok=True)
        begun, started = _begun(self.folder), started or datetime.now(UTC)
        self._begun = now() - round((started - (begun or started)).total_seconds() * 1_000_000)
        self._start = self._begun if begun else None
        self._lock = threading.Lock()
        self._losses = Losses(self.folder)
        self._latest: tuple[int, int, Sequence[int]] | None = None
        self._standing: Sequence[Alarm] = ()
        self._reported: int | None = None
        """The state after the last event; None: there was no event."""
        self._changed, self._part = ChangerState.UNKNOWN, ""
        before = read_run(self.folder)
        known = tool if isinstance(tool, RunInfo) else run_info(tool)
        described = None if isinstance(tool, RunInfo) else tool
        actuators, path = tuple(known.actuators), self.folder.joinpath
        with ExitStack() as files:
            states = files.enter_context(StatesWriter(path(RunFile.STATES), actuators, limits))
            if states.last is not None:
                self._reported = states.last.end_effector
            self._info = replace(
                known,
                scenario=scenario or before.scenario,
                seed=before.seed if seed is None else seed,
                ros=bool(ros),
                ros_generation=ros or None,
                started=(begun or started).isoformat(),
                gaps=before.gaps if begun else (),
            )
            with os_errors("Cannot be written", folder):
                self._write_info()
            self._names, self._due = actuators, deque[EventRow](maxlen=MOST_DUE)
            self._writes: dict[str, Callable[[float], bool]] = {
                RunFile.STATES: lambda time_s: (
                    self._latest is not None and states.write(time_s, *self._latest)
                )
            }
            """The tables whose last row is written again after a failure, in that order; each writes what holds now."""
            if events:
                writer = files.enter_context(EventsWriter(path(RunFile.EVENTS), actuators, limits))
                self._writes[RunFile.EVENTS] = lambda _: self._write_due(writer)
            alarms = files.enter_context(AlarmsWriter(path(RunFile.ALARMS), limits))
            self._writes[RunFile.ALARMS] = lambda time_s: alarms.write(time_s, self._standing) or True
            self._readings = self._pressures = self._switches = None
            self._levels: Mapping[str, bool | None] = {}
            if described is not None:
                self._readings = Readings(described, carrier_of(described))
                if channels := pressure_channels(described):
                    measures = measures_of(described)
                    units = {name: measures[name].unit for name in channels}
                    pressures = PressuresWriter(path(RunFile.PRESSURES), channels, limits, units)
                    self._pressures = files.enter_context(pressures)
                if bits := switch_channels(described):
                    switches = files.enter_context(SwitchesWriter(path(RunFile.SWITCHES), bits, limits))
                    self._switches = bits
                    self._writes[RunFile.SWITCHES] = lambda time_s: (
                        switches.write(time_s, self._levels) or True
                    )
            if described is None or described.tool_changer is not None:
                changer = files.enter_context(ChangerWriter(path(RunFile.CHANGER), limits))
                self._writes[RunFile.CHANGER] = lambda time_s: changer.write(time_s, self._changed) or True
            if described is None or described.parts:
                parts = files.enter_context(PartsWriter(path(RunFile.PARTS), limits))
                self._writes[RunFile.PARTS] = lambda time_s: parts.write(time_s, self._part) or True
            self._files = files.pop_all()

    def state(self, at: int, end_effector: int, command: int, actuators: Sequence[int]) -> bool:
        """Write the states that hold from ``at`` on; return False when they equal the last row.

        Raises:
            ReportedError: rows cannot be written now.
        """
        with self._lock:
            if self._start is None:
                self._start = max(at, self._begun)
                self._losses.info_due = True
            self._latest = (end_effector, command, actuators)
            written = self._write(RunFile.STATES, at)
            self._settle(at)
        return written

    def tool_changer(self, at: int, state: int) -> None:
        """Write the state of the tool changer from ``at`` on, if there is one.

        Raises:
            ReportedError: rows cannot be written now.
        """
        with self._lock:
            if RunFile.CHANGER in self._writes and self._start is not None:
                self._changed = ChangerState(state) if state in set(ChangerState) else ChangerState.UNKNOWN
                self._write(RunFile.CHANGER, at)
                self._settle(at)

    def part(self, at: int, name: str) -> None:
        """Write the name of the part that is gripped, held or released from ``at`` on, if the tool names parts.

        Raises:
            UsageError: it is not a name.
            ReportedError: rows cannot be written now.
        """
        if not is_part_name(name):
            raise UsageError(f"{printable(name)!r} is not the name of a part.")
        with self._lock:
            if RunFile.PARTS in self._writes and self._start is not None:
                self._part = name
                self._write(RunFile.PARTS, at)
                self._settle(at)

    def alarms(self, at: int, alarms: Sequence[Alarm]) -> None:
        """Write the changes to the alarms that are active from ``at`` on; raises ReportedError if this fails."""
        with self._lock:
            if self._start is not None:
                self._standing = alarms
                self._write(RunFile.ALARMS, at)
                self._settle(at)

    def events(self, at: int, events: Sequence[ToolEvent]) -> None:
        """Write the events that led to the latest state, which is valid from ``at`` on.

        A change of state without an event is recorded as an event without a cause: a message was lost, or a program
        was not running.

        Raises:
            ReportedError: rows cannot be written now.
        """
        with self._lock:
            if self._latest is None or RunFile.EVENTS not in self._writes:
                return
            rows = [event_row(each, self.seconds(min(each.at, at)), self._names) for each in events]
            states = [row.new for row in rows if row.kind is EventKind.STATE_CHANGED]
            old, self._reported = states[-1] if states else self._reported, self._latest[0]
            if old is not None and old != self._reported:
                rows.append(EventRow(self.seconds(at), EventKind.STATE_CHANGED, old=old, new=self._reported))
            if rows:
                self._due.extend(rows)
                self._write(RunFile.EVENTS, at)
                self._settle(at)

    def values(self, at: int, values: Mapping[str, Value]) -> None:
        """Write the values of a frame that arrived at ``at``: gauge Pa or a bit, None for invalid.

        A channel that is missing from the frame, because it comes over another link, keeps its value until that is
        stale.

        Raises:
            ReportedError: rows cannot be written now.
        """
        pressures, switches, readings = self._pressures, self._switches, self._readings
        with self._lock:
            if (pressures is None and switches is None) or readings is None or self._start is None:
                return
            readings.take(Frame(at, None, None, values))
            for name in (name for name, value in values.items() if value is None):
                readings.forget(name)
            time_s = self.seconds(at)
            if pressures is not None:
                now = {name: readings.get(name, at) for name in pressures.channels}
                kpa = {name: None if value is None else value / 1000 for name, value in now.items()}
                self._losses.write(RunFile.PRESSURES, time_s, lambda: pressures.write(time_s, kpa))
            if switches is not None:
                bits = {name: readings.get(name, at) for name in switches}
                self._levels = {name: None if value is None else bool(value) for name, value in bits.items()}
                self._write(RunFile.SWITCHES, at)
            self._settle(at)

    def note(self, gap: str) -> None:
        """Add a sentence about missing data to ``run.json``; it is written with the next row, or on close."""
        with self._lock:
            self._losses.gaps.append(gap)
            self._losses.info_due = True

    def close(self) -> None:
        """Close the files; may be called again. Data that cannot be written any more is reported in the log."""
        try:
            self._files.close()
        except ReportedError as error:
            _log.warning("%s", error)
        with suppress(OSError):
            if self._losses.over(self.seconds(self._now())) or self._losses.info_due:
                self._write_info()

    def seconds(self, at: int) -> float:
        """Convert µs on the monotonic clock to seconds since the start of the recording."""
        return max(0, at - (self._start or self._begun)) / 1_000_000

    def _write(self, table: str, at: int, *, again: bool = False) -> bool:
        """Write what holds now; return whether the table needed it and has it."""
        write, time_s = self._writes[table], self.seconds(at)
        return self._losses.write(table, time_s, lambda: write(time_s), again=again)

    def _write_due(self, writer: EventsWriter) -> bool:
        written = writer.write(tuple(self._due))
        self._due.clear()
        return written

    def _settle(self, at: int) -> None:
        """Retry the failed writes; raise ReportedError while one fails."""
        losses = self._losses
        for table in self._writes:
            if table in losses.failing:
                self._write(table, at, again=True)
        if not losses.failing and losses.over(self.seconds(at)):
            losses.info_due = True
        if losses.info_due:
            try:
                self._write_info()
            except OSError as error:
                losses.fail(RunFile.INFO, self.seconds(at), error)
            else:
                losses.info_due = False
                losses.failing.pop(RunFile.INFO, None)
        losses.complain()

    def _write_info(self) -> None:
        gaps = (*self._info.gaps, *self._losses.gaps)[-MOST_GAPS:]
        replace(self._info, start_us=self._start, gaps=gaps).write(self.folder)


def _begun(folder: Path) -> datetime | None:
    """Return the time at which the recording in a folder began; None: the folder contains no recording."""
    try:
        return (
            datetime.fromisoformat(read_run(folder).started) if (folder / RunFile.STATES).exists() else None
        )
    except (ValueError, TypeError):
        return None
