"""A program: the tool in one process without ROS, with a listener; controlled as an `Application`."""

from __future__ import annotations

import sys

from _application import Application

from end_effector_hal.control import Status
from end_effector_hal.runtime import EndEffector
from end_effector_hal.wires import now_us, tune_interpreter


def main(description: str, notes: str) -> None:
    application = Application(notes)

    def listen(status: Status) -> None:
        application.state(now_us(), status.at, status.ee, status.outputs)

    def command(name: str) -> str:
        outcome = tool.grip() if name == "grip" else tool.drop()
        return "" if outcome.succeeded else f", {outcome.state.name}. {outcome.reason}"

    with EndEffector.open(description) as tool:
        tool.subscribe(listen)
        tool.wait_ready(10.0)
        tune_interpreter()
        application.obey(command)


if __name__ == "__main__":
    main(*sys.argv[1:])
