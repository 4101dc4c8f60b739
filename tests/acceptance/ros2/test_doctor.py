"""What `eehal doctor` says where ROS 2 is there: real messages, and the shared memory of a process that was killed."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from end_effector_lab.demo._ros import apart
from end_effector_lab.processes import EEHAL
from tests.acceptance.ros2.conftest import without_wheels
from tests.support.patience import PATIENCE_S

NODE = "import rclpy; rclpy.init(); node = rclpy.create_node('x'); print('up', flush=True); input()"


def told(tmp_path: Path, **env: str) -> dict[str, str]:
    """Levels by what was said of ROS."""
    done = subprocess.run(
        [*EEHAL, "doctor", "--only", "ros", "--json"],
        env={**without_wheels(), **apart(tmp_path), **env},
        capture_output=True, text=True, timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    return {each["what"]: each["status"] for each in json.loads(done.stdout)["findings"]}


def of(findings: dict[str, str], words: str) -> list[str]:
    return [level for what, level in findings.items() if words in what]


def test_the_messages_of_this_ros_2(tmp_path: Path) -> None:
    findings = told(tmp_path)
    assert of(findings, "ROS 2: its packages are there") == ["ok"]
    assert of(findings, "end_effector_msgs are built") == ["ok"]


@pytest.mark.parametrize(
    ("module", "text", "words"),
    [
        ("__init__.py", "class EndEffectorState: pass", "This might be a ROS 1 message type"),
        ("__init__.py", "import no_such_library", "No module named 'no_such_library'"),
    ],
)
def test_messages_of_something_else(tmp_path: Path, module: str, text: str, words: str) -> None:
    folder = tmp_path / "other" / "end_effector_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder.parent / "__init__.py").touch()
    (folder / module).write_text(text)
    findings = told(tmp_path, PYTHONPATH=str(tmp_path / "other"))
    assert of(findings, "the messages end_effector_msgs are not for this ROS 2") == ["missing"]
    assert of(findings, words) == ["missing"]


def test_what_a_killed_process_left_is_told(tmp_path: Path) -> None:
    env = {**without_wheels(), **apart(tmp_path)}
    with subprocess.Popen(
        [sys.executable, "-c", NODE], env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"up\n"
        opened = {path.resolve() for path in Path(f"/proc/{process.pid}/fd").iterdir()}
        # a port has a number, which the next process may take; a segment has a name of its own
        locks = [path for path in opened if re.fullmatch(r"fastrtps_[0-9a-f]{16}_el", path.name)]
        process.send_signal(signal.SIGKILL)
    left = [path.with_name(path.name.removesuffix("_el")) for path in locks]
    try:
        assert left
        assert all(path.exists() for path in left)
        assert of(told(tmp_path), "left in /dev/shm by processes of Fast DDS that died") == ["warning"]
        assert all(path.exists() for path in left), "the doctor removes nothing"
    finally:
        # what it advises
        subprocess.run(
            [Path(sys.executable).with_name("fastdds"), "shm", "clean"], capture_output=True, check=True
        )
    assert not any(path.exists() for path in left)
