"""``run.json``: where a recording comes from, written at its start."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

FILE_NAME = "run.json"


@dataclass(frozen=True)
class RunInfo:
    """What a figure says about a run besides its states.

    Args:
        scenario: of the testbench; empty on real hardware.
        description: name of the tool.
        hash: of the description and its automata.
        version: of this product.
        ros: whether ROS carried the states.
        started: ISO 8601 time.
        actuators: name -> kind (``vacuum``, ``cylinder``).
        limits: actuator -> its channel, kind and thresholds (``confirmed_kpa``: vacuum below ambient,
        cylinder gauge)
            and its ``attempts``; what is missing is not drawn.
        simulated: whether a testbench answered; None: when a scenario is named.
        start_us: time zero of the recording, µs on the monotonic clock of its traces.
    """

    scenario: str = ""
    description: str = ""
    hash: str = ""
    version: str = ""
    ros: bool = False
    started: str = ""
    actuators: Mapping[str, str] = field(default_factory=dict)
    limits: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    simulated: bool | None = None
    start_us: int | None = None

    def write(self, folder: str | Path) -> Path:
        """Write ``run.json`` into a folder, whole or not at all."""
        path = Path(folder) / FILE_NAME
        content = {item.name: getattr(self, item.name) for item in fields(self)}
        content["actuators"] = dict(self.actuators)
        content["limits"] = {name: dict(limit) for name, limit in self.limits.items()}
        beside = path.with_name(f".{FILE_NAME}.{os.getpid()}")
        with beside.open("w", encoding="utf-8") as file:
            file.write(json.dumps(content, indent=2, ensure_ascii=False) + "\n")
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
        return path

    def attempts(self, actuator: str) -> int | None:
        """How many failed attempts abort, when the run says so."""
        number = self.limits.get(actuator, {}).get("attempts")
        return number if isinstance(number, int) and not isinstance(number, bool) and number > 0 else None


def read_run(path: str | Path) -> RunInfo:
    """Read a ``run.json``, or that of a folder; whatever is missing or unusable is left at its default."""
    path = Path(path)
    try:
        if path.is_dir():
            path = path / FILE_NAME
        content = json.loads(path.read_text(encoding="utf-8", errors="replace"))
    except (OSError, ValueError, RecursionError):
        return RunInfo()
    if not isinstance(content, dict):
        return RunInfo()
    texts = ("scenario", "description", "hash", "version", "started")
    actuators, limits = content.get("actuators"), content.get("limits")
    simulated, start_us = content.get("simulated"), content.get("start_us")
    return RunInfo(
        **{key: value for key in texts if isinstance(value := content.get(key), str)},
        ros=content.get("ros") is True,
        actuators=_only(actuators, str),
        limits=_only(limits, dict),
        simulated=simulated if isinstance(simulated, bool) else None,
        start_us=start_us if isinstance(start_us, int) else None,
    )


def _only(value: object, kind: type) -> dict[str, Any]:
    return (
        {key: item for key, item in value.items() if isinstance(item, kind)}
        if isinstance(value, dict)
        else {}
    )
