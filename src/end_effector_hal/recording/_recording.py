"""The recording of a run: its three files, written as it happens."""

from __future__ import annotations

import hashlib
import json
import logging
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from end_effector_hal._closing import Closing
from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description, measures_of, used_channels
from end_effector_hal.errors import ReportedError, os_errors
from end_effector_hal.kinds import kind_of, switch_meanings
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.recording._limits import RecordingLimits
from end_effector_hal.recording._run import RunInfo, read_run
from end_effector_hal.recording.tables import (
    AlarmsWriter,
    ChangerWriter,
    PressuresWriter,
    StatesWriter,
    SwitchesWriter,
)
from end_effector_hal.sensing import Readings
from end_effector_hal.signals import Frame, Kind, Value
from end_effector_hal.vocabulary import ChangerState
from end_effector_hal.wires import now_us


class Losses:
    """Of one folder; not thread-safe.

    Attributes:
        failing: files that could not be written at the last attempt, with the reason.
        gaps: what is missing, a sentence for each time, for run.json.
        info_due: run.json is to be written.
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
        """Write a row that is offered for ``time_s``; False: it was not needed, or cannot be written.

        ``write`` says whether it has proven that the file can be written; ``again``: the row was lost before.
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
        """A file could not be written."""
        self._why = self._why or (error.what if isinstance(error, ReportedError) else str(error))
        self._since_s = time_s if self._since_s is None else self._since_s
        self.failing[name] = str(error)

    def over(self, time_s: float) -> bool:
        """Whether something was lost since this was asked last; then it stands in :attr:`gaps`."""
        if self._since_s is None:
            return False
        if self._rows:
            span = f"From {self._since_s:.3f} s to {time_s:.3f} s"
            self.gaps.append(f"{span} {self._rows} rows of this recording could not be written. {self._why}")
        self._since_s, self._rows, self._why = None, 0, ""
        return True

    def complain(self) -> None:
        """Raise ReportedError, in the words of the first failure, while something cannot be written."""
        if self.failing:
            what = f"The recording lacks rows, and is tried again: {self._why}"
            raise ReportedError(what, where=str(self._folder))


_log = logging.getLogger("end_effector_hal.runtime")
DISTRIBUTION = "end-effector-hal"
MOST_GAPS = 100
"""So many are kept in run.json, the newest."""


class Recording(Closing):
    """Writes ``run.json`` and the tables of a run into a folder; thread-safe.

    Times are µs on the monotonic clock. The first state is the start; what is older is written as of the start. A
    recording that is in the folder already is continued, on its own time.

    While a row cannot be written each call that offers one raises, in the same words; it is tried again with each.
    What was missed then stands in ``run.json``.

    Args:
        folder: made if it is missing.
        tool: its description; or what is known of a tool without one: neither pressures nor switches are recorded then.
        scenario: of the testbench; empty: that of a run.json that is in the folder already.
        seed: of the testbench; None: that of a run.json that is in the folder already.
        ros: the generation of ROS that carries the states; 0: none does.
        limits: of the folder.
        started: when it begins, time of day; None: now.
        now: the time on the monotonic clock, µs.

    Raises:
        UsageError: the folder cannot be written, or holds the recording of another tool.
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
        self._standing: Sequence[str] = ()
        self._changed = ChangerState.UNKNOWN
        before = read_run(self.folder)
        known = tool if isinstance(tool, RunInfo) else run_info(tool)
        with ExitStack() as undo:
            self._states = StatesWriter(self.folder / "states.csv", tuple(known.actuators), limits)
            undo.callback(self._states.close)
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
            channels = () if isinstance(tool, RunInfo) else pressure_channels(tool)
            measures = {} if isinstance(tool, RunInfo) else measures_of(tool)
            units = {name: measures[name].unit for name in channels}
            self._readings = None if isinstance(tool, RunInfo) else Readings(tool, carrier_of(tool))
            self._alarms = AlarmsWriter(self.folder / "alarms.csv", limits)
            undo.callback(self._alarms.close)
            pressures = self.folder / "pressures.csv"
            self._pressures = PressuresWriter(pressures, channels, limits, units) if channels else None
            if self._pressures is not None:
                undo.callback(self._pressures.close)
            switches = () if isinstance(tool, RunInfo) else switch_channels(tool)
            self._levels: Mapping[str, bool | None] = {}
            self._switches = (
                SwitchesWriter(self.folder / "switches.csv", switches, limits) if switches else None
            )
            if self._switches is not None:
                undo.callback(self._switches.close)
            changer = isinstance(tool, RunInfo) or tool.tool_changer is not None
            self._changer = ChangerWriter(self.folder / "tool_changer.csv", limits) if changer else None
            undo.pop_all()

    def state(self, at: int, end_effector: int, command: int, actuators: Sequence[int]) -> bool:
        """The states that hold from ``at`` on; False when they are those of the last row.

        Raises:
            ReportedError: rows cannot be written now.
        """
        with self._lock:
            if self._start is None:
                self._start = max(at, self._begun)
                self._losses.info_due = True
            self._latest = (end_effector, command, actuators)
            written = self._write_state(at)
            self._settle(at)
        return written

    def tool_changer(self, at: int, state: int) -> None:
        """Where the tool changer is from ``at`` on, if there is one.

        Raises:
            ReportedError: rows cannot be written now.
        """
        with self._lock:
            if self._changer is not None and self._start is not None:
                self._changed = ChangerState(state) if state in set(ChangerState) else ChangerState.UNKNOWN
                self._write_changer(at)
                self._settle(at)

    def alarms(self, at: int, alarms: Sequence[str]) -> None:
        """The alarms that stand from ``at`` on; raises ReportedError when rows cannot be written now."""
        with self._lock:
            if self._start is not None:
                self._standing = alarms
                self._write_alarms(at)
                self._settle(at)

    def values(self, at: int, values: Mapping[str, Value]) -> None:
        """What a frame carries that came at ``at``: gauge Pa or a bit, None for invalid.

        A channel that is not in it keeps its value until that is stale: it comes over another link.

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
                self._losses.write("pressures.csv", time_s, lambda: pressures.write(time_s, kpa))
            if switches is not None:
                bits = {name: readings.get(name, at) for name in switches.channels}
                self._levels = {name: None if value is None else bool(value) for name, value in bits.items()}
                self._write_switches(at)
            self._settle(at)

    def note(self, gap: str) -> None:
        """Have ``run.json`` say what is missing, a sentence; it is written with the next row, or when this closes."""
        with self._lock:
            self._losses.gaps.append(gap)
            self._losses.info_due = True

    def close(self) -> None:
        """Close the files; may be called again. What cannot be written any more is told in the log."""
        for each in (self._states, self._alarms, self._pressures, self._switches, self._changer):
            try:
                if each is not None:
                    each.close()
            except ReportedError as error:
                _log.warning("%s", error)
        with suppress(OSError):
            if self._losses.over(self.seconds(self._now())) or self._losses.info_due:
                self._write_info()

    def seconds(self, at: int) -> float:
        """µs on the monotonic clock as seconds since the start of the recording."""
        return max(0, at - (self._start or self._begun)) / 1_000_000

    def _write_state(self, at: int, *, again: bool = False) -> bool:
        assert self._latest is not None
        states, time_s = self._latest, self.seconds(at)
        return self._losses.write(
            "states.csv", time_s, lambda: self._states.write(time_s, *states), again=again
        )

    def _write_alarms(self, at: int, *, again: bool = False) -> None:
        standing, time_s = self._standing, self.seconds(at)
        self._losses.write(
            "alarms.csv", time_s, lambda: self._alarms.write(time_s, standing) or True, again=again
        )

    def _write_changer(self, at: int, *, again: bool = False) -> None:
        writer, state, time_s = self._changer, self._changed, self.seconds(at)
        if writer is not None:
            self._losses.write(
                "tool_changer.csv", time_s, lambda: writer.write(time_s, state) or True, again=again
            )

    def _write_switches(self, at: int, *, again: bool = False) -> None:
        writer, levels, time_s = self._switches, self._levels, self.seconds(at)
        if writer is not None:
            self._losses.write(
                "switches.csv", time_s, lambda: writer.write(time_s, levels) or True, again=again
            )

    def _settle(self, at: int) -> None:
        """Try again what is missing; raises ReportedError while something is."""
        losses = self._losses
        if "states.csv" in losses.failing and self._latest is not None:
            self._write_state(at, again=True)  # a state that lasts comes but once
        if "alarms.csv" in losses.failing:
            self._write_alarms(at, again=True)
        if "switches.csv" in losses.failing:
            self._write_switches(at, again=True)
        if "tool_changer.csv" in losses.failing:
            self._write_changer(at, again=True)
        if not losses.failing and losses.over(self.seconds(at)):
            losses.info_due = True
        if losses.info_due:
            try:
                self._write_info()
            except OSError as error:
                losses.fail("run.json", self.seconds(at), error)
            else:
                losses.info_due = False
                losses.failing.pop("run.json", None)
        losses.complain()

    def _write_info(self) -> None:
        gaps = (*self._info.gaps, *self._losses.gaps)[-MOST_GAPS:]
        replace(self._info, start_us=self._start, gaps=gaps).write(self.folder)


def run_info(
    description: Description, *, scenario: str = "", seed: int | None = None, ros: int = 0
) -> RunInfo:
    """What a recording says of the tool that made it; ``ros``: the generation that carries its states, 0: none."""
    return RunInfo(
        scenario=scenario,
        description=description.name,
        hash=content_hash(description),
        version=product_version(),
        ros=bool(ros),
        ros_generation=ros or None,
        actuators={name: actuator.kind for name, actuator in description.ordered},
        limits={name: _limits(description, actuator) for name, actuator in description.ordered},
        switches=_switches(description),
        simulated=description.lines.backend == "virtual",
        seed=seed,
    )


def content_hash(description: Description) -> str:
    """Twelve hex digits of the tool and its automata: the same wherever its wires lead to."""
    content = description.model_dump(mode="json", by_alias=True)
    return hash_of(content, description.automata_path.read_bytes())


def hash_of(content: Mapping[str, Any], model: bytes) -> str:
    """The same of a description as JSON, every default written out, and of its UPPAAL file."""
    kept: dict[str, Any] = json.loads(json.dumps(content))
    kept.pop("lines", None)
    for link in (kept.get("link"), *(kept.get("links") or {}).values()):
        if link is not None:
            link.pop("port", None)
    if inputs := kept.get("inputs"):
        inputs.pop("iio", None)
    kept["automata"]["file"] = hashlib.sha256(model).hexdigest()
    return hashlib.sha256(json.dumps(kept, sort_keys=True).encode()).hexdigest()[:12]


def pressure_channels(description: Description) -> tuple[str, ...]:
    """Channels of pressures that the link carries: the actuators' in sequence order, then the supply.

    After them the quantities, such as a distance, that the evidence of an actuator looks at.
    """
    carried = carrier_of(description).channels
    wanted = [*(actuator.channel for _, actuator in description.ordered), description.supply.channel]
    pressures = [name for name in dict.fromkeys(wanted) if carried.get(name) is Kind.PRESSURE]
    quantities = [name for name in used_channels(description) if carried.get(name) is Kind.QUANTITY]
    return (*pressures, *quantities)


def switch_channels(description: Description) -> tuple[str, ...]:
    """Bits that are carried and asked for: those of the actuators in sequence order, then of the other devices."""
    carried = carrier_of(description).channels
    return tuple(name for name in used_channels(description) if carried.get(name) is Kind.BIT)


def _switches(description: Description) -> dict[str, dict[str, Any]]:
    """Of those that prove something of an actuator: of which, and what."""
    fitted, found = switch_channels(description), dict[str, dict[str, Any]]()
    for name, part in description.ordered:
        for channel, meaning in switch_meanings(part).items():
            if channel in fitted:
                found.setdefault(channel, {"actuator": name, "on": meaning.on, "off": meaning.off})
    return found


def _limits(description: Description, actuator: Actuator) -> dict[str, Any]:
    return {
        "channel": actuator.channel,
        "kind": actuator.kind,
        "attempts": actuator.attempts,
        **kind_of(actuator).limits(actuator, description.supply),
    }


def _begun(folder: Path) -> datetime | None:
    """When the recording in a folder was begun; None: there is none."""
    try:
        return datetime.fromisoformat(read_run(folder).started) if (folder / "states.csv").exists() else None
    except (ValueError, TypeError):
        return None


def product_version() -> str:
    """Of the installed distribution; empty if it is not installed."""
    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return ""
