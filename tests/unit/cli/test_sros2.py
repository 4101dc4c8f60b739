"""``eehal export sros2``: each process may do what its nodes do, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._export import command
from end_effector_hal.cli._sros2 import security_policy
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from tests.support.sros2 import read_policy

FIVE = ("hal_main", "grip", "tool_change", "pressure", "position")


def holders(text: str, right: str, name: str) -> set[str]:
    """The last word of each enclave that has a right."""
    return {path.rpartition("/")[2] for path, allowed in read_policy(text).items() if name in allowed[right]}


def test_an_enclave_for_each_process(verdin: Description) -> None:
    others = ("data_logger", "supervisor", "client")
    assert [*read_policy(security_policy(verdin))] == [f"/verdin_gripper/{each}" for each in ("hal", *others)]
    five = read_policy(security_policy(verdin, "five", "cell/left/"))
    assert [*five] == [f"/cell/left/{each}" for each in (*FIVE, *others)]


def test_each_node_speaks_for_itself_only(verdin: Description) -> None:
    text = security_policy(verdin, "five")
    assert holders(text, "publish", "/EndEffectorState") == {"hal_main"}
    assert holders(text, "publish", "/PressureCylinder") == {"pressure"}
    assert holders(text, "reply", "/StopTool") == {"grip"}
    assert holders(text, "subscribe", "/EndEffectorState") == {"data_logger", "supervisor", "client"}
    assert holders(text, "subscribe", "/PressureCylinder") == {"client"}


@pytest.mark.parametrize("five", [False, True])
def test_who_commands_the_tool(verdin: Description, five: bool) -> None:
    text = security_policy(verdin, "five" if five else "one", "/left")
    server = {"hal_main" if five else "hal"}
    assert holders(text, "request", "/left/Drop/_action/send_goal") == {"client", "supervisor"}
    assert holders(text, "reply", "/left/Drop/_action/send_goal") == server
    assert holders(text, "publish", "/left/Drop/_action/feedback") == server
    assert holders(text, "request", "/left/SetCylinder") == {"client"}
    assert holders(text, "reply", "/left/SetCylinder") == {"grip" if five else "hal"}
    assert holders(text, "request", "/left/ArmToolChanger") == {"client", "supervisor"}
    assert not holders(text, "request", "/Drop/_action/send_goal")
    client = read_policy(text)["/left/client"]
    assert client["publish"] == {"/rosout", "/parameter_events"}
    assert "/left/PressureSupply" in client["subscribe"]


def test_parameters_are_set_by_nobody(verdin: Description) -> None:
    for allowed in read_policy(security_policy(verdin, "five")).values():
        assert not [each for each in allowed["request"] if "parameters" in each]


def test_who_manages_the_managed_node(verdin: Description) -> None:
    text = security_policy(verdin, "managed", "/left")
    for name in ("change_state", "get_state"):
        assert holders(text, "reply", f"/left/EndEffector/{name}") == {"lifecycle_hal"}
        assert holders(text, "request", f"/left/EndEffector/{name}") == {"operator"}
    assert not holders(security_policy(verdin), "request", "/EndEffector/change_state")


def test_a_tool_without_a_changer(verdin: Description) -> None:
    text = security_policy(verdin.model_copy(update={"tool_changer": None}))
    assert "ArmToolChanger" not in text
    assert "PositionToolChanger" not in text


@pytest.mark.parametrize("namespace", ["a//b", "9x", "/a b", "a/&lt;", "ä"])
def test_what_is_no_namespace(verdin: Description, namespace: str) -> None:
    with pytest.raises(UsageError, match="is not a namespace"):
        security_policy(verdin, namespace=namespace)


def test_the_command_writes_a_file(tmp_path: Path) -> None:
    target = tmp_path / "policy.xml"
    done = CliRunner().invoke(command, ["sros2", "--processes", "five", "-o", str(target)])
    assert (done.exit_code, done.output) == (0, f"{target}\n")
    assert "/verdin_gripper/pressure" in read_policy(target.read_text())
