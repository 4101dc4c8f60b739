"""The paper's scenarios on a real GPIO chip and a real serial driver: the HAL inside, the testbench outside."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from end_effector_hal.description import Description
from end_effector_hal.recording import StatesLog, read_run, read_states
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo import report_on, scenarios
from end_effector_lab.processes import Children
from end_effector_lab.testbench import edges_of
from tests.acceptance.gpiochip.guest import Ended
from tests.acceptance.gpiochip.machines import Machine
from tests.acceptance.gpiochip.priority import WIRES, before_others
from tests.acceptance.gpiochip.same_story import same_story
from tests.acceptance.gpiochip.virtual_lines import OnVirtualLines

NAMES = ("nominal", "fails-once", "never-confirms")
ROS = [name for name in os.environ.get("EEHAL_GPIOCHIP_ROS", "").split() or NAMES if name != "none"]
"""Those that are played through all nodes, too."""
assert set(ROS) <= set(NAMES), f"EEHAL_GPIOCHIP_ROS: there are none, {', '.join(NAMES)}"
LONGEST_S = 400.0


@dataclass(frozen=True)
class Played:
    """One scenario on a machine, as it stands in its recording; ``faults``: what is not as its story has it."""

    ended: Ended
    log: StatesLog
    faults: list[str]
    stood_still_s: float


def play(machine: Machine, tool: Description, name: str, folder: Path, place: Path, *, ros: bool) -> Played:
    """One scenario; its recording stays in ``folder``, its sockets are made in ``place``."""
    (scenario,) = (each for each in scenarios(tool) if each.name == name)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    description = folder / "end_effector.yaml"
    port = tool.link.port
    description.write_text(tool.source.read_text().replace(f"port: {port}", f"port: {machine.port(place)}"))
    with Children() as children:
        testbench = children.start(
            "testbench",
            [
                *before_others(WIRES), *machine.testbench(place), str(description), "--scenario", scenario.bench,
                "--port", f"pty:{place / 'uart'}",
                "--events", str(place / "events"),
            ],
            log=folder / "testbench.log",
            commands=True,
        )  # fmt: skip
        testbench.wait_until(lambda: "ready:" in testbench.text(), timeout_s=60, what="it was ready")
        options = f"--own-wires --no-figures --only {name}" + ("" if ros else " --no-ros")
        ended = machine.run(place, folder, f"eehal demo {description} {options} -o $RESULTS/demo", LONGEST_S)
    shutil.move(place / "events", folder)
    # 1: a time-out was not within 100 ms after its nominal time, as the demo asks of a machine of its own
    assert ended.code in (0, 1), ended.console + ended.output
    recorded = folder / "demo" / name
    log, info = read_states(recorded / "states.csv"), read_run(recorded)
    report = report_on(scenario, tool, recorded, edges_of(folder / "events"), figures=True)
    faults = [str(finding) for finding in report.findings if not finding.ok]
    begin_s = next((row.time_s for row in log.rows if row.end_effector == EndEffectorState.GRIPPING), 0.0)
    end_s = log.rows[-1].time_s if begin_s else 1e6
    start_us = info.start_us or 0
    stood_still_s = ended.longest_stall_s(start_us + round(begin_s * 1e6), start_us + round(end_s * 1e6))
    return Played(ended, log, faults, stood_still_s)


@pytest.fixture
def say(capsys: pytest.CaptureFixture[str]) -> Callable[[str], None]:
    """To the terminal, whatever pytest captures."""

    def say(text: str) -> None:
        with capsys.disabled():
            print(f"\n{text}", end="", flush=True)  # noqa: T201 asked for

    return say


@pytest.mark.parametrize(
    ("name", "ros"),
    [pytest.param(name, ros, id=f"{name}-{'ros' if ros else 'core'}")
     for ros, names in ((False, NAMES), (True, ROS)) for name in names],
)  # fmt: skip
def test_a_scenario_tells_the_same_story_as_on_virtual_lines(
    machine: Machine,
    runs: Path,
    place: Path,
    on_virtual_lines: dict[bool, OnVirtualLines],
    name: str,
    ros: bool,
    say: Callable[[str], None],
) -> None:
    virtual = on_virtual_lines[ros]
    what = f"{name} {'through ROS' if ros else 'without ROS'} on {machine.name}"

    def once() -> tuple[Played, str, float]:
        reference = virtual.recording(name)
        played = play(machine, virtual.tool, name, runs / ("ros" if ros else "core") / name, place, ros=ros)
        try:
            return played, "", same_story(reference, played.log)
        except AssertionError as error:
            virtual.forget(name)  # it may be the one that was disturbed
            return played, f"another story on virtual lines: {error}", 0.0

    played, other, worst_s = once()
    if (played.faults and played.stood_still_s) or (other and not played.faults):
        # A HAL that does not get its share of the processor refuses to work, rightly.
        still_ms = played.stood_still_s * 1000
        say(f"{what}: played once more (it stood still for {still_ms:.0f} ms): {[*played.faults, other]}")
        played, other, worst_s = once()
        if ros and played.stood_still_s and (played.faults or other):
            # one processor for all nodes, and a call of the kernel costs five times as much as outside
            pytest.skip(f"This machine is too slow for all nodes in the guest: {[*played.faults, other]}")
    assert (played.faults, other) == ([], ""), played.ended.console + played.ended.output
    say(
        f"{what}: each step as long as on virtual lines within {worst_s * 1000:.0f} ms; "
        f"longest standstill {played.stood_still_s * 1000:.0f} ms; {played.ended.seconds:.0f} s in all "
    )
