"""The container image, as it was built: what is in it, who runs it, and one grip against the testbench outside of it.

In the order of the file: the container is not started, then its line arbiter runs, then the nodes run, too.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.wires.lines import VirtualChip
from end_effector_lab.processes import Child
from tests.acceptance.image.box import Box
from tests.acceptance.image.conftest import Image

TOOL = load(profile_path())
IMPORTS = "import end_effector_hal.runtime, gpiod, pydantic_core, pymodbus, {0}; print(gpiod.api_version, {1}.__name__)"
MESSAGES = {
    False: ("rospy, actionlib, end_effector_msgs.msg as msg", "msg.EndEffectorGoal"),
    True: ("rclpy, end_effector_msgs.action as action", "action.EndEffector"),
}
"""Of ROS 2 or not."""


def well(done: subprocess.CompletedProcess[str]) -> str:
    """What it has printed; it must have ended with 0."""
    assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def test_its_user_is_in_gpio_and_dialout_and_may_do_nothing_else(box: Box) -> None:
    assert box.config["User"] == "eehal"
    assert well(box.run("id", "-nG")).split() == ["gpio", "dialout"]
    assert well(box.run("id", "-G")).split() == ["49", "20"]
    assert "CapEff:\t0000000000000000" in well(box.run("cat", "/proc/self/status"))
    assert box.run("touch", "/opt/eehal/bin/eehal").returncode != 0


def test_what_it_needs_can_be_imported(box: Box, image: Image) -> None:
    imports = IMPORTS.format(*MESSAGES[image.ros2])
    said = well(box.run("eehal-container", "python", "-c", imports)).split()[1]
    assert said == MESSAGES[image.ros2][1].partition(".")[2]


def test_figures_are_drawn_elsewhere(box: Box) -> None:
    done = box.run("eehal", "model", "show")
    assert (done.returncode, "pip install '.[lab]'" in done.stderr) == (2, True)


def test_nothing_is_compiled_again_at_each_start(box: Box) -> None:
    """Its root is read-only: what is not compiled in the image never is."""
    import_it = (
        "import end_effector_hal.wires as it; from pathlib import Path; print(Path(it.__cached__).exists())"
    )
    assert well(box.run("python", "-c", import_it)).split() == ["True"]


def test_it_checks_the_shipped_tool_and_the_one_on_the_bench(box: Box) -> None:
    well(box.run("eehal", "check"))
    well(box.run("eehal", "check", "/bench/end_effector.yaml"))


def test_the_doctor_hears_the_testbench_through_the_groups(box: Box) -> None:
    parts = "python,description,lines,link"
    told = json.loads(well(box.run("eehal", "doctor", "/bench/end_effector.yaml", "--json", "--only", parts)))
    assert {finding["part"] for finding in told["findings"]} == set(parts.split(","))
    assert [finding for finding in told["findings"] if finding["status"] == "missing"] == []


def health(box: Box, parts: str) -> int:
    """Exit code of the image's health check, on what compose.yaml names for a container."""
    kind, *command = box.config["Healthcheck"]["Test"]
    assert (kind, command) == ("CMD-SHELL", ["eehal-healthy"])
    return box.run(*command, env={"EEHAL_HEALTH": parts}).returncode


ARBITER, HAL = "description,lines,arbiter", "description,ros,arbiter,link"


def test_it_is_not_healthy_before_anything_runs(box: Box) -> None:
    assert (health(box, ARBITER), health(box, HAL)) == (3, 3)


@pytest.fixture(scope="module")
def arbiter(box: Box) -> Child:
    """The line arbiter, by the entry that the image declares."""
    assert box.config["Cmd"] == ["arbiter"]
    child = box.start("arbiter", *box.config["Entrypoint"], *box.config["Cmd"])
    child.wait_until(lambda: health(box, ARBITER) == 0, timeout_s=box.limit_s, what="its health")
    return child


def edges(bench: Path) -> list[tuple[str, bool]]:
    """Every write to the chip after the arbiter has taken its lines."""
    records = [json.loads(line) for line in (bench / "chip").read_text().splitlines() if line.strip()]
    written = [(record["line"], bool(record["level"])) for record in records if "line" in record]
    return written[len(TOOL.output_lines) :]


GRIPPING = [actuator.line for _, actuator in TOOL.ordered]
ONE_GRIP_AND_DROP = [*((line, True) for line in GRIPPING), *((line, False) for line in reversed(GRIPPING))]


def test_one_grip_and_drop_without_ros(box: Box, bench: Path, arbiter: Child) -> None:
    before = len(edges(bench))
    said = well(box.run("eehal", "run", "/bench/end_effector.yaml", "--script", "grip; drop"))
    assert "GRIP: succeeded" in said
    assert edges(bench)[before:] == ONE_GRIP_AND_DROP
    assert not any(state.level for state in VirtualChip(bench / "chip").read().lines.values())
    assert arbiter.code is None


def test_one_grip_and_drop_through_the_nodes(box: Box, image: Image, bench: Path, arbiter: Child) -> None:
    before = len(edges(bench))
    entry = box.config["Entrypoint"]
    if image.ros2:
        nodes = box.start("hal", *entry, "hal")
        said = well(box.run("eehal-hal-ros2", "supervisor", "-p", "script:=grip; drop"))
    else:
        nodes = box.start("hal", *entry, "hal", "supervisor:=script", "script:=grip; drop")
        nodes.wait_until(
            lambda: "process has finished" in nodes.text(), timeout_s=box.limit_s, what="its script's end"
        )
        said = nodes.text()
    assert "grip: SUCCEEDED" in said, said
    assert "release: SUCCEEDED" in said, said
    assert edges(bench)[before:] == ONE_GRIP_AND_DROP
    nodes.wait_until(lambda: health(box, HAL) == 0, timeout_s=box.limit_s, what="its health")
    assert arbiter.code is None
