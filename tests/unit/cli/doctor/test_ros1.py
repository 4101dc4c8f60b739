"""What the doctor says of ROS 1."""

from __future__ import annotations

import sys
import threading
from types import SimpleNamespace
from xmlrpc.server import SimpleXMLRPCServer

import pytest

from end_effector_hal.cli.doctor import _ros
from tests.unit.cli.doctor.parts import Machine


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
