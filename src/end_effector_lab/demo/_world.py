"""The hardware of one run: virtual chip, line arbiter, and the testbench at the other end of the wires."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp
from typing import Self

from end_effector_hal.description import Description, load
from end_effector_hal.errors import ArbiterError, LinkError
from end_effector_lab.processes import EEHAL, Children
from end_effector_lab.testbench import (
    chosen_models,
    parse_scenario,
    possible_faults,
    text_of,
    write_description,
)

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
        events: file in the folder for the edges and frames of the testbench; empty: none.
        outlives_us: whether the line arbiter survives a kill of this process.
        seed: seed of the noise and the dead times of the testbench.
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
        events: str = "",
        outlives_us: bool = True,
        seed: int = 0,
        models: str = "",
    ) -> None:
        parse_scenario(bench, description)
        self.folder, self._bench, self._own_wires, self._events = folder, bench, own_wires, events
        self._outlives_us, self._seed = outlives_us, seed
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
