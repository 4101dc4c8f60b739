"""On the board: an arbiter of the real lines is killed while it holds two of them; prints what is left."""

from __future__ import annotations

from end_effector_hal.description import load, profile_path
from tests.acceptance.gpiochip.inside.owned import Arbiter

LINES = sorted(load(profile_path()).output_lines)
HELD = dict.fromkeys(LINES, False) | {"SODIMM_208": True, "SODIMM_212": True}

with Arbiter(LINES) as arbiter:
    assert arbiter.levels() == dict.fromkeys(LINES, False)
    arbiter.set({line: True for line, level in HELD.items() if level})
    arbiter.kill()
with Arbiter(LINES) as arbiter:
    print("after SIGKILL:", arbiter.levels())  # noqa: T201 it is what this program is for
    assert arbiter.levels() == HELD
