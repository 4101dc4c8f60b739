"""A whole end-effector in one process, without ROS."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Self

from end_effector_hal.arbiter import PredicatePublisher
from end_effector_hal.codecs import load_tool
from end_effector_hal.control import Answer, ending_in_words
from end_effector_hal.description import Description
from end_effector_hal.recording import RecordingLimits
from end_effector_hal.runtime.boundary import Observer
from end_effector_hal.runtime.programs import open_program
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Alarm
from end_effector_hal.wires.inputs import InputsHealth
from end_effector_hal.wires.link import LinkHealth
from end_effector_hal.wires.sensors import SensorHealth, SensorReader

from ._plain_outputs import PlainOutputs
from ._remote_tool import RemoteTool
from ._tool import Tool


class EndEffector(Tool):
    """A tool at work: its program, its sensors and its lines.

    The line arbiter (``eehal arbiter``) is a separate process and must run: it keeps a held part held if this process
    crashes. Other processes of this machine can talk to the tool meanwhile: see :meth:`connect`.

    Args:
        description: the tool.
        traces: the folder for the trace; None: nothing is recorded.
        limits: the recording limits of that folder.
        observe: called with each record: the inputs of the automata, their steps and decisions.

    Example:
        >>> with EndEffector.open("end_effector.yaml") as tool:  # doctest: +SKIP
        ...     tool.lock()
        ...     result = tool.grip()
        ...     tool.drop()
    """

    def __init__(
        self,
        description: Description,
        *,
        traces: str | Path | None = None,
        limits: RecordingLimits | None = None,
        observe: Observer | None = None,
    ) -> None:
        super().__init__(description)
        with ExitStack() as undo:
            self._predicates = PredicatePublisher(description)
            self._own = open_program(
                description,
                self._moved,
                traces=traces,
                limits=limits,
                publisher=self._predicates,
                observe=observe,
            )
            undo.callback(self._own.close)
            self._outputs = PlainOutputs(description)
            undo.callback(self._outputs.close)
            self._follow(self._own)
            self._reader = SensorReader(description, self._frame_came, self._link_changed)
            undo.pop_all()

    @classmethod
    def open(
        cls,
        description: Description | str | Path,
        *,
        traces: str | Path | None = None,
        limits: RecordingLimits | None = None,
    ) -> Self:
        """Open a tool by its description and adopt its lines; raises DescriptionError, WireError."""
        loaded = description if isinstance(description, Description) else load_tool(description)
        tool = cls(loaded, traces=traces, limits=limits)
        try:
            tool.start()
        except BaseException:
            tool.close()
            raise
        return tool

    @staticmethod
    def connect(description: Description | str | Path, *, timeout_s: float = 5.0) -> RemoteTool:
        """Connect to a tool that another process runs (``eehal serve``, ``eehal run``, ROS); see `RemoteTool`."""
        return RemoteTool.connect(description, timeout_s=timeout_s)

    def start(self) -> None:
        """Start to read the sensors and adopt the lines; raises LinkBusyError or LineBusyError if another process
        does.
        """
        self._reader.start()
        self._own.start(self.set_output, lambda: self.sensors)

    def close(self, ending: str = "sigterm") -> None:
        """End: the line arbiter does what the description declares. Listeners get the waiting items, within 2 s.

        A running command ends UNREACHABLE; its reason contains what happens to the outputs.
        """
        self._goals.close(self.ending(ending))
        self._own.close(ending)
        self._outputs.close()
        self._reader.close()
        self._predicates.close()
        self._audience.close()

    def ending(self, on: str = "sigterm") -> str:
        """Return what the line arbiter does when this process ends now, in words; empty: nothing is active."""
        return ending_in_words(self.description, self.status, on=on)

    @property
    def sensors(self) -> SensorHealth:
        """State and counters of the sensor links and of the inputs of the board."""
        return self._reader.health

    @property
    def link(self) -> LinkHealth | None:
        """State and counters of the sensor link, the first if there are several; None: the tool has none."""
        return next(iter(self.links.values()), None)

    @property
    def links(self) -> Mapping[str, LinkHealth]:
        """State and counters of each sensor link, by its name; a single link without a name has an empty one."""
        return self.sensors.links

    @property
    def inputs(self) -> InputsHealth | None:
        """State and counters of the inputs of the board; None: no channel uses one."""
        return self.sensors.inputs

    @property
    def outputs(self) -> Mapping[str, bool]:
        """The plain outputs and whether each is active, as the line arbiter reads them back; raises ArbiterError."""
        return self._outputs.levels

    def _want_readings(self) -> None:
        self._own.on_readings = self._readings_came

    def _switch(self, name: str, active: bool) -> Answer:
        return self._outputs.set(name, active)

    def stand_still(self) -> Answer:
        """Block activations for 30 s if the tool is at rest now: for a caller that will load another description.

        `runtime.reload_answer` returns whether the file can be adopted; then close this tool and open it again, or
        call `go_on`.
        """
        return self._own.stand_still()

    def go_on(self) -> None:
        """End the block of a `stand_still`."""
        self._own.stand_still(0)

    def _frame_came(self, frame: Frame) -> None:
        self._own.frame(frame)
        super()._frame_came(frame)

    def _link_changed(self, _source: str, _health: object) -> None:
        links = self.links.items()
        texts = [(name and f"Link {name}: ") + each for name, link in links for each in link.faults]
        # a decoder gives its faults no other identity than their sentences
        faults = tuple([Alarm("link.fault", text, {"text": text}) for text in texts])
        self._own.see_link_faults(faults)
