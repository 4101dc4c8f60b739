"""The paper's gripper with two parts: a panel that everything grips, and a box for the cups below."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description import Description, load, profile_path

PARTS = """
parts:
  panel:
    summary: 600 × 400 mm, 4 kg
  box:
    uses: [bottom_vacuum]
    actuators:
      bottom_vacuum: {confirmed_kpa: 40.0, lost_kpa: 30.0, timeout_s: 2.0, attempts: 2}
"""


def gripper_with_parts(folder: Path) -> Description:
    """Write the gripper with its two parts into a folder, and load it."""
    path = folder / "end_effector.yaml"
    path.write_text(profile_path().read_text() + PARTS)
    return load(path)
