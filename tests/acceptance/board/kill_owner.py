"""On the board: an owner of the real lines is killed while it holds two of them; prints what is left."""

from __future__ import annotations

from end_effector_hal.description import load, profile_path
from end_effector_hal.runtime import output_lines
from tests.acceptance.gpiochip.inside.owned import Owner

LINES = sorted(output_lines(load(profile_path())))
HELD = dict.fromkeys(LINES, False) | {"SODIMM_208": True, "SODIMM_212": True}

with Owner(LINES) as owner:
    assert owner.levels() == dict.fromkeys(LINES, False)
    owner.set({line: True for line, level in HELD.items() if level})
    owner.kill()
with Owner(LINES) as owner:
    print("after SIGKILL:", owner.levels())  # noqa: T201 it is what this program is for
    assert owner.levels() == HELD
