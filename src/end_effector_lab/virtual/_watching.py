"""A recorder that keeps nothing: somebody follows what the automata see and do, as it happens."""

from __future__ import annotations

from collections.abc import Callable

from end_effector_hal.control import Controller
from end_effector_hal.description import Description
from end_effector_hal.runtime.boundary import Recorder
from end_effector_hal.sensing import FrameJudge
from timed_automata import Network
from timed_automata.execute import Observation

Watch = Callable[[str], Callable[[Observation], None]]
"""Called with the name of a program for each controller that begins; gives what is called with each observation."""


class Watching(Recorder):
    """Shows each controller to a `Watch`."""

    def __init__(self, watch: Watch) -> None:
        super().__init__()
        self._watch = watch

    def controller(
        self, description: Description, network: Network, program: str, judge: FrameJudge | None = None
    ) -> Controller:
        """A new controller, from its beginning on."""
        return Controller(description, network, program, observe=self._watch(program), judge=judge)
