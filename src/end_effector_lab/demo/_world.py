"""The hardware of one run (virtual chip, line arbiter, testbench), and what drives the tool on it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp
from typing import Protocol, Self

from end_effector_hal.description import Description, load
from end_effector_hal.errors import ArbiterError, LinkError
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.processes import EEHAL, Child, Children
from end_effector_lab.testbench import (
    chosen_models,
    parse_scenario,
    possible_faults,
    text_of,
    write_description,
)

from ._progress import last_state

DESCRIPTION = "end_effector.yaml"
LINES = "lines.log"
START_S = 60.0  # a limit, for small and busy machines


class World:
    """Starts the hardware on entering; ends it on leaving, with every process that was started through ``children``.

    Args:
        description: the tool; its lines become virtual, its link a pty.
        bench: scenario of the testbench.
        folder: receives the logs and the description that is used.
        own_wires: keep lines and link unchanged; the device at their other end plays the scenario.
        outlives_us: whether the line arbiter survives a kill of this process.
        seed: seed of the noise and the dead times of the testbench.
        events: file in the folder for the edges and frames of the testbench; empty: none.
        models: devices that the testbench plays by their makers' manuals, as for its option ``--model``, beside those
            that the description names.

    Raises:
        UsageError: the tool cannot have this scenario.

    Attributes:
        folder: folder of the run.
        place: folder for sockets and ptys; it is deleted with the world.
        description_path: the used description, in the folder.
        description: the same, loaded.
        children: the started processes.
        arbiter, testbench: two of them.
    """

    def __init__(
        self,
        description: Description,
        bench: str,
        folder: Path,
        *,
        own_wires: bool = False,
        outlives_us: bool = True,
        seed: int = 0,
        models: str = "",
        events: str = "",
    ) -> None:
        parse_scenario(bench, description)
        self.folder, self._bench, self._own_wires = folder, bench, own_wires
        self._outlives_us, self._seed, self._events = outlives_us, seed, events
        self._models = text_of(chosen_models(models, description))  # a written copy names no device
        # a socket's path may be 108 bytes long only: not in the run folder
        self.place = Path(mkdtemp(prefix="eehal-demo-"))
        self.chip = self.place / "chip"
        self.socket = self.place / "arbiter.sock"
        self.port = self.place / "uart"
        self.children = Children()
        self.description_path = folder / DESCRIPTION
        self.description = (
            description.with_socket(self.socket)
            if own_wires
            else description.with_virtual(self.chip, str(self.port), self.socket)
        )

    def __enter__(self) -> Self:
        try:
            self.description = self._written()
            self._start()
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    @staticmethod
    def scenarios(description: Description) -> Iterator[str]:
        """Return the possible scenarios of the tool, without numbers."""
        return possible_faults(description)

    def choose(self, bench: str) -> None:
        """Select another scenario at the testbench; raises UsageError if it is refused, and then nothing changes."""
        parse_scenario(bench, self.description)
        said = self.testbench.text().count("scenario: ")
        self.testbench.tell(f"scenario {bench}")
        self.testbench.wait_until(
            lambda: self.testbench.text().count("scenario: ") > said, timeout_s=START_S, what="the scenario"
        )

    def _start(self) -> None:
        path, start = str(self.description_path), self.children.start
        if not self._own_wires:
            more = ["--events", str(self.folder / self._events)] if self._events else []
            more += ["--model", self._models] if self._models else []
            self.testbench = start(
                "testbench",
                [*EEHAL, "testbench", path, "--scenario", self._bench, "--seed", str(self._seed), *more],
                log=self.folder / "testbench.log",
                failed=LinkError,
                commands=True,
            )
            self.testbench.wait_until(
                lambda: "ready:" in self.testbench.text(), timeout_s=START_S, what="it was ready"
            )
        self.arbiter = start(
            "line arbiter",
            [*EEHAL, "arbiter", path],
            log=self.folder / "arbiter.log",
            failed=ArbiterError,
            outlives_us=self._outlives_us,
        )
        self.arbiter.wait_until(self.socket.exists, timeout_s=START_S, what="its socket")

    def _written(self) -> Description:
        """Write and return the description that every process of this run reads."""
        wires = "its own wires" if self._own_wires else "virtual lines and simulated ports"
        write_description(self.description, self.description_path, f"the same tool on {wires}")
        return load(self.description_path)

    def _end(self) -> None:
        self.children.end()
        with suppress(OSError):
            shutil.move(self.chip, self.folder / LINES)
        shutil.rmtree(self.place, ignore_errors=True)


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
