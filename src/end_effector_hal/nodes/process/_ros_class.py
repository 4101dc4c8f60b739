"""Find the classes that a generation of ROS has generated from the definitions of messages, services and actions."""

from __future__ import annotations

import importlib
from importlib.util import find_spec
from typing import Any

from end_effector_hal.errors import RosError


def has_ros_class(name: str, kind: str) -> bool:
    """Return whether a type is installed, named as for `ros_class`."""
    package, _, plain = name.partition("/")
    if find_spec(package) is None or find_spec(f"{package}.{kind}") is None:
        return False
    return hasattr(importlib.import_module(f"{package}.{kind}"), plain)


def ros_class(name: str, kind: str, todo: str) -> Any:
    """Return a generated class.

    Args:
        name: name of the type, such as ``std_msgs/Header``.
        kind: ``msg``, ``srv`` or ``action``.
        todo: how types are built in this generation.

    Raises:
        RosError: the type is not built.
        ModuleNotFoundError: a package that it needs is not installed.
    """
    package, _, plain = name.partition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), plain)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package or error.name == package:
            raise
        raise RosError(f"The ROS type {name} is not there.", todo=todo) from None
    except (ImportError, AttributeError):
        raise RosError(f"The ROS type {name} is not there.", todo=todo) from None
