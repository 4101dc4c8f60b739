"""Checks ROS 2: its packages, our messages, our programs, and the variables that decide which nodes see each other."""

from __future__ import annotations

import importlib
import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from end_effector_hal.ros2 import ROS_PACKAGES
from end_effector_hal.wires import lockers_of

from ._check_result import CheckedPart, CheckResult, CheckResults
from ._machine import is_importable

FOLDER = Path("/dev/shm")
_LOCKS = ("fastrtps_*_el", "fastdds_*_el")
"""Lock files; a process locks such a file as long as it uses the shared memory of the same name without ``_el``."""
_say = CheckedPart("ros")


def look_at_shared_memory(folder: Path = FOLDER) -> CheckResults:
    """Report segments and ports whose lock no process holds: they occupy memory and can disturb a later process."""
    locks = [path for pattern in _LOCKS for path in sorted(folder.glob(pattern))]
    dead = [path for path in locks if not lockers_of(path)]
    if not dead:
        return
    size = sum(_size(path.with_name(path.name.removesuffix("_el"))) for path in dead)
    names = [path.name.removesuffix("_el") for path in dead]
    yield _say.warning(
        f"left in {folder} by processes of Fast DDS that died: {names[0]}"
        f"{f' and {len(names) - 1} more' if names[1:] else ''} ({size / 1e6:.1f} MB)",
        "As the user whose files they are: fastdds shm clean; it leaves alone what is in use.",
    )


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


OURS = "end_effector_hal"
TRIED = "jazzy"
TRIED_MIDDLEWARE = "rmw_fastrtps_cpp"
MOST_DOMAIN = 232
EPHEMERAL_DOMAINS = range(102, 215)
"""Domains whose ports are among those that Linux assigns to any program (32768 to 60999)."""
RANGES = ("SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT")
_SOURCE = "Source ROS 2, such as . /opt/ros/jazzy/setup.bash; without an installation: make ros2"
_BUILD = "colcon build, then . install/setup.bash; in the checkout: make ros2"


def look_at_ros2() -> CheckResults:
    """Check ROS 2. An absent part is MISSING only if ROS 2 is sourced."""
    wanted = os.environ.get("ROS_VERSION") == "2" or "AMENT_PREFIX_PATH" in os.environ
    if absent := [name for name in ROS_PACKAGES if not is_importable(name)]:
        yield _absent(absent, wanted)
    else:
        yield _distribution(os.environ.get("ROS_DISTRO", ""))
        yield _messages(wanted)
    yield from _programs()
    yield _middleware(os.environ.get("RMW_IMPLEMENTATION", ""))
    yield _domain(os.environ.get("ROS_DOMAIN_ID", ""))
    yield _discovery()
    yield from look_at_shared_memory()


def _absent(names: list[str], wanted: bool) -> CheckResult:
    text = f"not there: {', '.join(names)}"
    own = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    for prefix in _prefixes():
        for found in sorted(prefix.glob("lib/python3*/site-packages/rclpy")):
            if (other := found.parents[1].name) != own:
                return _say.lacks(
                    f"{text}; ROS 2 is for {other}, and this is {own}",
                    f"Make the environment with it: /usr/bin/{other} -m venv --system-site-packages FOLDER",
                    wanted=wanted,
                )  # fmt: skip
    return _say.lacks(text, _SOURCE, wanted=wanted)


def _distribution(name: str) -> CheckResult:
    if name in ("", TRIED):
        return _say.ok(f"ROS 2{f' {name}' if name else ''}: its packages are there")
    return _say.warning(f"ROS 2 {name}: its packages are there", f"Only {TRIED} was tried.")


def _messages(wanted: bool) -> CheckResult:
    """Check that rclpy can send our messages: an import also finds those of ROS 1 and of another Python."""
    if not is_importable("end_effector_msgs.msg"):
        return _say.lacks(
            "the messages end_effector_msgs are not built, or not sourced", _BUILD, wanted=wanted
        )
    try:
        from rclpy.type_support import check_for_type_support

        messages = importlib.import_module("end_effector_msgs.msg")
        check_for_type_support(messages.EndEffectorState)
    except Exception as error:  # noqa: BLE001 generated code and its libraries raise what they like
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        return _say.missing(f"the messages end_effector_msgs are not for this ROS 2: {why}", _BUILD)
    return _say.ok(f"end_effector_msgs are built: {Path(messages.__file__ or '').parents[1]}")


def _programs() -> Iterator[CheckResult]:
    """Check that ``ros2 run`` finds our programs, and which interpreter it starts them with."""
    found = next((each for each in _prefixes() if _indexed(each, OURS)), None)
    if found is None:
        yield _say.warning(
            f"ros2 run does not find {OURS}",
            f"{_BUILD}; without a workspace: python -m end_effector_hal.ros2 hal",
        )
        return
    first = shutil.which("python3") or "none"
    if Path(first).parent == Path(sys.executable).parent:
        yield _say.ok(f"ros2 run finds {OURS} in {found}")
        return
    yield _say.warning(
        f"ros2 run finds {OURS} in {found}; its programs start with {first}, and this is {sys.executable}",
        f"Activate the environment first: . {Path(sys.executable).parent}/activate",
    )


def _middleware(name: str) -> CheckResult:
    if not name or name == TRIED_MIDDLEWARE:
        return _say.ok(f"middleware: {name or 'the default'}")
    if "AMENT_PREFIX_PATH" in os.environ and not any(_indexed(each, name) for each in _prefixes()):
        return _say.missing(
            f"RMW_IMPLEMENTATION names {name}, which is not installed",
            f"Install it, or unset RMW_IMPLEMENTATION; only {TRIED_MIDDLEWARE} was tried.",
        )
    return _say.warning(f"middleware: {name}", f"Only {TRIED_MIDDLEWARE} was tried.")


def _domain(text: str) -> CheckResult:
    if not text:
        return _say.ok("ROS_DOMAIN_ID: 0, the default")
    number = int(text) if text.isascii() and text.isdigit() else -1
    if not 0 <= number <= MOST_DOMAIN:
        return _say.missing(
            f"ROS_DOMAIN_ID is {text!r}, no number from 0 to {MOST_DOMAIN}", "Take one from 0 to 101."
        )
    if number in EPHEMERAL_DOMAINS:
        return _say.warning(
            f"ROS_DOMAIN_ID: {text}; another program may have one of its ports", "Take one from 0 to 101."
        )
    return _say.ok(f"ROS_DOMAIN_ID: {text}")


def _discovery() -> CheckResult:
    """Check who can reach the tool: without SROS 2, every participant may command it."""
    local, chosen = (
        os.environ.get("ROS_LOCALHOST_ONLY", ""),
        os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", ""),
    )
    todo = "export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST"
    if local == "1":
        return _say.warning(
            "ROS_LOCALHOST_ONLY=1: this machine only; the variable is deprecated and wins over the newer one",
            f"unset ROS_LOCALHOST_ONLY; {todo}",
        )
    if chosen and chosen not in RANGES:
        return _say.warning(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE is {chosen!r}, none of {', '.join(RANGES)}: ROS 2 takes LOCALHOST",
            todo,
        )
    if chosen in ("LOCALHOST", "OFF"):
        return _say.ok(f"discovery: {chosen}")
    return _say.warning(
        f"discovery: {chosen or 'SUBNET, the default'}; every machine of the network can command the tool",
        todo,
    )


def _prefixes() -> list[Path]:
    return [Path(each) for each in os.environ.get("AMENT_PREFIX_PATH", "").split(":") if each]


def _indexed(prefix: Path, package: str) -> bool:
    return (prefix / "share/ament_index/resource_index/packages" / package).is_file()
