"""``alarms.csv``: a row when a sentence becomes an alarm, and one when it is one no longer."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.recording._limits import RecordingLimits
from end_effector_hal.recording.tables._rows import TableWriter, read_lines

COLUMNS = ("time_s", "event", "alarm")
BEGUN, ENDED = "begun", "ended"


@dataclass(frozen=True, slots=True)
class AlarmRow:
    """``event`` is ``begun`` or ``ended``; seconds since the start of the recording."""

    time_s: float
    event: str
    text: str

    @property
    def title(self) -> str:
        """Its first words, for a figure."""
        return self.text.split(":")[0].split(" (")[0].rstrip(".")


def changed_alarms(time_s: float, before: Sequence[str], now: Sequence[str]) -> list[AlarmRow]:
    """What has ended, then what has begun."""
    rows = [AlarmRow(time_s, ENDED, text) for text in before if text not in now]
    return rows + [AlarmRow(time_s, BEGUN, text) for text in now if text not in before]


class AlarmsWriter(TableWriter):
    """Writes what is new in the alarms of a state; safe to use from several threads.

    Raises:
        UsageError: the file cannot be written, or is something else.
    """

    def __init__(self, path: str | Path, limits: RecordingLimits | None = None) -> None:
        self._shown: tuple[str, ...] = ()
        self._last_s = 0.0
        super().__init__(path, COLUMNS, limits)

    def write(self, time_s: float, alarms: Sequence[str]) -> bool:
        """The alarms that stand from ``time_s`` on; whether there is something new.

        Raises:
            ReportedError: that cannot be written; it is written with the next call that can.
        """
        with self._lock:
            self._last_s = max(time_s, self._last_s)
            rows = changed_alarms(self._last_s, self._shown, alarms)
            if not rows:
                return False
            self._file.append("".join(map(_text, rows)))
            self._shown = tuple(alarms)
        return True

    def _opening(self) -> str:
        return "".join(map(_text, changed_alarms(self._last_s, (), self._shown)))


def read_alarms(path: str | Path) -> tuple[AlarmRow, ...]:
    """The alarms of a recording, in order; a recording without the file has none.

    Raises UsageError with ``file:line`` for a row that is none; a last one that was cut off is left out.
    """
    if not Path(path).exists():
        return ()
    rows: list[AlarmRow] = []
    standing: set[str] = set()
    first = ""
    for line in read_lines(path):
        if not line.complete:
            break
        first = first or line.path
        try:
            fields = next(csv.reader([line.text]), [])
            if line.number == 1 and tuple(fields) == COLUMNS:
                continue
            time_s, event, text = fields
            row = AlarmRow(line.seconds(time_s, rows[-1].time_s if rows else 0.0), event, text)
        except (ValueError, UsageError, csv.Error):
            raise line.fault(f"This is no row of {','.join(COLUMNS)}.") from None
        repeated = line.path != first and event == BEGUN and text in standing
        if not repeated:  # a segment begins with what stands then
            rows.append(row)
        (standing.add if event == BEGUN else standing.discard)(text)
    return tuple(rows)


def _text(row: AlarmRow) -> str:
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(
        (f"{row.time_s:.6f}", row.event, " ".join(row.text.split()))
    )
    return line.getvalue()
