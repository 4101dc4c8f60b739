"""Drives the tool in a run; this is the only place where the demo chooses between ROS and no ROS."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.processes import EEHAL, Child

from ._progress import last_state
from ._world import World

START_S = 120.0  # on a small board every interpreter takes seconds
AFTER_OTHERS = ("nice", "-n", "10")
"""Prefix that lowers the priority of the commanding process, whose start would otherwise delay readings of the
controller.
"""


class Drive(Protocol):
    """Executes the orders of a scenario on the lines and the link of a world, and records them in its folder.

    It starts processes through ``world.children``, which ends those that are left.
    """

    ros: int
    """ROS version whose nodes carry the states, for ``run.json``; 0: none."""

    def check(self) -> None:
        """Raise RosError with the remedy if something that the drive needs is missing."""
        ...

    def play(self, world: World, script: str, longest_s: float) -> None:
        """Execute the commands of a script, and return when its end is recorded.

        The folder then contains ``states.csv``, ``alarms.csv``, ``pressures.csv`` and the trace.

        Args:
            world: the hardware, with the description that every process reads.
            script: in the form of `eehal run` and the Supervisor.
            longest_s: longest time of the script.

        Raises:
            ReportedError: a process does not start or does not end; with the last lines of its log.
        """
        ...


class WithoutRos:
    """Runs the tool in one process with `eehal run`; ``tool.log`` contains its states and answers."""

    ros = 0

    def check(self) -> None:
        """Do nothing, since nothing more is needed."""

    def play(self, world: World, script: str, longest_s: float) -> None:
        folder = str(world.folder)
        tool = world.children.start(
            "tool",
            [*EEHAL, "run", str(world.description_path), "--script", script, "--record", folder],
            log=world.folder / "tool.log",
        )
        code = tool.wait_for_end(timeout_s=longest_s + START_S)
        if code not in (0, 1):  # 1: a command failed, and that may be the story
            raise tool.error(f"The tool ended with exit code {code}.")


def give_recorded(
    world: World,
    nodes: Child,
    start: Callable[..., Child],
    logger: Sequence[str],
    supervisor: Sequence[str],
    longest_s: float,
) -> None:
    """Let the Supervisor execute its script while DataLogger records; end DataLogger before the nodes.

    Args:
        world: the hardware.
        nodes: a process of the nodes; if it ends, the run fails.
        start: starts a process in the environment of the nodes: name, command, ``log``.
        logger, supervisor: the commands of both.
        longest_s: longest time of the script.
    """
    folder = world.folder
    recording = start("DataLogger", list(logger), log=folder / "data_logger.log")
    nodes.wait_until(
        lambda: last_state(folder / "states.csv") is EndEffectorState.STAND_BY,
        timeout_s=START_S,
        what="STAND_BY was recorded",
    )
    giving = start("Supervisor", [*AFTER_OTHERS, *supervisor], log=folder / "supervisor.log")
    giving.wait_for_end(timeout_s=longest_s + START_S)
    world.children.end_since(recording)
