"""The hardware of one run: virtual chip, line arbiter, and the testbench at the other end of the wires."""

from __future__ import annotations

import shutil
import sys
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp
from types import TracebackType
from typing import Self

from ruamel.yaml import YAML

from end_effector_hal.description import Description, load
from end_effector_hal.errors import ArbiterError, LinkError, UsageError

from ._children import Children

DESCRIPTION = "end_effector.yaml"
LINES = "lines.log"
START_S = 60.0  # a limit, for small and busy machines
EEHAL = (sys.executable, "-c", "from end_effector_hal.cli import main; main()")


class World:
    """Starts it on entering; ends it on leaving, with every process that was started through ``children``.

    Args:
        description: the tool; its lines become virtual, its link a pty.
        bench: scenario of the testbench.
        folder: receives the logs and the description that is used.
        own_wires: leave lines and link as they are; who stands at their other end plays the scenario.
    """

    def __init__(
        self, description: Description, bench: str, folder: Path, *, own_wires: bool = False
    ) -> None:
        self._bench, self._folder, self._own_wires = bench, folder, own_wires
        # a socket's path may be 108 bytes long only: not in the run folder
        self._place = Path(mkdtemp(prefix="eehal-demo-"))
        self.chip = self._place / "chip"
        self.socket = self._place / "owner.sock"
        self.port = self._place / "uart"
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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def choose(self, bench: str) -> None:
        """Have another scenario at the testbench from now on."""
        said = self.testbench.text().count("scenario: ")
        self.testbench.tell(f"scenario {bench}")
        self.testbench.wait_until(
            lambda: self.testbench.text().count("scenario: ") > said, timeout_s=START_S, what="the scenario"
        )

    def _start(self) -> None:
        path = str(self.description_path)
        if not self._own_wires:
            self._start_testbench(path)
        owner = self.children.start(
            "line arbiter", [*EEHAL, "arbiter", path], log=self._folder / "owner.log", failed=ArbiterError
        )
        owner.wait_until(self.socket.exists, timeout_s=START_S, what="its socket")

    def _start_testbench(self, path: str) -> None:
        testbench = self.children.start(
            "testbench",
            [*EEHAL, "testbench", path, "--scenario", self._bench],
            log=self._folder / "testbench.log",
            failed=LinkError,
            commands=True,
        )
        testbench.wait_until(lambda: "ready:" in testbench.text(), timeout_s=START_S, what="it was ready")
        self.testbench = testbench

    def _written(self) -> Description:
        """The description as every process of this run reads it."""
        content = self.description.model_dump(mode="json", by_alias=True, exclude_unset=True)
        content["automata"] = {**content.get("automata", {}), "file": str(self.description.automata_path)}
        try:
            with self.description_path.open("w", encoding="utf-8") as file:
                wires = "its own wires" if self._own_wires else "virtual lines and a pty"
                file.write(f"# Written by eehal demo: the same tool on {wires}.\n")
                YAML(typ="safe", pure=True).dump(content, file)
        except OSError as error:
            raise UsageError(
                f"Cannot be written: {error.strerror}.", where=str(self.description_path)
            ) from None
        return load(self.description_path)

    def _end(self) -> None:
        self.children.end()
        with suppress(OSError):
            shutil.move(self.chip, self._folder / LINES)
        shutil.rmtree(self._place, ignore_errors=True)
