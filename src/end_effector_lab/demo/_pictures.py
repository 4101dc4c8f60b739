"""The figures of a recording."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.recording import RunInfo, StatesLog, read_alarms, read_pressures
from end_effector_hal.verification.replay import missed_moments
from end_effector_lab.figures import paper, save, timeline


def draw(folder: Path, log: StatesLog, info: RunInfo) -> list[Path]:
    """Draw ``timeline`` and ``paper``, each as PNG and SVG, into the folder of the recording."""
    pressures = read_pressures(folder / "pressures.csv") if (folder / "pressures.csv").exists() else None
    missed, _ = missed_moments(folder)
    alarms = read_alarms(folder / "alarms.csv")
    figures = {
        "timeline": timeline(log, pressures, info, alarms, missed),
        "paper": paper(log, info),
    }
    return [
        save(figure, folder / f"{name}.{suffix}")
        for name, figure in figures.items()
        for suffix in ("png", "svg")
    ]
