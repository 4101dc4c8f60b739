"""How the tool is driven in a run: the one place where the demo chooses between ROS and no ROS."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.processes import EEHAL, Child

from ._progress import last_state
from ._world import World

START_S = 120.0  # on a small board every interpreter takes seconds
AFTER_OTHERS = ("nice", "-n", "10")
"""Who gives the commands takes no processor time from who controls: its start would make readings late."""


class Drive(Protocol):
    """Has the orders of a scenario carried out on the lines and the link of a world, and recorded in its folder.

    It starts processes through ``world.children``, which ends those that are left.
    """

    ros: int
    """The generation of ROS whose nodes carry the states, for ``run.json``; 0: none."""

    def check(self) -> None:
        """Raise RosError when what it needs is not here; it says how to get it."""
        ...

    def play(self, world: World, script: str, longest_s: float) -> None:
        """Give the commands of a script, and return when its end is recorded.

        ``states.csv``, ``alarms.csv``, ``pressures.csv`` and the traces of both programs are in the folder then.

        Args:
            world: the hardware, with the description that every process reads.
            script: as `eehal run` and the Supervisor take it.
            longest_s: how long the script may take.

        Raises:
            ReportedError: a process does not start or does not end; with the last lines of its log.
        """
        ...


class WithoutRos:
    """The tool in one process: `eehal run`. ``tool.log`` tells its states, and what it answered."""

    ros = 0

    def check(self) -> None:
        """Nothing more is needed."""

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
    """Have the Supervisor give its script while DataLogger records; DataLogger is ended before the nodes are.

    Args:
        world: the hardware.
        nodes: a process of the nodes, whose end is the end of all.
        start: starts a process in the environment of the nodes: name, command, ``log``.
        logger, supervisor: the commands of both.
        longest_s: how long the script may take.
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
