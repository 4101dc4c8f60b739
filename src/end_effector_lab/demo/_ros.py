"""The same scenario on real ROS: a master of its own, the shipped launch file, the Supervisor.

Only processes are started here and the recording is read; nothing of ROS is imported.
"""

from __future__ import annotations

import importlib.util
import shutil
import signal
from pathlib import Path

from end_effector_hal.errors import RosError
from end_effector_hal.vocabulary import EndEffectorState

from ._last_state import last_state
from ._master import Master
from ._scenario import DemoScenario
from ._world import World

START_S = 120.0  # on a small board every interpreter takes seconds
END_S = 20.0
LAUNCH = "end_effector.launch"
RUN = ("rosrun", "end_effector_hal")
PROGRAMS = ("roscore", "roslaunch", "rosrun")
DEBIAN = (
    "python3-rospy python3-actionlib python3-roslaunch python3-rostopic python3-diagnostic-msgs "
    "python3-sensor-msgs python3-std-srvs rosbash catkin ros-message-generation"
)
WITHOUT = "Without ROS: `eehal demo --no-ros`."


def need_ros() -> None:
    """Raise RosError when ROS or its messages are not here; it says how to get them."""
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    missing += [] if importlib.util.find_spec("rospy") else ["rospy"]
    if missing:
        raise RosError(
            f"ROS is not installed: {', '.join(missing)} not found.",
            todo=f"On Debian 12: `make setup`, or `apt install {DEBIAN}`. {WITHOUT}",
        )
    if importlib.util.find_spec("end_effector_msgs") is None:
        raise RosError(
            "The ROS messages are not built, or not sourced.",
            todo=f"Run `make demo`, or ros/build.sh and then `. build/catkin/devel/setup.sh`. {WITHOUT}",
        )


def play_ros(scenario: DemoScenario, world: World, folder: Path) -> None:
    """Play a scenario through HALMain's actions, recorded by DataLogger into ``folder``.

    Raises:
        RosError: a program of ROS does not start or does not end; with the last lines of its log.
    """
    ros = Master(folder / "ros")
    env = ros.env
    start, states = world.children.start, folder / "states.csv"
    description = str(world.description_path.absolute())
    master = ros.start(world.children, folder / "roscore.log", patience_s=START_S)
    launch = start(
        "launch file",
        [
            "roslaunch", "--wait", "end_effector_hal", LAUNCH, f"description:={description}", "owner:=false",
            f"trace_directory:={folder.absolute()}",
        ],
        log=folder / "roslaunch.log", failed=RosError, env=env, end_by=signal.SIGINT, patience_s=END_S,
    )  # fmt: skip
    # not by the launch file: it is to end before the nodes do, so that their end is not recorded as a state
    logger = start(
        "DataLogger",
        [*RUN, "data_logger", f"_description:={description}", f"_directory:={folder.absolute()}"],
        log=folder / "data_logger.log", failed=RosError, env=env,
    )  # fmt: skip
    launch.wait_until(
        lambda: last_state(states) is EndEffectorState.STAND_BY,
        timeout_s=START_S,
        what="STAND_BY was recorded",
    )
    supervisor = start(
        "Supervisor", [*RUN, "supervisor", f"_script:={scenario.script}"],
        log=folder / "supervisor.log", failed=RosError, env=env,
    )  # fmt: skip
    supervisor.wait_for_end(timeout_s=scenario.longest_s(world.description) + START_S)
    world.children.end_since(logger)
    world.children.end_since(master)
