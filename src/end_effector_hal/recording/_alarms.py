"""``alarms.csv``: a row when an alarm begins, when its cause has ended, and when it is no longer shown."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import Alarm, alarm_changes, received_alarms

from ._files import RecordingLimits
from ._rows import TableWriter, read_lines

COLUMNS = ("time_s", "event", "id", "about", "alarm")
BEGUN, OVER, ENDED = "begun", "over", "ended"


@dataclass(frozen=True, slots=True)
class AlarmRow:
    """One change of an alarm; seconds since the start of the recording.

    Attributes:
        event: ``begun``; ``over``: its cause has ended and it waits for an acknowledgement; ``ended``: it is no longer
            shown.
    """

    time_s: float
    event: str
    text: str
    id: str = ""
    about: str = ""

    @property
    def key(self) -> tuple[str, str]:
        """The identity of the alarm."""
        return (self.id, self.about) if self.id else ("", self.text)

    def as_alarm(self) -> Alarm:
        """Return the alarm of this row, with the sentence of the row."""
        name = ("over:" if self.event == OVER else "") + self.id + (f":{self.about}" if self.about else "")
        return received_alarms([self.text], [name])[0]

    @property
    def title(self) -> str:
        """First words of the alarm, for a figure."""
        return self.text.split(":")[0].split(" (")[0].rstrip(".")


def changed_alarms(time_s: float, before: Sequence[Alarm], now: Sequence[Alarm]) -> list[AlarmRow]:
    """Return rows for the alarms that have ended, then for those that have begun or are over."""
    return [
        AlarmRow(time_s, change, alarm.text, alarm.id, alarm.about)
        for alarm, change in alarm_changes(before, now)
    ]


class AlarmsWriter(TableWriter[AlarmRow]):
    """Writes the changes of the alarms of a state; thread-safe.

    Raises:
        UsageError: the file cannot be written, or is another kind of file.
    """

    def __init__(self, path: str | Path, limits: RecordingLimits | None = None) -> None:
        self._shown: tuple[Alarm, ...] = ()
        self._last_s = 0.0
        super().__init__(path, COLUMNS, limits)

    def write(self, time_s: float, alarms: Sequence[Alarm]) -> bool:
        """Write the changes to the alarms that are active from ``time_s`` on; return whether there are any.

        Raises:
            ReportedError: the row cannot be written; the next successful call writes it.
        """
        with self._lock:
            self._last_s = max(time_s, self._last_s)
            rows = changed_alarms(self._last_s, self._shown, alarms)
            if not rows:
                return False
            self._file.append("".join(map(self._text, rows)))
            self._shown = tuple(alarms)
        return True

    def _opening(self) -> str:
        return "".join(map(self._text, changed_alarms(self._last_s, (), self._shown)))

    def _text(self, row: AlarmRow) -> str:
        line = io.StringIO()
        text, about = " ".join(row.text.split()), " ".join(row.about.split())
        csv.writer(line, lineterminator="\n").writerow((f"{row.time_s:.6f}", row.event, row.id, about, text))
        return line.getvalue()


def read_alarms(path: str | Path) -> tuple[AlarmRow, ...]:
    """Return the alarms of a recording, in order; a recording without the file has none.

    Raises UsageError with ``file:line`` for an invalid row; a truncated last row is left out.
    """
    if not Path(path).exists():
        return ()
    rows: list[AlarmRow] = []
    standing: set[tuple[str, str]] = set()
    first = ""
    for line in read_lines(path):
        if not line.complete:
            break
        first = first or line.path
        try:
            fields = next(csv.reader([line.text]), [])
            if line.number == 1 and tuple(fields) == COLUMNS:
                continue
            time_s, event, id_, about, text = fields
            row = AlarmRow(line.seconds(time_s, rows[-1].time_s if rows else 0.0), event, text, id_, about)
        except (ValueError, UsageError, csv.Error):
            raise line.fault(f"This is not a row of {','.join(COLUMNS)}.") from None
        repeated = line.path != first and event != ENDED and row.key in standing
        if not repeated:  # a segment begins with what stands then
            rows.append(row)
        (standing.discard if event == ENDED else standing.add)(row.key)
    return tuple(rows)
