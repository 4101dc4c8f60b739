"""Which transports of Fast DDS a process of ours has: no shared memory, but what a user has chosen."""

from __future__ import annotations

import pytest

from end_effector_hal.ros2 import without_shared_memory

UDP = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
RANGE, LOCAL = "ROS_AUTOMATIC_DISCOVERY_RANGE", {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


@pytest.mark.parametrize(
    "given",
    [{}, {RANGE: "SUBNET"}, {**LOCAL, "ROS_STATIC_PEERS": "192.0.2.7"}],
    ids=["nothing", "subnet", "peers"],
)
def test_the_transport_is_udp(given: dict[str, str]) -> None:
    env = dict(given)
    without_shared_memory(env)
    assert env == {**given, **UDP}


@pytest.mark.parametrize(
    "given", [LOCAL, LOCAL | UDP, {"ROS_LOCALHOST_ONLY": "1"}], ids=["local", "udp", "only"]
)
def test_on_loopback_a_profile_replaces_what_the_middleware_would_add(given: dict[str, str]) -> None:
    env = dict(given)
    without_shared_memory(env)
    assert env.pop(RANGE) == "SYSTEM_DEFAULT"
    assert "ROS_LOCALHOST_ONLY" not in env
    for name in UDP:
        env.pop(name, None)
    assert {path.rpartition("/")[2] for path in env.values()} == {"loopback.xml"}


@pytest.mark.parametrize("name", ["FASTDDS_BUILTIN_TRANSPORTS", "FASTRTPS_DEFAULT_PROFILES_FILE"])
def test_what_a_user_chose_stays(name: str) -> None:
    env = {**LOCAL, name: "SHM"}
    without_shared_memory(env)
    assert env == {**LOCAL, name: "SHM"}
