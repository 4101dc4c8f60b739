"""A tool that another process of this machine runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Self

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.codecs import load_tool
from end_effector_hal.control import Answer
from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import NotReadyError
from end_effector_hal.runtime.stream import READINGS
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Command
from end_effector_hal.wires.sensors import SensorHealth

from ._remote_program import RemoteProgram
from ._tool import Tool


class RemoteTool(Tool):
    """A tool that another process runs, reached over the socket of its HAL.

    Closing this object does not affect the tool. While the HAL is lost, the state is OFF, the evidence is UNKNOWN, and
    the alarm ``hal.lost`` has the reason; ``held`` and the outputs keep their last known values. A command that was
    running ends UNREACHABLE. This object connects again when the HAL is back.

    Args:
        description: the tool; the HAL must run the same one.

    Example:
        >>> with EndEffector.connect("end_effector.yaml") as tool:  # doctest: +SKIP
        ...     result = tool.grip()
    """

    def __init__(self, description: Description) -> None:
        super().__init__(description)
        self._remote = RemoteProgram(
            description, self._moved, self._frame_came, self._readings_came, self._look_at_listeners
        )
        self._follow(self._remote)

    @classmethod
    def connect(cls, description: Description | str | Path, *, timeout_s: float = 5.0) -> Self:
        """Connect to the HAL of a tool and wait for its first status.

        Raises:
            DescriptionError: the description has a fault.
            NotReadyError: no HAL runs this tool, or it does not answer within ``timeout_s``.
        """
        loaded = description if isinstance(description, Description) else load_tool(description)
        tool = cls(loaded)
        tool.start()
        if not tool._program.wait(lambda status: bool(status.count), timeout_s):
            remote, todo = tool._remote, f"Start it: eehal serve {loaded.source}"
            if remote.is_other:
                todo = f"Restore that file, or load this one: eehal reload {loaded.source} -- COMMAND"
            tool.close()
            raise NotReadyError(f"{loaded.name} cannot be reached: {remote.why}", todo=todo)
        return tool

    def start(self) -> None:
        """Connect to the HAL, and connect again whenever it is back, until `close`."""
        self._remote.start()

    def close(self) -> None:
        """End the connection; a running command continues."""
        self._goals.close(self.ending())
        self._remote.close()
        self._audience.close()

    def subscribe_frames(self, listener: Callable[[Frame], None], *, name: str = "") -> None:
        """See `Tool.subscribe_frames`."""
        super().subscribe_frames(listener, name=name)
        self._remote.want("frame")

    def ending(self, on: str = "sigterm") -> str:
        """Return a sentence that a running command continues; empty: none runs."""
        command = self.status.command
        return "" if command is Command.NONE else f"{command.label} continues: the HAL executes it."

    @property
    def sensors(self) -> SensorHealth:
        """State and counters of the sensor links and inputs, at most a second old; empty while the HAL is lost."""
        return self._remote.health

    @property
    def outputs(self) -> Mapping[str, bool]:
        """The plain outputs and whether each is active, as the line arbiter reads them back; raises ArbiterError."""
        with ArbiterClient(socket_path(self.description), "outputs", patience_s=0) as arbiter:
            levels = arbiter.levels()
        plain = self.description.outputs
        return {name: levels[each.line] for name, each in plain.items() if each.line in levels}

    def _want_readings(self) -> None:
        self._remote.want(READINGS)

    def _switch(self, name: str, active: bool) -> Answer:
        return self._remote.switch(name, active)
