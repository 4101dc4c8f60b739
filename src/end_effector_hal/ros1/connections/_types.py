"""The classes of ROS 1 for the types of the table."""

from __future__ import annotations

import importlib
from typing import Any

from end_effector_hal.errors import RosError


def message_class(name: str) -> Any:
    """The class of a message type such as ``std_msgs/Header``; raises RosError when it is not built."""
    return _class(name, "msg")


def service_class(name: str) -> Any:
    """The class of a service type; raises RosError when it is not built."""
    return _class(name, "srv")


def _class(name: str, kind: str) -> Any:
    package, _, plain = name.partition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), plain)
    except ModuleNotFoundError:
        raise
    except (ImportError, AttributeError):
        raise RosError(
            f"The ROS type {name} is not there.", todo="Run ros/build.sh, then . build/catkin/devel/setup.sh"
        ) from None
