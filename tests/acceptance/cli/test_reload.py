"""A changed description: checked first, taken over at rest only, and never what the line arbiter was started with."""

from __future__ import annotations

import subprocess
import sys

import pytest

from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import wait_until
from tests.support.terminal import Terminal

pytestmark = [pytest.mark.wall, pytest.mark.timeout(180)]


def asked(world: World, *restart: str) -> tuple[int, str]:
    command = [*EEHAL, "reload", str(world.description_path), *(["--", *restart] if restart else [])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def edit(world: World, before: str, after: str) -> None:
    text = world.description_path.read_text()
    assert before in text
    world.description_path.write_text(text.replace(before, after))


def test_a_description_is_taken_over_at_rest_and_a_held_part_keeps_the_old_one(
    world: World, terminal: Terminal
) -> None:
    original = world.description_path.read_text()
    terminal.type("lock\n")
    at = terminal.read_until("LOCK: succeeded")

    def grips() -> bool:
        nonlocal at
        terminal.type("grip\n")
        at = terminal.read_until("GRIP: succeeded|GRIP: failed|refused: grip", after=at)
        return "GRIP: succeeded" in terminal.text[at - 20 : at]

    wait_until("a grip", grips)
    edit(
        world, "SODIMM_208", "SODIMM_209"
    )  # what the line arbiter would refuse: drop first, before anything else
    terminal.type("reload\n")
    at = terminal.read_until(
        r"refused: reload\. A part is held: drop it first\. The description that runs stays", after=at
    )
    code, said = asked(world)
    assert (code, "A part is held" in said) == (1, True), said
    terminal.type("drop\n")
    at = terminal.read_until("DROP: succeeded", after=at)
    world.description_path.write_text(f"{original}\nnot_a_key: 1\n")
    terminal.type("reload\n")
    at = terminal.read_until("refused: reload.*unknown key 'not_a_key'", after=at)
    assert asked(world)[0] == 2
    world.description_path.write_text(original)
    edit(world, "SODIMM_208", "SODIMM_209")
    terminal.type("reload\n")
    at = terminal.read_until("refused: reload. Only a restart of the line arbiter can change", after=at)
    code, said = asked(world)
    assert (code, "the output lines" in said) == (1, True), said
    world.description_path.write_text(original)
    edit(world, "timeout_s: 5", "timeout_s: 4")
    assert asked(world)[0] == 0
    assert asked(world, "false")[0] == 1, "what was to start it again has failed: they go on"
    granted = asked(world, sys.executable, "-c", "raise SystemExit(0)")
    assert granted[0] == 0
    terminal.type("grip\n")
    at = terminal.read_until("refused: grip. Another description is about to be taken over", after=at)
    terminal.type("reload\n")
    at = terminal.read_until("RELOAD: succeeded", after=at)
    at = terminal.read_until("OFF -> STAND_BY", after=at)
    terminal.type("lock\n")
    at = terminal.read_until("LOCK: succeeded", after=at)
    terminal.type("grip\n")
    terminal.read_until("STAND_BY -> GRIPPING|refused: grip. IL", after=at)
