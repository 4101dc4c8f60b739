"""The recording of a run: its three files, written as it happens."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from end_effector_hal.description import Actuator, Description
from end_effector_hal.errors import UsageError
from end_effector_hal.trace import AlarmsWriter, PressuresWriter, RunInfo, StatesWriter, read_run
from end_effector_hal.wires import Kind, Value, get_codec, now_us

DISTRIBUTION = "end-effector-hal"


class Recording:
    """Writes ``run.json``, ``states.csv``, ``alarms.csv`` and ``pressures.csv`` into a folder; thread-safe.

    Times are µs on the monotonic clock. The first state is the start; what is older is written as of the start. A
    recording that is in the folder already is continued, on its own time.

    Args:
        folder: made if it is missing.
        description: the tool.
        scenario: of the testbench; empty: that of a run.json that is in the folder already.
        ros: whether ROS carries the states.

    Raises:
        UsageError: the folder cannot be written, or holds the recording of another tool.
    """

    def __init__(
        self, folder: str | Path, description: Description, *, scenario: str = "", ros: bool = False
    ) -> None:
        self.folder = Path(folder)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"The folder cannot be made: {error.strerror}.", where=str(folder)) from None
        begun, now = _begun(self.folder), datetime.now(UTC)
        self._begun = now_us() - round((now - (begun or now)).total_seconds() * 1_000_000)
        self._start = self._begun if begun else None
        self._states = StatesWriter(self.folder / "states.csv", description.sequence)
        try:
            self._info = run_info(
                description,
                scenario=scenario or read_run(self.folder).scenario,
                ros=ros,
                started=(begun or now).isoformat(),
            )
            self._write_info()
            channels = pressure_channels(description)
            self._alarms = AlarmsWriter(self.folder / "alarms.csv")
            self._pressures = PressuresWriter(self.folder / "pressures.csv", channels) if channels else None
        except BaseException:
            self._states.close()
            raise

    def state(self, at: int, end_effector: int, command: int, actuators: Sequence[int]) -> bool:
        """The states that hold from ``at`` on; False when they are those of the last row."""
        if self._start is None:
            self._start = max(at, self._begun)
            self._write_info()
        return self._states.write(self.seconds(at), end_effector, command, actuators)

    def alarms(self, at: int, alarms: Sequence[str]) -> None:
        """The alarms that stand from ``at`` on."""
        if self._start is not None:
            self._alarms.write(self.seconds(at), alarms)

    def values(self, at: int, values: Mapping[str, Value]) -> None:
        """What the channels carry at ``at``: gauge Pa, None for invalid; bits are not recorded."""
        if self._pressures is not None and self._start is not None:
            self._pressures.write(
                self.seconds(at),
                {name: None if value is None else value / 1000 for name, value in values.items()},
            )

    def close(self) -> None:
        """Close the files; may be called again."""
        self._states.close()
        self._alarms.close()
        if self._pressures is not None:
            self._pressures.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def seconds(self, at: int) -> float:
        """µs on the monotonic clock as seconds since the start of the recording."""
        return max(0, at - (self._start or self._begun)) / 1_000_000

    def _write_info(self) -> None:
        replace(self._info, start_us=self._start).write(self.folder)


def run_info(
    description: Description, *, scenario: str = "", ros: bool = False, started: str = ""
) -> RunInfo:
    """What a recording says of the tool that made it."""
    return RunInfo(
        scenario=scenario,
        description=description.name,
        hash=content_hash(description),
        version=product_version(),
        ros=ros,
        started=started,
        actuators={name: actuator.kind for name, actuator in description.ordered},
        limits={name: _limits(description, actuator) for name, actuator in description.ordered},
        simulated=description.lines.backend == "virtual",
    )


def content_hash(description: Description) -> str:
    """Twelve hex digits of the tool and its automata: the same wherever its wires lead to."""
    content = description.model_dump(mode="json", by_alias=True, exclude={"lines": True, "link": {"port"}})
    content["automata"]["file"] = hashlib.sha256(description.automata_path.read_bytes()).hexdigest()
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:12]


def pressure_channels(description: Description) -> tuple[str, ...]:
    """Channels of pressures that the link carries: the actuators' in sequence order, then the supply."""
    carried = get_codec(description.link.codec).channels
    wanted = [*(actuator.channel for _, actuator in description.ordered), description.supply.channel]
    return tuple(name for name in dict.fromkeys(wanted) if carried.get(name) is Kind.PRESSURE)


def _limits(description: Description, actuator: Actuator) -> dict[str, Any]:
    limits: dict[str, Any] = {
        "channel": actuator.channel,
        "kind": actuator.kind,
        "attempts": actuator.attempts,
    }
    if actuator.kind == "vacuum":
        return limits | {name: getattr(actuator, name) for name in ("confirmed_kpa", "gone_kpa", "lost_kpa")}
    extended_kpa = actuator.extended_fraction * description.supply.nominal_kpa
    return limits | {"confirmed_kpa": extended_kpa, "gone_kpa": actuator.retracted_kpa}


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
