"""How a program starts: with one tool, in words where its parameters are wrong or missing; never with a traceback."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from end_effector_hal.description import profile_path
from tests.acceptance.contract.differences import Difference
from tests.acceptance.contract.hal import PROGRAMS, Hal
from tests.support.nightly import first_of

pytestmark = pytest.mark.ros


def ended(hal: Hal, program: str, name: str = "wrong", **parameters: object) -> tuple[int, str]:
    """Exit code of a program that cannot work, and the one sentence that it says."""
    child = hal.begin_bare(program, name, **parameters)
    code = child.wait_for_end(timeout_s=60.0)
    said = child.text().strip()
    assert "Traceback" not in said, said
    assert "\n" not in said, said
    return code, said


@pytest.mark.parametrize("program", first_of([*PROGRAMS.values(), "data_logger"]))
def test_without_a_tool_it_says_how_to_name_one(hal: Hal, program: str) -> None:
    code, said = ended(hal, program)
    how = hal.by(Difference.PARAMETERS, ros1="_description:=FILE", ros2="-p description:=FILE")
    assert (code, how in said) == (2, True), said
    assert said.startswith(f"{program}: No tool is named: exactly one tool is needed.")


WRONG: Mapping[str, tuple[Mapping[str, str], str]] = {
    "two tools": ({"description": "/tmp/tool.yaml", "profile": "verdin_gripper"}, "Two tools are named"),
    "no such profile": (
        {"profile": "verdin_griper"},
        "no profile is named 'verdin_griper'. Shipped: verdin_gripper.",
    ),
    "no such file": ({"description": "/nowhere/tool.yaml"}, "/nowhere/tool.yaml: there is no such file"),
}


@pytest.mark.parametrize("case", first_of(WRONG))
def test_a_wrong_parameter_is_said_in_one_sentence(hal: Hal, case: str) -> None:
    parameters, words = WRONG[case]
    code, said = ended(hal, "position", **parameters)
    assert (code, words in said) == (2, True), said


@pytest.mark.nightly
def test_a_description_with_a_fault_is_told_with_its_place(hal: Hal, tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(profile_path().read_text().replace("timeout_s: 5.0", "timeout_s: 5 s"), encoding="utf-8")
    code, said = ended(hal, "position", description=path)
    assert code == 2
    assert said.startswith(f"position: {path}:25:16: 'timeout_s' is of the wrong type"), said


@pytest.mark.nightly
def test_a_name_that_belongs_to_the_nodes_is_refused_with_its_place(hal: Hal, tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    text = profile_path().read_text().replace("service: SetCylinder", "service: StopTool")
    path.write_text(text, encoding="utf-8")
    code, said = ended(hal, "position", description=path)
    assert (code, ":38:14: service 'StopTool' belongs to the nodes" in said) == (2, True), said


@pytest.mark.nightly
def test_a_limit_of_a_recording_that_is_no_number_is_refused(hal: Hal, tmp_path: Path) -> None:
    parameters = {"description": hal.world.description_path.absolute(), "directory": tmp_path}
    code, said = ended(hal, "data_logger", **parameters, segment_mb="many")
    assert (code, "segment_mb" in said) == (2, True), said


def test_a_second_node_of_one_name(hal: Hal) -> None:
    """The one that runs is left alone in either generation."""
    second = hal.begin("position")
    if hal.by(Difference.SAME_NAME, ros1=True, ros2=False):
        assert second.wait_for_end(timeout_s=60.0) == 3
        assert "A node /Position runs already" in second.text()
    else:
        hal.until("two of them", lambda: hal.driver.ask("nodes").count("/Position") == 2)
        second.end()
        assert second.code == 0
    hal.until("one of them", lambda: hal.driver.ask("nodes").count("/Position") == 1)
    hal.sees("its positions", lambda state: state["tool_position_name"] == "LOCKED")
