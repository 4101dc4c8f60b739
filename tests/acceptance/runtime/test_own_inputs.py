"""Inputs on which interlocks rest and that are lines of the board: the line arbiter reads them itself."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient, PredicateSender
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.errors import LineRefusedError
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import Claim, now_us
from end_effector_hal.wires.lines import read_chip
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
TOOL = Path(__file__).parents[3] / "examples/tools/two_coil_changer/end_effector.yaml"
JAW, UNLOCK, E_STOP = "GPIO5", "GPIO12", "GPIO26"
READY_S = 30.0


def with_e_stop(folder: Path) -> Description:
    """The example, and an e-stop whose contact opens."""
    text = TOOL.read_text().replace("channels:\n", f"channels:\n  stop: {{digital: {{line: {E_STOP}}}}}\n")
    path = folder / "tool.yaml"
    path.write_text(f"{text}\ne_stop: {{channel: stop}}\n")
    return load_tool(path).with_virtual(folder / "chip", str(folder / "uart"))


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    with World(with_e_stop(tmp_path), "nominal", tmp_path) as running:
        yield running


def told(world: World) -> dict[str, dict[str, object]]:
    with ArbiterClient(world.socket, "look") as look:
        return dict(look.status()["told"])


def holds(world: World, predicate: str) -> bool:
    return bool(told(world).get(predicate, {}).get("holds"))


def refusal(client: ArbiterClient, line: str) -> str:
    with pytest.raises(LineRefusedError) as caught:
        client.set({line: True})
    return str(caught.value)


def active(world: World, line: str) -> bool:
    return bool(read_chip(world.chip).lines[line].level)


def test_no_program_runs_and_the_arbiter_knows_what_its_lines_show(world: World) -> None:
    wait_until("it is read", lambda: holds(world, "locked") and holds(world, "e_stop_closed"))
    assert "nothing_gripped" not in told(world)  # the jaw's switches are no affair of the arbiter
    with ArbiterClient(world.socket, "hand", [JAW, UNLOCK]) as hand:
        hand.set({UNLOCK: False})  # of its two coils none was active: in doubt it counted as active
        assert "no process that reads the sensors has reported yet" in refusal(hand, UNLOCK)
        wait_until("the jaw closes", lambda: hand.set({JAW: True}) is not None)


def test_an_e_stop_that_opens_refuses_at_once_and_until_a_reset_and_releases_nothing(world: World) -> None:
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(READY_S)
        wait_until("it is locked", lambda: tool.lock().succeeded)
        wait_until("a grip", lambda: tool.grip().succeeded)
        world.choose("estop-open")
        wait_until(
            "it is latched", lambda: "IL-13: the emergency stop was opened." in tool.status.alarm_texts
        )
        assert tool.status.ee == EndEffectorState.GRIPPED
        assert active(world, JAW)
        assert not tool.reset().accepted
        world.choose("nominal")
        wait_until("it is closed", lambda: holds(world, "e_stop_closed"))
        assert tool.drop().succeeded
        failed = tool.grip()
        assert failed.reason.startswith("IL-13: the emergency stop was opened. Nothing is activated until")
        assert tool.reset().accepted
        wait_until("a grip", lambda: tool.grip().succeeded)


def test_what_a_process_claims_of_them_is_not_believed(world: World) -> None:
    world.choose("estop-open")
    wait_until("it is read", lambda: told(world).get("e_stop_closed", {}).get("holds") is False)
    liar = PredicateSender(world.socket)
    for _ in range(5):
        liar.send({"e_stop_closed": True, "locked": True}, now_us())
    liar.close()
    with ArbiterClient(world.socket, "hand", [JAW, UNLOCK]) as hand:
        hand.set({UNLOCK: False})  # nobody knew how the changer stands
        wait_until("its pause is over (IL-10)", lambda: hand.levels().get(UNLOCK) is False)
        wait_until("it is locked", lambda: holds(world, "locked"))
        assert "IL-13: GPIO5 (jaw) is not activated: the emergency stop is open" in refusal(hand, JAW)


def test_programs_see_the_same_and_see_it_again_after_the_arbiter_was_killed(
    world: World, tmp_path: Path
) -> None:
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(READY_S)
        wait_until("it is locked", lambda: tool.lock().succeeded)
        wait_until("a grip", lambda: tool.grip().succeeded)
        with ArbiterClient(world.socket, "test") as observer:
            os.kill(observer.status()["pid"], signal.SIGKILL)
        wait_until("the alarm", lambda: "the line arbiter" in str(tool.inputs))
        assert active(world, JAW)
        again = world.children.start(
            "again", [*EEHAL, "arbiter", str(world.description_path)], log=tmp_path / "again.log"
        )
        again.wait_until(lambda: "ready:" in again.text(), timeout_s=PATIENCE_S, what="it was ready")
        wait_until("they are read again", lambda: tool.inputs is not None and not tool.inputs.error)
        assert tool.status.ee == EndEffectorState.GRIPPED
        wait_until("a drop", lambda: tool.drop().succeeded)
        wait_until("a grip", lambda: tool.grip().succeeded)


def test_lines_that_somebody_else_has_refuse_in_words_until_the_arbiter_has_them(tmp_path: Path) -> None:
    running = World(with_e_stop(tmp_path), "nominal", tmp_path)
    claim = Claim(f"{running.chip}.arbiter.lock", "an input line of the virtual chip")
    with running as world, ArbiterClient(world.socket, "hand", [JAW, UNLOCK]) as hand:
        hand.set({UNLOCK: False})  # nobody knew how the changer stands
        wait_until("its pause is over (IL-10)", lambda: hand.levels().get(UNLOCK) is False)
        words = "IL-05: GPIO5 (jaw) is not activated: so far the line arbiter could not read whether the tool is locked"
        said = refusal(hand, JAW)
        assert words in said
        assert "is held by" in said
        assert not told(world)
        claim.release()
        wait_until("it is read", lambda: holds(world, "locked") and holds(world, "e_stop_closed"))
        hand.set({JAW: True})


def listened(world: World) -> str:
    command = [*EEHAL, "listen", str(world.description_path), "--seconds", "1.5"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    return ended.stdout


def test_whoever_listens_hears_them_from_the_arbiter_and_the_others_without_it(world: World) -> None:
    wait_until("it is read", lambda: holds(world, "locked"))
    heard = listened(world)
    assert " changer_locked yes" in heard
    assert " jaw_open " in heard
    world.arbiter.end(signal_number=signal.SIGKILL)
    heard = listened(world)
    assert " jaw_open " in heard
    assert "changer_locked" not in heard
