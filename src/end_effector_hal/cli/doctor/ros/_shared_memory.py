"""What dead processes left in the shared memory of Fast DDS. It is only told: nothing is removed."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.cli.doctor._check_result import CheckedPart, CheckResults
from end_effector_hal.wires import holders_of

FOLDER = Path("/dev/shm")
_LOCKS = ("fastrtps_*_el", "fastdds_*_el")
"""A process locks such a file as long as it uses what stands beside it under the same name."""
_say = CheckedPart("ros")


def look_at_shared_memory(folder: Path = FOLDER) -> CheckResults:
    """Segments and ports whose lock nobody holds: they take memory, and a later process may stumble over them."""
    locks = [path for pattern in _LOCKS for path in sorted(folder.glob(pattern))]
    dead = [path for path in locks if not holders_of(path, own=True)]
    if not dead:
        return
    size = sum(_size(path.with_name(path.name.removesuffix("_el"))) for path in dead)
    names = [path.name.removesuffix("_el") for path in dead]
    yield _say.warning(
        f"left in {folder} by processes of Fast DDS that died: {names[0]}"
        f"{f' and {len(names) - 1} more' if names[1:] else ''} ({size / 1e6:.1f} MB)",
        "As the user whose files they are: fastdds shm clean; it leaves alone what is in use.",
    )


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0
