"""What the doctor says of ROS 1."""

from __future__ import annotations

import fcntl
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from xmlrpc.server import SimpleXMLRPCServer

import pytest

from end_effector_hal.cli.doctor import _ros, _ros2
from end_effector_hal.cli.doctor._ros2 import look_at_shared_memory
from tests.unit.cli.doctor.conftest import Machine


class Master:
    """What a ROS master and its nodes answer, on a loopback port."""

    def __init__(self, nodes: dict[str, bool]) -> None:
        self._server = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False, allow_none=True)
        self.uri = f"http://127.0.0.1:{self._server.server_address[1]}"
        published = [["/x", [name]] for name in nodes]
        self._server.register_function(lambda caller: [1, "", 4711], "getPid")
        self._server.register_function(lambda caller: [1, "", [published, [], []]], "getSystemState")
        self._server.register_function(
            lambda caller, name: [1, "", self.uri if nodes[name] else "http://127.0.0.1:9"], "lookupNode"
        )
        self._thread = threading.Thread(target=self._server.serve_forever)

    def __enter__(self) -> Master:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


HAL = ("HALMain", "Grip", "ToolChange", "Pressure", "Position")


@pytest.mark.parametrize(
    ("nodes", "expected"),
    [
        (dict.fromkeys(["/cell/" + name for name in HAL], True), "ok: nodes " + ", ".join(HAL) + " answer"),
        (
            {**dict.fromkeys(["/" + name for name in HAL], True), "/Grip": False},
            "missing: nodes that do not answer: Grip",
        ),
        ({"/rosout": True}, "missing: none of the HAL's nodes runs"),
    ],
)
def test_master_and_nodes(
    machine: Machine, monkeypatch: pytest.MonkeyPatch, nodes: dict[str, bool], expected: str
) -> None:
    with Master(nodes) as master:
        monkeypatch.setenv("ROS_MASTER_URI", master.uri)
        *_, at, last = machine.findings("ros")
    assert at[:2] == ("ok", f"master at {master.uri} (pid 4711)")
    assert f"{last[0]}: {last[1]}" == expected


@pytest.mark.parametrize("uri", ["http://127.0.0.1:9", "nonsense", "", "http://127.0.0.1:x"])
def test_no_master(machine: Machine, monkeypatch: pytest.MonkeyPatch, uri: str) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", uri)
    assert machine.findings("ros")[-1][0] == "missing"


def test_without_ros_the_tool_runs(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_ros, "PACKAGES", ("rospy", "no_such_package"))
    absent, *_ = machine.findings("ros")
    assert (absent[0], "no_such_package" in absent[1]) == ("warning", True)
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    assert machine.findings("ros")[0][0] == "missing"


def test_messages_without_their_launch_files(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    class NotFound(Exception):
        pass

    class RosPack:
        def get_path(self, name: str) -> str:
            raise NotFound(name)

    stand_in = SimpleNamespace(RosPack=RosPack, ResourceNotFound=NotFound)
    monkeypatch.setitem(sys.modules, "rospkg", stand_in)  # type: ignore[arg-type]
    monkeypatch.setattr(_ros, "is_importable", lambda name: True)
    what = "end_effector_msgs are built; roslaunch does not find end_effector_hal"
    assert ("warning", what) in [finding[:2] for finding in machine.findings("ros")]
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    assert ("missing", what) in [finding[:2] for finding in machine.findings("ros")]


def package(prefix: Path, name: str) -> Path:
    """A prefix of ament in which ``ros2`` finds a package."""
    marker = prefix / "share/ament_index/resource_index/packages" / name
    marker.parent.mkdir(parents=True, exist_ok=True)
    marker.touch()
    return prefix


@pytest.fixture
def sourced(machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Machine:
    """ROS 2 is sourced, and this Python does not see it."""
    prefix = package(tmp_path / "ros", "rclpy")
    for name in (
        "RMW_IMPLEMENTATION",
        "ROS_DOMAIN_ID",
        "ROS_LOCALHOST_ONLY",
        "ROS_AUTOMATIC_DISCOVERY_RANGE",
    ):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))
    monkeypatch.setenv("ROS_VERSION", "2")
    monkeypatch.setattr(_ros2, "ROS_PACKAGES", ("no_such_rclpy",))
    return machine


def about(machine: Machine, word: str) -> str:
    """The level and the words of the one finding in which a word stands."""
    (found,) = [f"{level}: {what}" for level, what, _ in machine.findings("ros") if word in what]
    return found


def test_the_generation_that_is_sourced_is_looked_at(
    machine: Machine, sourced: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert about(sourced, "no_such_rclpy") == "missing: not there: no_such_rclpy"
    monkeypatch.setenv("ROS_VERSION", "1")
    assert not [what for _, what, _ in machine.findings("ros") if "no_such_rclpy" in what]
    # a wheel of ROS 2 sources nothing
    monkeypatch.delenv("ROS_VERSION")
    assert about(sourced, "no_such_rclpy")
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    assert not [what for _, what, _ in machine.findings("ros") if "no_such_rclpy" in what]


def test_ros_2_for_another_python(sourced: Machine, tmp_path: Path) -> None:
    (tmp_path / "ros/lib/python3.99/site-packages/rclpy").mkdir(parents=True)
    own = f"python3.{sys.version_info[1]}"
    assert (
        about(sourced, "no_such")
        == f"missing: not there: no_such_rclpy; ROS 2 is for python3.99, and this is {own}"
    )


@pytest.mark.parametrize("of_ros_1", ["rospy/__init__.py", "end_effector_msgs/msg/_EndEffectorState.py"])
def test_two_generations_in_pythonpath(
    sourced: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, of_ros_1: str
) -> None:
    one, two = tmp_path / of_ros_1, tmp_path / "two" / "rclpy"
    one.parent.mkdir(parents=True)
    one.touch()
    two.mkdir(parents=True)
    monkeypatch.setenv("PYTHONPATH", f"{two.parent}:/nowhere")
    assert not [what for _, what, _ in sourced.findings("ros") if "PYTHONPATH" in what]
    monkeypatch.setenv("PYTHONPATH", f"{two.parent}:{tmp_path}")
    assert about(sourced, "PYTHONPATH") == (
        f"missing: PYTHONPATH names ROS 1 ({tmp_path}) and ROS 2 ({two.parent}): their packages have the same names"
    )


@pytest.mark.parametrize(
    ("given", "level"),
    [("", "ok"), ("0", "ok"), ("101", "ok"), ("102", "warning"), ("214", "warning"), ("215", "ok"), ("232", "ok")]
    + [(text, "missing") for text in ("233", "-1", "abc", "1.5", "²")],
)  # fmt: skip
def test_the_domain(sourced: Machine, monkeypatch: pytest.MonkeyPatch, given: str, level: str) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", given)
    assert about(sourced, "ROS_DOMAIN_ID").partition(":")[0] == level


@pytest.mark.parametrize(
    ("variables", "said"),
    [
        ({}, "warning: discovery: SUBNET, the default; every machine of the network can command the tool"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, "ok: discovery: LOCALHOST"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "localhost"}, "warning: ROS_AUTOMATIC_DISCOVERY_RANGE is 'localhost', none"),
        ({"ROS_LOCALHOST_ONLY": "1", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, "warning: ROS_LOCALHOST_ONLY=1: this"),
        ({"ROS_LOCALHOST_ONLY": "0"}, "warning: discovery: SUBNET"),
    ],
)  # fmt: skip
def test_who_is_heard(
    sourced: Machine, monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], said: str
) -> None:
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert [text for text in told(sourced) if text.startswith(said)]


def told(machine: Machine) -> list[str]:
    return [f"{level}: {what}" for level, what, _ in machine.findings("ros")]


def test_the_middleware(sourced: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "ok: middleware: the default" in told(sourced)
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_other")
    assert "missing: RMW_IMPLEMENTATION names rmw_other, which is not installed" in told(sourced)
    package(tmp_path / "ros", "rmw_other")
    assert "warning: middleware: rmw_other" in told(sourced)


def test_our_programs_start_with_the_python_that_is_first(
    sourced: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "warning: ros2 run does not find end_effector_hal" in told(sourced)
    package(tmp_path / "ros", "end_effector_hal")
    monkeypatch.setenv("PATH", "/usr/bin")
    start = f"its programs start with /usr/bin/python3, and this is {sys.executable}"
    assert f"warning: ros2 run finds end_effector_hal in {tmp_path / 'ros'}; {start}" in told(sourced)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:/usr/bin")
    assert f"ok: ros2 run finds end_effector_hal in {tmp_path / 'ros'}" in told(sourced)


def test_leftovers_of_the_dead_are_told_and_stay(tmp_path: Path) -> None:
    for name in ("fastrtps_aa", "fastrtps_port7400"):
        (tmp_path / name).write_bytes(bytes(2_000_000))
        (tmp_path / f"{name}_el").touch()
    with (tmp_path / "fastrtps_aa_el").open() as one, (tmp_path / "fastrtps_port7400_el").open() as two:
        fcntl.flock(one, fcntl.LOCK_EX)
        fcntl.flock(two, fcntl.LOCK_EX)
        assert list(look_at_shared_memory(tmp_path)) == []
        two.close()
        (finding,) = look_at_shared_memory(tmp_path)
    assert (
        finding.what == f"left in {tmp_path} by processes of Fast DDS that died: fastrtps_port7400 (2.0 MB)"
    )
    assert (finding.level.value, "fastdds shm clean" in finding.todo) == ("warning", True)
    assert len(list(tmp_path.iterdir())) == 4
