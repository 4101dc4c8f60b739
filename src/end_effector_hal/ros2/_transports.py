"""The transports of Fast DDS in our processes: UDP, never shared memory.

A node that is killed while it reads leaves the mutex of its shared memory locked. Every `publish` to it then waits for
seconds or for ever, and rclpy holds the interpreter meanwhile: the death of any node would stop the tool.
"""

from __future__ import annotations

from collections.abc import MutableMapping
from pathlib import Path

_PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
"""Name a file with transports; Fast DDS 3 reads the first, Fast DDS 2 the second."""
_RANGE, _ONLY_LOCAL = "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY"
_TRANSPORTS, _UDP = "FASTDDS_BUILTIN_TRANSPORTS", "UDPv4"
_LOOPBACK = Path(__file__).with_name("loopback.xml")


def without_shared_memory(env: MutableMapping[str, str]) -> None:
    """Set the variables that turn shared memory off, unless the user has chosen transports.

    Args:
        env: the environment of this process, before `rclpy.init`.
    """
    if any(env.get(name) for name in _PROFILES) or env.get(_TRANSPORTS, _UDP) != _UDP:
        return
    # the older variable overrides the others
    only_local = env.pop(_ONLY_LOCAL, "") == "1"
    if only_local or (env.get(_RANGE) == "LOCALHOST" and not env.get("ROS_STATIC_PEERS")):
        # for this range rmw_fastrtps adds shared memory itself
        env[_RANGE] = "SYSTEM_DEFAULT"
        env.update(dict.fromkeys(_PROFILES, str(_LOOPBACK)))
    else:
        env[_TRANSPORTS] = _UDP
