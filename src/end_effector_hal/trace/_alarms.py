"""``alarms.csv``: a row when a sentence becomes an alarm, and one when it is one no longer."""

from __future__ import annotations

import csv
import io
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.trace._rows import RowFile, read_lines

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


class AlarmsWriter:
    """Writes what is new in the alarms of a state; safe to use from several threads.

    Raises:
        UsageError: the file cannot be written, or is something else.
    """

    def __init__(self, path: str | Path) -> None:
        self._file, self._lock = RowFile(path, COLUMNS), threading.Lock()
        self._shown: tuple[str, ...] = ()
        self._last_s = 0.0

    def write(self, time_s: float, alarms: Sequence[str]) -> None:
        """The alarms that stand from ``time_s`` on."""
        with self._lock:
            rows = [(ENDED, text) for text in self._shown if text not in alarms]
            rows += [(BEGUN, text) for text in alarms if text not in self._shown]
            self._shown, self._last_s = tuple(alarms), max(time_s, self._last_s)
            for event, text in rows:
                line = io.StringIO()
                csv.writer(line, lineterminator="\n").writerow(
                    (f"{self._last_s:.6f}", event, " ".join(text.split()))
                )
                self._file.append(line.getvalue())

    def close(self) -> None:
        """Close the file; may be called again."""
        self._file.close()


def read_alarms(path: str | Path) -> tuple[AlarmRow, ...]:
    """The alarms of a recording, in order; a recording without the file has none.

    Raises UsageError with ``file:line`` for a row that is none; a last one that was cut off is left out.
    """
    if not Path(path).exists():
        return ()
    rows: list[AlarmRow] = []
    for line in read_lines(path):
        if not line.complete:
            break
        fields = next(csv.reader([line.text]), [])
        if line.number == 1 and tuple(fields) == COLUMNS:
            continue
        try:
            time_s, event, text = fields
            rows.append(AlarmRow(line.seconds(time_s, rows[-1].time_s if rows else 0.0), event, text))
        except (ValueError, UsageError):
            raise line.fault(f"This is no row of {','.join(COLUMNS)}.") from None
    return tuple(rows)
