"""A tool in virtual time: its controller and its decoder, and the testbench's device and physics behind the wires."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from end_effector_hal.codecs import get_codec
from end_effector_hal.control import Answer, Controller, Status, network_of
from end_effector_hal.description import Description
from end_effector_hal.runtime.outputs import Maintenance, OutputMapping
from end_effector_hal.signals import Frame
from end_effector_lab.testbench import Bench, SensorBoard, Sent
from timed_automata import Network


class VirtualTool:
    """Frames at the period of the link, commands between them, no clock but its own."""

    def __init__(
        self,
        description: Description,
        scenario: str = "nominal",
        *,
        levels: Mapping[str, bool] | None = None,
        found: Mapping[str, bool] | None = None,
        network: Network | None = None,
        seed: int = 0,
        controller: Callable[[Description, Network], Controller] = Controller,
    ) -> None:
        self.description = description
        self.codec = get_codec(description.link.codec)
        self.controller = controller(description, network or network_of(description))
        self.at = 0
        self.levels = dict(levels or {})
        self.bench = Bench(description, scenario, seed, levels=self.levels)
        self.board = SensorBoard(description, self.bench, 0)
        self.decoder = self.codec.decoder()
        self.statuses: list[Status] = []
        self.edges: list[tuple[int, str, bool]] = []
        self.link = True
        self._mapping = OutputMapping(description, Maintenance(description))
        told = self.levels if found is None else dict(found)  # what the line arbiter says of them
        self._told(self.controller.start(told, 0))

    @property
    def status(self) -> Status:
        return self.controller.status()

    def command(self, name: str, part: str = "") -> Answer:
        answer, statuses = self.controller.command(name, self.at, part)
        self._told(statuses)
        return answer

    def run(self, seconds: float) -> None:
        until = self.at + round(seconds * 1e6)
        while self.at < until:
            frame_at = (self.at // self.codec.period_us + 1) * self.codec.period_us
            self.at = max(self.at, min(self.controller.deadline or until, frame_at, until))
            if self.at == frame_at and self.link:
                sent = self.board.frame(self.at)
                frames = self.decoder.feed(sent.data, self.at)
                self._heard(sent, frames)
                for frame in frames:
                    self._told(self.controller.frame(frame))
            self._told(self.controller.advance(self.at))

    def play(self, *orders: str | float) -> None:
        """Commands that are accepted, and seconds between them: ``play(1.0, "grip box", 3.0)``."""
        for order in orders:
            if isinstance(order, str):
                assert self.command(*order.split()).accepted, order
            else:
                self.run(order)

    def states(self) -> list[tuple[int, int, tuple[int, ...]]]:
        """Changes of (end-effector, command, actuators), as states.csv has them."""
        rows = [(status.ee, status.command, status.actuators) for status in self.statuses]
        return [row for i, row in enumerate(rows) if i == 0 or row != rows[i - 1]]

    def _heard(self, sent: Sent, frames: list[Frame]) -> None:
        """What was sent, and what the decoder has made of it; for those who watch."""

    def _told(self, statuses: list[Status]) -> None:
        for status in statuses:
            self.statuses.append(status)
            if status.adopted:
                self._write(self._mapping.levels(status), status.at)

    def _write(self, wanted: Mapping[str, bool], at: int) -> None:
        for line, level in wanted.items():
            if self.levels.get(line, False) != level:
                self.levels[line] = level
                self.edges.append((at, line, level))
                self.bench.line(line, level, at)
