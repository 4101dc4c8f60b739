"""Of the kernels that were built, the newest stays, and those that somebody uses."""

from __future__ import annotations

import fcntl
import subprocess
from pathlib import Path

SCRIPT = Path(__file__).with_name("forget-others.sh")


def test_others_are_removed_but_not_one_in_use(tmp_path: Path) -> None:
    new, used, old = (tmp_path / f"linux-6.1.{number}-abc" for number in (3, 2, 1))
    for path in (new, used, old, tmp_path / "lock", tmp_path / "build.log"):
        path.write_text("")

    def left() -> set[str]:
        subprocess.run([SCRIPT, new], check=True)
        return {path.name for path in tmp_path.iterdir()}

    with used.open("rb") as user:
        fcntl.flock(user, fcntl.LOCK_SH)
        assert left() == {new.name, used.name, "lock", "build.log"}
    assert left() == {new.name, "lock", "build.log"}
