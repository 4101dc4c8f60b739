"""Decide which folders a run of the model may be written to: it never replaces a recording of a tool."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.errors import UsageError, os_errors

from ._run import FILE_NAME, read_run

MODEL_RUN = "run of the model"
"""First words of the scenario of a simulated run of the model."""
COUNTEREXAMPLE = "counterexample"
"""Scenario of a run that refutes a requirement."""
_RECORDED = ("*.mcap", "states*.csv", "events*.csv", "pressures*.csv", "alarms*.csv")


def check_replaceable(folder: Path) -> None:
    """Check that a run of the model may be written into a folder, where it may replace files of the same names.

    Args:
        folder: need not exist.

    Raises:
        UsageError: the folder contains a recording, or cannot be read.
    """
    with os_errors("Cannot be read", folder):
        recorded = [each for pattern in _RECORDED for each in folder.glob(pattern)]
        has_run = (folder / FILE_NAME).exists()
    scenario = read_run(folder).scenario
    of_model = scenario == COUNTEREXAMPLE or scenario.startswith(MODEL_RUN)
    if any(each.suffix == ".mcap" for each in recorded) or ((recorded or has_run) and not of_model):
        what = "This folder contains a recording: a run of the model would overwrite its files."
        raise UsageError(what, where=str(folder), todo="Name another folder with -o.")
